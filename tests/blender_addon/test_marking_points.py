"""Labelled marking points against points found in the rendered pixels by means that share nothing with the labels.

Around a junction only the free edges of the lines are looked at: the far edge of a T's bar, the edge of its stem on the
obtuse side, the outer edges of an L. Each edge is located by the amount of paint across it, a cubic is laid through it
and moved inwards by half the line's measured width, and the two centre lines are brought to cross.
"""

import attrs
import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from pavemark.ground import Frame
from pavemark.labels.truth import truth
from pavemark.plan import plan
from pavemark.scene import Blend, Curvature, Scene
from scenes import plate, row

SCALE = 150
"""Pixels a metre of the large renders: 2.5 times the normal 60."""

REACH = 0.22
"""Metres along a line that are looked at: short against the bends."""


class Junction:
    """The paint around one point, sampled in metres."""

    def __init__(self, alpha: np.ndarray, frame: Frame, guess: np.ndarray) -> None:
        self.alpha, self.frame, self.guess = alpha, frame, guess

    def sample(self, world: np.ndarray) -> np.ndarray:
        u, v = np.moveaxis(self.frame.to_image(world) - 0.5, -1, 0)
        return map_coordinates(self.alpha, [v, u], order=1, cval=0.0)

    def paint(self, arm: np.ndarray, side: np.ndarray, along: np.ndarray, reach: float) -> np.ndarray:
        """Metres of paint from the guessed centre line out to `reach` on one side, at distances `along` an arm."""
        step = reach / 200
        out = (np.arange(200) + 0.5) * step
        at = self.guess + along[:, None, None] * arm + out[None, :, None] * side
        return self.sample(at).sum(1) * step


def find(alpha: np.ndarray, frame: Frame, guess: np.ndarray, entrance: np.ndarray, stem: np.ndarray, shape: str):
    """The crossing of the centre lines near a guess, world metres.

    `entrance` and `stem` are rough unit directions of the arms; of a T, the bar runs both ways along `entrance`.
    """
    junction = Junction(alpha, frame, guess)

    def normal(arm, away_from):
        turned = np.array((-arm[1], arm[0]))
        return turned if turned @ away_from < 0 else -turned

    def width(arm):
        side = normal(arm, np.zeros(2))
        along = np.linspace(0.26, 0.36, 12)
        return np.median(junction.paint(arm, side, along, 0.14) + junction.paint(arm, -side, along, 0.14))

    bar_free = normal(entrance, stem)
    bar_width = width(entrance)
    along = np.linspace(-REACH if shape == "T" else -0.01, REACH, 151)
    bar = np.polynomial.Polynomial.fit(along, junction.paint(entrance, bar_free, along, 0.2) - bar_width / 2, 3)

    stem_width = width(stem)
    lean = entrance @ stem
    if shape == "T":
        # On the obtuse side the stem's edge is free almost down to the bar: from where sections across it end clear.
        side = normal(stem, entrance if lean > 0 else -entrance)
        reach = stem_width / 2 + np.linspace(-0.02, 0.03, 11)
        tries = np.arange(0.0, 0.4, 0.004)
        section = tries[:, None, None] * stem + reach[:, None] * side
        across, height = section @ entrance, -(section @ bar_free)
        bar_edge = bar_width / 2 * np.sqrt(1 + bar.deriv()(across) ** 2) - bar(across)
        start = tries[np.argmax((height > bar_edge + 0.012).all(1))]
        along = np.linspace(start, start + REACH, 126)
        rod_edge = junction.paint(stem, side, along, reach[-1])
    else:
        side = normal(stem, entrance)
        along = np.linspace(-0.01, REACH, 151)
        rod_edge = junction.paint(stem, side, along, 0.2)
    rod = np.polynomial.Polynomial.fit(along, rod_edge - stem_width / 2, 3)

    # Where the bar's point guess + a·entrance + bar(a)·free meets the stem's guess + b·stem + rod(b)·side.
    a = b = 0.0
    for _ in range(20):
        a, b = np.linalg.solve(np.stack([entrance, -stem], 1), rod(b) * side - bar(a) * bar_free)
    return guess + a * entrance + bar(a) * bar_free


def random_row(rng: np.random.Generator) -> Scene:
    """Rows of all kinds, of every outline with an entrance line, bent or not, all points within the frame."""
    kind, low, high, entrance, depth = [
        ("perpendicular", 90, 90, 2.5, 4.7),
        ("parallel", 90, 90, 5.0, 2.0),
        ("slanted", 60, 70, 2.7, 4.5),
        ("slanted", 115, 130, 2.7, 4.5),
    ][rng.integers(4)]
    bent = Curvature(rng.uniform(100, 200), rng.uniform(0.3, 0.7), int(rng.integers(2**31)))
    return row(
        plate(),
        n=1 if kind == "parallel" else int(rng.integers(1, 4)),
        kind=kind,
        angle=rng.uniform(low, high),
        outline=["closed", "half-closed", "corner"][rng.integers(3)],
        entrance=entrance,
        depth=depth,
        start=(rng.uniform(-2, 1), 3.6),
        heading=-90 + rng.uniform(-8, 8),
        width=rng.uniform(0.08, 0.2),
        curvature=bent if rng.random() < 0.7 else None,
    )


def errors(renderer, scene: Scene) -> list[float]:
    """Distances in pixels at 60 px/m between labelled and found points."""
    frame = scene.plate.frame
    labelled = truth(scene, np.ones((frame.height, frame.width), bool))
    large = Frame(10 * SCALE, 10 * SCALE, SCALE)
    enlarged = attrs.evolve(scene, plate=attrs.evolve(scene.plate, frame=large))
    alpha = renderer.render(enlarged, plate(large), plan(enlarged)).decals[..., 3]
    found = []
    for slot in labelled.slots:
        # What is labelled goes in only as a guess, rounded to a centimetre and a few degrees.
        corners = frame.to_world(np.array(slot.corners))
        for mark, at, other, behind in ((0, 0, 1, 3), (1, 1, 0, 2)):
            guess = np.round(corners[at], 2)
            entrance, stem = (unit(corners[to] - corners[at]) for to in (other, behind))
            shape = labelled.marks[slot.entrance[mark]].shape
            measured = find(alpha, large, guess, entrance, stem, shape)
            found.append(60 * float(np.hypot(*(measured - corners[at]))))
    return found


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.hypot(*v)


def check(renderer, count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    found = np.array([e for _ in range(count) for e in errors(renderer, random_row(rng))])
    median, most = np.quantile(found, (0.5, 0.95))
    print(f"{len(found)} points: median {median:.3f}, 95 % {most:.3f}, worst {found.max():.3f} px")
    assert len(found) >= 2 * count
    assert found.max() <= 0.15


def test_marking_points_of_eight_scenes(renderer):
    check(renderer, 8, 1)


@pytest.mark.slow
def test_marking_points_of_200_scenes(renderer):
    check(renderer, 200, 2)


def test_a_moved_label_is_noticed(renderer):
    """The measurement is no echo of the label: a label 0.5 px off is found 0.5 px off."""
    scene = row(plate(), n=2, outline="closed", blend=Blend())
    shifted = attrs.evolve(
        scene, slots=tuple(attrs.evolve(s, corners=tuple((x + 0.5 / 60, y) for x, y in s.corners)) for s in scene.slots)
    )
    assert max(errors(renderer, scene)) < 0.05
    assert errors(renderer, shifted) == pytest.approx([0.5] * 4, abs=0.05)
