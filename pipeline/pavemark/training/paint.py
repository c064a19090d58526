"""Markings of our own: slots, lanes, zebras, arrows, figures; where they lie, and what paint is left of them."""

from __future__ import annotations

import attrs
import cv2
import numpy as np

from pavemark.training.canvas import SIDE, Stencil, clouds, speckle

FAINTEST = 1.18
"""Least ratio of paint to floor, in linear light: what nobody can see cannot be learnt."""

INLAID = 0.12
"""Share of coats that are no paint but stones laid into the floor, where it has a pattern that they break."""

ROUGH = 0.2
"""Deviation of such a floor's reflectance, as a share of its mean."""


@attrs.frozen(eq=False)
class Row:
    """Slots side by side.

    Attributes
    ----------
    origin, along, into : ndarray (2,)
        A point of the entrance line in pixels, its direction, and that of the separating lines, as unit vectors.
    entrance, depth : float
        Pixels.
    """

    origin: np.ndarray
    along: np.ndarray
    into: np.ndarray
    entrance: float
    depth: float

    def at(self, along: float, into: float = 0.0) -> np.ndarray:
        """A point, given in pixels along the two directions."""
        return self.origin + along * self.along + into * self.into

    @property
    def starts(self) -> np.ndarray:
        """Where slots start along the entrance line, in pixels."""
        count = int(np.ceil(SIDE / self.entrance)) + 1
        return np.arange(-count, count + 1) * self.entrance


def rows(rng: np.random.Generator, scale: float, turn: float) -> tuple[Row, ...]:
    """Draw where slots lie: none, one row, or two that face each other."""
    count = int(rng.choice(3, p=(0.25, 0.45, 0.3)))
    sides = rng.permutation([-1, 1])[:count]
    parallel = rng.random() < 0.25
    slant = rng.uniform(-0.7, 0.7) if rng.random() < 0.25 and not parallel else 0.0
    found = []
    for side in sides:
        along = np.array([np.cos(turn), np.sin(turn)]) * side
        normal = np.array([-along[1], along[0]])
        into = normal * np.cos(slant) + along * np.sin(slant)
        distance = rng.uniform(0.7, 4.2) * scale
        entrance, depth = (rng.uniform(4.8, 6.5), rng.uniform(1.9, 2.6)) if parallel else (
            rng.uniform(2.2, 3.1), rng.uniform(4.5, 6.0))  # fmt: skip
        origin = np.full(2, SIDE / 2) + normal * distance + along * rng.uniform(0, entrance) * scale
        found.append(Row(origin, along, into, entrance * scale, depth * scale))
    return tuple(found)


def sample(
    rng: np.random.Generator, scale: float, turn: float, slots: tuple[Row, ...], crossing: bool = False
) -> list[np.ndarray]:
    """Draw markings; those of a street rather than of a car park at a `crossing`.

    Returns
    -------
    list of ndarray (SIDE, SIDE) float32
        The coverage of each coat; the paint of a coat is one colour.
    """
    coats = []
    width = np.exp(rng.uniform(np.log(0.06), np.log(0.2))) * scale
    for row in () if crossing else slots:
        if rng.random() < 0.88:
            stencil = Stencil()
            _slots(rng, stencil, row, width, scale)
            coats.append(stencil.coverage())
        if rng.random() < 0.35:
            stencil = Stencil()
            _figures(rng, stencil, row, scale)
            coats.append(stencil.coverage())
    others = (_lanes, _lanes, _zebra, _zebra, _arrow, _arrow, _words, _hatching, _curve, _strokes, _box)
    if crossing:
        others = (_zebra, _zebra, _arrow, _lanes, _words)
    for _ in range(int(rng.choice(4, p=(0.3, 0.4, 0.2, 0.1) if slots and not crossing else (0.1, 0.35, 0.35, 0.2)))):
        stencil = Stencil()
        others[int(rng.integers(len(others)))](rng, stencil, scale, turn)
        coats.append(stencil.coverage())
    return coats


