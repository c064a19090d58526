"""How well free ground is found: intersection over union with ground outlined by hand or known exactly."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
import shapely

from pavemark.ground import Frame
from pavemark.records import one_of, within
from pavemark.scene import Point

THINGS = ("ego", "car", "wall", "pillar", "kerb", "lawn", "bush", "stop", "bump", "post", "unsure")
"""What an outline may be of; what is "unsure" is not judged."""


@attrs.frozen
class Outline:
    """Something that stands on the ground.

    Attributes
    ----------
    what : str
        One of THINGS.
    polygon : tuple of Point
        Image coordinates, continuous.
    """

    what: str = attrs.field(validator=one_of(*THINGS))
    polygon: tuple[Point, ...] = attrs.field()


@attrs.frozen
class Outlined:
    """An image whose ground was outlined by hand: what lies in no outline is free.

    Attributes
    ----------
    image : str
        Its path below the folder of the data.
    width, height : int
        Pixels.
    scale : float
        Pixels per metre.
    outlines : tuple of Outline
    """

    image: str
    width: int = attrs.field(validator=within(8, 16384))
    height: int = attrs.field(validator=within(8, 16384))
    scale: float = attrs.field(validator=within(1.0, 10000.0))
    outlines: tuple[Outline, ...]

    @property
    def frame(self) -> Frame:
        """The image's frame."""
        return Frame(self.width, self.height, self.scale)


@attrs.frozen(eq=False)
class Truth:
    """Where an image has free ground.

    Attributes
    ----------
    ground : ndarray (H, W) bool
    ego : ndarray (H, W) bool
        The ego car: not ground, and not hard to find.
    judged : ndarray (H, W) bool
        Where it is known.
    """

    ground: np.ndarray
    ego: np.ndarray
    judged: np.ndarray


@attrs.frozen
class Overlap:
    """How found ground compares with the true.

    Attributes
    ----------
    ground : float
        Intersection over union of the ground, over all that is judged.
    beside_ego : float
        The same without the ego car's pixels.
    things : float
        Intersection over union of what is not ground, without the ego car's pixels; nan where there is nothing, found
        or true.
    painted : float
        Share of the true things' pixels that are taken for ground, where paint would lie on them; nan without things.
    lost : float
        Share of the true ground that is not found.
    """

    ground: float
    beside_ego: float
    things: float
    painted: float
    lost: float


def truth(outlined: Outlined) -> Truth:
    """The outlines as masks: a pixel is in a polygon where its centre is."""
    u, v = np.meshgrid(np.arange(outlined.width) + 0.5, np.arange(outlined.height) + 0.5)

    def covered(kinds: Sequence[str]) -> np.ndarray:
        shapes = [shapely.make_valid(shapely.Polygon(o.polygon)) for o in outlined.outlines if o.what in kinds]
        return shapely.contains_xy(shapely.union_all(shapes), u, v)

    things = covered([what for what in THINGS if what != "unsure"])
    return Truth(~things, covered(["ego"]), things | ~covered(["unsure"]))


def compare(found: np.ndarray, true: Truth) -> Overlap:
    """Compare found ground (H, W) bool with the true.

    Examples
    --------
    >>> ground = np.array([[True, True, False, False]])
    >>> known = Truth(ground, np.array([[False, False, False, True]]), np.ones_like(ground))
    >>> compare(np.array([[True, True, True, False]]), known)
    Overlap(ground=0.6666666666666666, beside_ego=0.6666666666666666, things=0.0, painted=1.0, lost=0.0)
    """
    beside = true.judged & ~true.ego
    ground, things = true.ground & beside, ~true.ground & beside
    return Overlap(
        ground=_overlap(found & true.judged, true.ground & true.judged),
        beside_ego=_overlap(found & beside, ground),
        things=_overlap(~found & beside, things),
        painted=_share(found, things),
        lost=_share(~found, ground),
    )


def _overlap(found: np.ndarray, true: np.ndarray) -> float:
    union = np.count_nonzero(found | true)
    return float(np.count_nonzero(found & true) / union) if union else float("nan")


def _share(part: np.ndarray, whole: np.ndarray) -> float:
    count = np.count_nonzero(whole)
    return float(np.count_nonzero(part & whole) / count) if count else float("nan")
