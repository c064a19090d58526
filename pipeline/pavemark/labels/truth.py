"""What the labels say of a scene: marking points, slots and markings as they lie in the picture."""

from __future__ import annotations

import math

import attrs
import numpy as np
import shapely
from shapely.geometry import MultiPolygon, Polygon

from pavemark.geometry.elastic import displace, jacobian
from pavemark.geometry.outline import bend, outline, polygons
from pavemark.ground import Frame
from pavemark.scene import Point, Scene

SAME_POINT = 1e-3
"""Metres: corners of two slots that lie closer than this, before the curvature, are one marking point."""

LABELLED = ("slot", "original", "aisle", "symbol")
"""Kinds of marking that are labelled; a "former" coat, a painted "floor" and a "stop" are background."""

OUTSIDE, HIDDEN, VISIBLE = 0, 1, 2


@attrs.frozen
class MarkingPoint:
    """A marking point in the picture.

    Attributes
    ----------
    point : Point
        Image coordinates, continuous.
    direction : Point
        Unit vector in image coordinates (y down). T: along the stem, into the slot. L: the arm from which the other
        arm is found by a quarter turn clockwise on the screen; at p1 that is the separating line into the slot, at
        p2 the entrance line towards p1.
    shape : str
        "T" or "L".
    visible : bool
        Whether it lies inside the frame and on ground.
    """

    point: Point
    direction: Point
    shape: str
    visible: bool


@attrs.frozen(eq=False)
class ParkingSlot:
    """A slot in the picture.

    Attributes
    ----------
    entrance : tuple of int
        Positions in `Truth.marks` of p1 and p2; the slot lies to the left of p1 → p2.
    corners : tuple of 4 Point
        p1 … p4 in image coordinates; they may lie outside the frame.
    visibility : tuple of 4 int
        For each corner OUTSIDE the frame, HIDDEN (under what is not ground, or nothing painted there) or VISIBLE.
    kind, outline : str
        As in the scene.
    marks : tuple of str
        "T" or "L" at p1 and p2.
    angle : float
        Degrees from the entrance line p1 → p2 to the separating lines, anticlockwise as seen; 90 is right-angled.
    area : Polygon
        The slot's floor after the curvature, world metres.
    region : MultiPolygon
        The part of it inside the frame, image coordinates; may be empty.
    """

    entrance: tuple[int, int]
    corners: tuple[Point, Point, Point, Point]
    visibility: tuple[int, int, int, int]
    kind: str
    outline: str
    marks: tuple[str, str]
    angle: float
    area: Polygon
    region: MultiPolygon

    @property
    def paired(self) -> bool:
        """Whether both marking points are visible: what ps2.0 and DMPR list as a slot."""
        return self.visibility[:2] == (VISIBLE, VISIBLE)

    @property
    def seen(self) -> bool:
        """Whether at least one marking point and some floor are visible: what COCO and YOLO list as a slot."""
        return VISIBLE in self.visibility[:2] and not self.region.is_empty


@attrs.frozen(eq=False)
class Truth:
    """The truth of one image.

    Attributes
    ----------
    index : int
        Number of the image in its job.
    frame : Frame
    ground : ndarray (H, W) bool
        Where paint may lie.
    marks : tuple of MarkingPoint
        Each once, also where two slots share it; the unseen ones too.
    slots : tuple of ParkingSlot
        All slots of the scene, in its order.
    markings : tuple of (str, MultiPolygon)
        Kind and outline (world, metres) of the labelled markings, in the scene's order.
    """

    index: int
    frame: Frame
    ground: np.ndarray
    marks: tuple[MarkingPoint, ...]
    slots: tuple[ParkingSlot, ...]
    markings: tuple[tuple[str, MultiPolygon], ...]