def _slots(rng, stencil, row, width, scale):
    outline = str(rng.choice(["closed", "half", "half", "open", "corner", "tee", "boxes"]))
    tee = rng.uniform(0.15, 0.5) * scale
    dashes = rng.random() < 0.1
    gap = rng.uniform(0.15, 0.5) * scale if outline == "boxes" else 0.0
    doubled = width * rng.uniform(2, 3.5) if rng.random() < 0.1 else 0.0
    skipped = rng.random() * 0.15

    def line(a, b, wide=width):
        pieces = _dashed(a, b, 0.5 * scale, 0.35 * scale) if dashes else [(a, b)]
        for start, end in pieces:
            stencil.line(np.array([start, end]), wide)

    starts = row.starts
    if outline in ("closed", "half") and rng.random() < 0.9:
        ends = (row.at(starts[0]), row.at(starts[-1]))
        line(*ends)
        if rng.random() < 0.12:
            aside = -rng.uniform(2, 5) * width
            line(row.at(starts[0], aside), row.at(starts[-1], aside))
    if outline == "closed":
        line(row.at(starts[0], row.depth), row.at(starts[-1], row.depth))
    filled = rng.random() < 0.06
    for start in starts:
        if rng.random() < skipped:
            continue
        if outline == "boxes":
            a, b = start + gap / 2, start + row.entrance - gap / 2
            stencil.line(np.array([row.at(a), row.at(b), row.at(b, row.depth), row.at(a, row.depth)]), width, True)
            continue
        deep = row.depth if outline != "corner" else rng.uniform(0.3, 1.0) * scale
        for shift in (-doubled / 2, doubled / 2) if doubled else (0.0,):
            line(row.at(start + shift), row.at(start + shift, deep))
        if outline in ("corner", "tee"):
            line(row.at(start - tee), row.at(start + tee))
        if filled:
            corner = [row.at(start), row.at(start + tee), row.at(start, tee)]
            stencil.polygon(np.array(corner))


def _dashed(a, b, mark, gap):
    length = float(np.hypot(*(b - a)))
    along = (b - a) / max(length, 1e-6)
    return [(a + along * s, a + along * min(s + mark, length)) for s in np.arange(0, length, mark + gap)]


_FONTS = (
    cv2.FONT_HERSHEY_SIMPLEX, cv2.FONT_HERSHEY_DUPLEX, cv2.FONT_HERSHEY_COMPLEX, cv2.FONT_HERSHEY_PLAIN,
    cv2.FONT_HERSHEY_TRIPLEX,
)  # fmt: skip
_LETTERS = np.array(list("0123456789ABCDEFGHKLNPRSTXZ-"))


def _written(rng: np.random.Generator, text: str) -> np.ndarray:
    """A word, white on black, (h, w) uint8, 60 px high or so."""
    font, thick = int(rng.choice(_FONTS)), int(rng.integers(3, 9))
    (wide, high), below = cv2.getTextSize(text, font, 2.2, thick)
    sheet = np.zeros((high + below + 12, wide + 12), np.uint8)
    cv2.putText(sheet, text, (6, high + 6), font, 2.2, 255, thick, cv2.LINE_AA)
    return sheet


def _laid(sheet: np.ndarray, centre: np.ndarray, right: np.ndarray, height: float, stretch: float) -> np.ndarray:
    """The affine map that lays a word with its middle at `centre`, reading along `right`, `height` pixels tall."""
    down = np.array([-right[1], right[0]])
    size = height / sheet.shape[0]
    linear = np.stack([right * size * stretch, down * size], 1)
    return np.hstack([linear, (centre - linear @ (np.array(sheet.shape[::-1]) / 2))[:, None]])


def _figures(rng, stencil, row, scale):
    height, behind = rng.uniform(0.25, 0.9) * scale, rng.uniform(0.5, 1.3) * scale
    sign = rng.choice([-1, 1])
    upright = rng.random() < 0.3
    count = int(rng.integers(1, 6))
    prefix = "".join(rng.choice(_LETTERS, count))
    right = (row.into if upright else row.along) * sign
    for number, start in enumerate(row.starts):
        middle = row.at(start + row.entrance / 2, behind)
        if (middle > -height).all() and (middle < SIDE + height).all():
            word = _written(rng, (prefix + str(number))[-max(2, count) :])
            stencil.picture(word, _laid(word, middle, right, height, 1.0))


