"""Domain shape: what the slots of an image look like, apart from where they lie."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.randomize.fitted import Fitted
from pavemark.randomize.streams import quantile, uniform, weighted
from pavemark.records import interval, within

_share = within(0.0, 1.0)
_weight = within(0.0, 1000.0)


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    perpendicular, parallel, slanted : float
        Weights of the kinds.
    closed, half_closed, open, corner : float
        Weights of the outlines.
    line : tuple of float
        Width of the painted lines, metres.
    entrance, depth : tuple of float
        Factors on the fitted entrance length and depth.
    free_slant : float
        Share of the slanted rows whose angle is drawn from `slant`, to either side, rather than from the fitted one.
    slant : tuple of float
        Degrees between entrance line and separating line.
    leg : tuple of float
        Length in metres of the strokes at the marking points of "corner" outlines.
    long_legs : float
        Share of the "corner" outlines whose separating lines are painted whole.
    back : float
        Share of the "open" outlines that have a back line.
    tee : float
        Share of the rows whose entrance line runs on past the last slot, which makes its L marks T marks.
    tee_length : tuple of float
        Metres by which it then runs on.
    """

    perpendicular: float = attrs.field(default=0.4, validator=_weight)
    parallel: float = attrs.field(default=0.4, validator=_weight)
    slanted: float = attrs.field(default=0.2, validator=_weight)
    closed: float = attrs.field(default=0.2, validator=_weight)
    half_closed: float = attrs.field(default=0.35, validator=_weight)
    open: float = attrs.field(default=0.1, validator=_weight)
    corner: float = attrs.field(default=0.35, validator=_weight)
    line: tuple[float, float] = attrs.field(default=(0.08, 0.2), validator=interval(0.02, 1.0))
    entrance: tuple[float, float] = attrs.field(default=(1.0, 1.0), validator=interval(0.5, 2.0))
    depth: tuple[float, float] = attrs.field(default=(0.95, 1.15), validator=interval(0.5, 2.0))
    free_slant: float = attrs.field(default=0.4, validator=_share)
    slant: tuple[float, float] = attrs.field(default=(35.0, 75.0), validator=interval(20.0, 89.0))
    leg: tuple[float, float] = attrs.field(default=(0.25, 0.5), validator=interval(0.1, 1.0))
    long_legs: float = attrs.field(default=0.5, validator=_share)
    back: float = attrs.field(default=0.5, validator=_share)
    tee: float = attrs.field(default=0.25, validator=_share)
    tee_length: tuple[float, float] = attrs.field(default=(0.3, 1.5), validator=interval(0.05, 10.0))

    def __attrs_post_init__(self) -> None:
        for names in (("perpendicular", "parallel", "slanted"), ("closed", "half_closed", "open", "corner")):
            if not any(getattr(self, name) for name in names):
                raise ValueError(f"{', '.join(names)} are all 0: at least one weight above 0 is allowed")


@attrs.frozen
class Shape:
    """The slots of one row. Lengths in metres.

    Attributes
    ----------
    kind, outline : str
        As in `pavemark.scene.Slot`.
    family : str
        The field of `Fitted` whose rows lie as this one does.
    entrance : float
        Nominal length of the entrance line.
    depth : float
        Along the separating line.
    angle : float
        Radians from p1 → p2 to p1 → p4, anticlockwise.
    line : float
        Width of the painted lines.
    leg : float
        Length of the entrance line's strokes at the marking points of a "corner" outline.
    separator : float
        Painted length of the separating lines, at most `depth`.
    back : bool
        Whether the back line is painted.
    tee : float
        Length by which the entrance line runs on past the row's ends; 0 makes L marks of them.
    """

    kind: str
    outline: str
    family: str
    entrance: float
    depth: float
    angle: float
    line: float
    leg: float
    separator: float
    back: bool
    tee: float

    def mirrored(self) -> Shape:
        """The same row seen in a mirror: slanted the other way."""
        return attrs.evolve(self, angle=math.pi - self.angle)


def sample(rng: np.random.Generator, ranges: Ranges, fitted: Fitted) -> Shape:
    """Draw what the slots of an image look like."""
    kind = weighted(rng, {name: getattr(ranges, name) for name in ("perpendicular", "parallel", "slanted")})
    outline = weighted(
        rng, {"closed": ranges.closed, "half-closed": ranges.half_closed, "open": ranges.open, "corner": ranges.corner}
    )
    slant = weighted(rng, {"acute": fitted.acute.rows, "obtuse": fitted.obtuse.rows})
    family = slant if kind == "slanted" else kind
    of = getattr(fitted, family)
    entrance, angle = quantile(rng, of.entrance), math.radians(quantile(rng, of.angle))
    free, drawn, other_way = rng.random() < ranges.free_slant, uniform(rng, ranges.slant), rng.random() < 0.5
    across = quantile(rng, fitted.perpendicular.entrance)
    if kind == "slanted" and free:
        entrance = across / math.sin(math.radians(drawn))
        angle = math.radians(180.0 - drawn if other_way else drawn)
    entrance *= uniform(rng, ranges.entrance)
    depth = of.depth * uniform(rng, ranges.depth)
    line = uniform(rng, ranges.line)
    leg = uniform(rng, ranges.leg)
    long_legs, back = rng.random() < ranges.long_legs, rng.random() < ranges.back
    tee = uniform(rng, ranges.tee_length) if rng.random() < ranges.tee else 0.0
    return Shape(
        kind=kind,
        outline=outline,
        family=family,
        entrance=entrance,
        depth=depth,
        angle=angle,
        line=line,
        leg=leg,
        separator=leg if outline == "corner" and not long_legs else depth,
        back=outline == "closed" or (outline == "open" and back),
        tee=tee,
    )