def truth(scene: Scene, ground: np.ndarray) -> Truth:
    """The truth of a scene.

    Parameters
    ----------
    scene : Scene
    ground : ndarray (H, W) bool
        Of the scene's plate.

    Returns
    -------
    Truth
    """
    frame, curvature = scene.plate.frame, scene.curvature
    markings = tuple((m.kind, outline(m, curvature)) for m in scene.markings if m.kind in LABELLED)
    if not scene.slots:
        return Truth(scene.index, frame, ground, (), (), markings)
    corners = np.array([slot.corners for slot in scene.slots])
    uv = frame.to_image(displace(curvature, corners))
    visibility = np.where(_on(ground, uv, frame.contains(uv)), VISIBLE, np.where(frame.contains(uv), HIDDEN, OUTSIDE))
    unpainted = np.array([slot.outline == "corner" for slot in scene.slots])
    visibility[unpainted, 2:] = np.minimum(visibility[unpainted, 2:], HIDDEN)

    shapes = [shape for slot in scene.slots for shape in slot.marks]
    which, chosen = _merged(corners[:, :2].reshape(-1, 2), shapes)
    directions = _directions(scene, corners).reshape(-1, 2)
    points = uv[:, :2].reshape(-1, 2)
    marks = tuple(
        MarkingPoint(_pair(points[k]), _pair(directions[k]), shapes[k], bool(visibility[:, :2].flat[k] == VISIBLE))
        for k in chosen
    )
    areas = bend(shapely.polygons(corners), curvature)
    regions = shapely.clip_by_rect(shapely.transform(areas, frame.to_image), 0, 0, frame.width, frame.height)
    slots = []
    for k, slot in enumerate(scene.slots):
        slots.append(
            ParkingSlot(
                entrance=(which[2 * k], which[2 * k + 1]),
                corners=tuple(_pair(corner) for corner in uv[k]),
                visibility=tuple(visibility[k].tolist()),
                kind=slot.kind,
                outline=slot.outline,
                marks=slot.marks,
                angle=_angle(uv[k]),
                area=areas[k],
                region=polygons(regions[k]),
            )
        )
    return Truth(scene.index, frame, ground, marks, tuple(slots), markings)


def _on(ground: np.ndarray, uv: np.ndarray, inside: np.ndarray) -> np.ndarray:
    u, v = np.where(inside[..., None], uv, 0).astype(np.int64).T
    return inside & ground[v.T, u.T]


def _merged(points: np.ndarray, shapes: list[str]) -> tuple[list[int], list[int]]:
    """For each point the number of its mark, and for each mark the point that describes it.

    A T describes a shared mark before an L does: where a neighbour's line goes on, the junction is a T.
    """
    which: list[int] = []
    chosen: list[int] = []
    places = np.empty((0, 2))
    for k, point in enumerate(points):
        near = np.flatnonzero(np.hypot(*(places - point).T) < SAME_POINT)
        if len(near) == 0:
            places = np.vstack([places, point])
            chosen.append(k)
            which.append(len(chosen) - 1)
        else:
            mark = int(near[0])
            which.append(mark)
            if (shapes[k], shapes[chosen[mark]]) == ("T", "L"):
                chosen[mark] = k
    return which, chosen


def _directions(scene: Scene, corners: np.ndarray) -> np.ndarray:
    """Unit vectors (S, 2, 2) in image coordinates at p1 and p2 of each slot."""
    p1, p2, p3, p4 = corners.transpose(1, 0, 2)
    l_shaped = np.array([slot.marks[1] == "L" for slot in scene.slots])
    arms = np.stack([p4 - p1, np.where(l_shaped[:, None], p1 - p2, p3 - p2)], 1)
    bent = (jacobian(scene.curvature, corners[:, :2]) @ arms[..., None])[..., 0]
    return bent * (1, -1) / np.hypot(bent[..., 0], bent[..., 1])[..., None]


def _angle(uv: np.ndarray) -> float:
    p1, p2, p3, p4 = uv
    entrance, depth = p2 - p1, (p4 - p1) + (p3 - p2)
    # Image coordinates have y down: anticlockwise as seen is the negative turn.
    turn = depth[0] * entrance[1] - depth[1] * entrance[0]
    return math.degrees(math.atan2(turn, entrance @ depth))


def _pair(point: np.ndarray) -> Point:
    return float(point[0]), float(point[1])