def _place(rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(0.05, 0.95, 2) * SIDE


def _frame(rng: np.random.Generator, turn: float) -> tuple[np.ndarray, np.ndarray]:
    """Two perpendicular unit vectors, mostly along the rows."""
    angle = turn + rng.integers(4) * np.pi / 2 + rng.normal(0, 0.05) if rng.random() < 0.8 else rng.uniform(0, 7)
    along = np.array([np.cos(angle), np.sin(angle)])
    return along, np.array([-along[1], along[0]])


def _lanes(rng, stencil, scale, turn):
    along, across = _frame(rng, turn)
    width = rng.uniform(0.08, 0.25) * scale
    centre = _place(rng)
    for k in range(int(rng.choice([1, 1, 1, 2, 2, 3]))):
        aside = centre + across * k * width * rng.uniform(1.8, 4)
        a, b = aside - along * SIDE * 1.5, aside + along * SIDE * 1.5
        if rng.random() < 0.5:
            for start, end in _dashed(a, b, rng.uniform(0.4, 4) * scale, rng.uniform(0.4, 4) * scale):
                stencil.line(np.array([start, end]), width)
        else:
            stencil.line(np.array([a, b]), width)


def _zebra(rng, stencil, scale, turn):
    along, across = _frame(rng, turn)
    centre, count = _place(rng), int(rng.integers(3, 12))
    wide, step, long = rng.uniform(0.3, 0.7) * scale, rng.uniform(0.6, 1.2) * scale, rng.uniform(1.5, 4.5) * scale
    for k in range(count):
        start = centre + across * (k - count / 2) * max(step, 1.4 * wide)
        stencil.line(np.array([start - along * long / 2, start + along * long / 2]), wide)
    if rng.random() < 0.4:
        start = centre - along * (long / 2 + rng.uniform(0.5, 1.5) * scale)
        stencil.line(np.array([start - across * SIDE, start + across * SIDE]), rng.uniform(0.15, 0.45) * scale)


def _arrow(rng, stencil, scale, turn):
    along, across = _frame(rng, turn)
    tail, long = _place(rng), rng.uniform(0.8, 3.5) * scale
    wide, head = rng.uniform(0.08, 0.25) * scale, rng.uniform(0.2, 0.5) * scale
    if rng.random() < 0.5:
        neck = tail + along * long
    else:
        bend = tail + along * long * 0.6
        side = across * rng.choice([-1, 1])
        stencil.line(np.array([tail, bend + along * wide / 2]), wide)
        tail, along, across = bend, side, along
        neck = bend + side * rng.uniform(0.3, 1.0) * scale
    stencil.line(np.array([tail, neck]), wide)
    stencil.polygon(np.array([neck + across * head, neck + along * head * rng.uniform(1, 3.0), neck - across * head]))


def _words(rng, stencil, scale, turn):
    along, _ = _frame(rng, turn)
    text = "".join(rng.choice(_LETTERS, int(rng.integers(1, 6))))
    word = _written(rng, text)
    stencil.picture(word, _laid(word, _place(rng), along, rng.uniform(0.3, 2.2) * scale, rng.uniform(0.4, 1.2)))


def _hatching(rng, stencil, scale, turn):
    along, across = _frame(rng, turn)
    centre, width = _place(rng), rng.uniform(0.08, 0.2) * scale
    long, wide = rng.uniform(1, 5) * scale, rng.uniform(0.6, 2.5) * scale
    corners = [centre + along * a * long / 2 + across * b * wide / 2 for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    slope = along * rng.choice([-1, 1]) * rng.uniform(0.3, 1.2) * wide
    for s in np.arange(-long / 2, long / 2, rng.uniform(0.3, 0.9) * scale):
        start = centre + along * s - across * wide / 2
        stencil.line(np.array([start, start + across * wide + slope]), width)
    if rng.random() < 0.7:
        stencil.line(np.array(corners), width, True)


def _curve(rng, stencil, scale, turn):
    along, across = _frame(rng, turn)
    t = np.linspace(-1, 1, 24)[:, None]
    path = _place(rng) + along * t * rng.uniform(1.5, 6) * scale + across * t**2 * rng.uniform(-3, 3) * scale
    width = rng.uniform(0.07, 0.22) * scale
    stencil.line(path, width)
    if rng.random() < 0.3:
        stencil.line(path + across * width * rng.uniform(2, 3.5), width)


def _strokes(rng, stencil, scale, turn):
    for _ in range(int(rng.integers(1, 5))):
        along, _ = _frame(rng, turn)
        start = _place(rng)
        end = start + along * rng.uniform(0.5, 5) * scale
        stencil.line(np.array([start, end]), rng.uniform(0.06, 0.22) * scale)


def _box(rng, stencil, scale, turn):
    along, across = _frame(rng, turn)
    centre, width = _place(rng), rng.uniform(0.06, 0.18) * scale
    long, wide = rng.uniform(0.5, 5) * scale, rng.uniform(0.5, 2.5) * scale
    corners = [centre + along * a * long / 2 + across * b * wide / 2 for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    stencil.line(np.array(corners), width, True)
    if rng.random() < 0.4:
        stencil.line(np.array([corners[0], corners[2]]), width)
        stencil.line(np.array([corners[1], corners[3]]), width)


_COLOURS = {
    "white": ((0.75, 0.75, 0.73), 0.6),
    "yellow": ((0.62, 0.42, 0.06), 0.25),
    "orange": ((0.60, 0.30, 0.07), 0.07),
    "tan": ((0.50, 0.38, 0.20), 0.04),
    "blue": ((0.08, 0.18, 0.50), 0.02),
    "red": ((0.45, 0.05, 0.04), 0.02),
}


def colour(rng: np.random.Generator) -> np.ndarray:
    """Draw the reflectance of a coat of paint, (3,)."""
    names = list(_COLOURS)
    name = str(rng.choice(names, p=[_COLOURS[n][1] for n in names]))
    return np.array(_COLOURS[name][0]) * rng.uniform(0.55, 1.2) * (1 + rng.normal(0, 0.05, 3))


def laid_on(
    rng: np.random.Generator, albedo: np.ndarray, coat: np.ndarray, paint: np.ndarray, inlaid: float = INLAID
) -> np.ndarray:
    """The floor with a coat of paint, old or fresh.

    Parameters
    ----------
    albedo : ndarray (SIDE, SIDE, 3) float32
        Reflectance.
    coat : ndarray (SIDE, SIDE) float32
        Its coverage.
    paint : ndarray (3,)
        Its reflectance.
    inlaid : float
        Chance that it is no paint but stones, where the floor is ROUGH.
    """
    inside = coat > 0.5
    if not inside.any():
        return albedo
    below = albedo[inside].mean(0)
    if rng.random() < inlaid and albedo[inside].std(0).mean() > ROUGH * below.mean():
        # Stones of the floor's own kind, without its joints and holes.
        paint = np.percentile(albedo[inside], rng.uniform(60, 95), axis=0)
        paint = paint * rng.uniform(0.85, 1.3) * (1 + rng.normal(0, 0.06, 3))
        return _coated(rng, albedo, coat, paint)
    opacity = 1 - rng.beta(1.2, 2.2) * 0.85
    # The channel in which paint and floor differ most must show the coat.
    contrast = np.abs(np.log((opacity * paint + (1 - opacity) * below) / below)).max()
    if contrast < np.log(FAINTEST):
        paint = np.clip(below * np.exp(rng.uniform(0.25, 0.9) / opacity), 0, 0.85) * (1 + rng.normal(0, 0.04, 3))
    kept = coat * opacity
    wear = rng.beta(1, 2)
    if rng.random() < 0.7:
        loss = wear * 2.4 - 1.6 + 0.5 * clouds(rng, rng.uniform(6, 40), 4) + rng.uniform(0, 0.6) * clouds(rng, 4, 2)
        kept = kept * np.clip(1 - loss, 0.12, 1)
    return _coated(rng, albedo, kept, paint)


def _coated(rng: np.random.Generator, albedo: np.ndarray, kept: np.ndarray, paint: np.ndarray) -> np.ndarray:
    """The floor where so much of a coat is kept."""
    texture = 1 + rng.uniform(0, 0.06) * clouds(rng, 20, 4) + rng.uniform(0, 0.06) * speckle(rng)
    if rng.random() < 0.4:
        # Thin paint shows the relief of the floor.
        relief = albedo.mean(-1) / cv2.GaussianBlur(albedo.mean(-1), (0, 0), 4)
        texture = texture * relief ** rng.uniform(0.2, 1.0)
    kept = kept[..., None].astype(np.float32)
    return albedo * (1 - kept) + (paint * texture[..., None]).astype(np.float32) * kept
