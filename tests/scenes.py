"""Hand-made plates and scenes for tests: every number in them is known."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.ground import Frame
from pavemark.plan import Pass, plan
from pavemark.plate import Plate
from pavemark.scene import Blend, Curvature, Marking, Paint, PlateRef, Scene, Slot, Stroke

WHITE = Paint(rgb=(210.0, 210.0, 205.0), ratio=(2.4, 2.4, 2.3))
CAR = (2.0, 4.7)


def plate(
    frame: Frame | None = None,
    tone: int = 96,
    texture: float = 0.0,
    car: tuple[float, float] | None = None,
    name: str = "asphalt",
) -> Plate:
    """Asphalt of one `tone`, with `texture` grey levels of grain, and a black car of `car` metres at its centre."""
    frame = frame or Frame()
    grain = np.random.default_rng(0).normal(0.0, texture, (frame.height, frame.width, 1))
    image = np.clip(np.rint(tone + np.broadcast_to(grain, (frame.height, frame.width, 3))), 0, 255).astype(np.uint8)
    ground = np.ones((frame.height, frame.width), bool)
    if car is not None:
        x, y = np.moveaxis(frame.pixel_centres(), -1, 0)
        ground &= (np.abs(x) >= car[0] / 2) | (np.abs(y) >= car[1] / 2)
        image[~ground] = 0
    return Plate(name, frame, image, ground, np.zeros_like(ground), image.copy())


def row(
    on: Plate | PlateRef | None = None,
    n: int = 3,
    kind: str = "perpendicular",
    angle: float = 90.0,
    outline: str = "closed",
    entrance: float = 2.6,
    depth: float = 5.0,
    start: tuple[float, float] | None = None,
    heading: float = -90.0,
    width: float = 0.1,
    paint: Paint = WHITE,
    curvature: Curvature | None = None,
    blend: Blend | None = None,
    index: int = 0,
) -> Scene:
    """A row of `n` slots beside a roadside, one marking, entrance line and shared separating lines painted once.

    Parameters
    ----------
    angle : float
        Degrees, anticlockwise from the entrance direction p1 → p2 to the separating line.
    entrance, depth : float
        Metres along the entrance line and along the separating line, of one slot.
    start : tuple of float
        p1 of the first slot; by default the row is centred up and down, right of where the car stands.
    heading : float
        Degrees of the entrance direction, anticlockwise from world X. At -90 the slots lie right of the roadside.
    """
    e = _unit(heading)
    s = _unit(heading + angle)
    first = np.array((1.6, n * entrance / 2) if start is None else start)
    front = [first + k * entrance * e for k in range(n + 1)]
    back = [point + depth * s for point in front]
    slots = tuple(
        Slot(
            corners=tuple(map(_pair, (front[k], front[k + 1], back[k + 1], back[k]))),
            kind=kind,
            marks=("L" if k == 0 else "T", "L" if k == n - 1 else "T"),
            outline=outline,
        )
        for k in range(n)
    )
    on = plate() if on is None else on
    return Scene(
        index=index,
        plate=on if isinstance(on, PlateRef) else on.ref,
        markings=(Marking("slot", paint, tuple(_strokes(outline, front, back, e, s, width))),) if n else (),
        slots=slots,
        curvature=curvature,
        blend=blend or Blend(),
    )


def together(first: Scene, *others: Scene) -> Scene:
    """Scenes on one plate as one: the markings and slots of all, everything else from the first."""
    scenes = (first, *others)
    return attrs.evolve(
        first,
        markings=tuple(marking for scene in scenes for marking in scene.markings),
        slots=tuple(slot for scene in scenes for slot in scene.slots),
    )


def rendered(renderer, scene: Scene, samples: int = 1) -> np.ndarray:
    """The decals (H, W, 4) that a renderer draws of a scene, with so many rays a pixel."""
    planned = attrs.evolve(plan(scene), passes=(Pass("decals", samples),))
    return renderer.render(scene, plate(scene.plate.frame), planned).decals


def painted(frame: Frame, *markings: Marking, curvature: Curvature | None = None, blend: Blend | None = None) -> Scene:
    """A scene of markings alone."""
    return attrs.evolve(row(plate(frame), n=0, curvature=curvature, blend=blend), markings=markings)


def _strokes(outline, front, back, e, s, width):
    inner = list(zip(front, back, strict=True))[1:-1]
    if outline == "closed":
        yield _stroke(width, front[0], front[-1], back[-1], back[0], closed=True)
    elif outline == "half-closed":
        yield _stroke(width, back[0], front[0], front[-1], back[-1])
    elif outline == "open":
        yield _stroke(width, front[0], back[0], back[-1], front[-1])
    else:
        arm = 0.4
        yield _stroke(width, front[0] + arm * s, front[0], front[0] + arm * e)
        yield _stroke(width, front[-1] - arm * e, front[-1], front[-1] + arm * s)
        for point, _ in inner:
            yield _stroke(width, point - arm * e, point + arm * e)
            yield _stroke(width, point, point + arm * s)
        return
    for point, behind in inner:
        yield _stroke(width, point, behind)


def _stroke(width, *points, closed=False):
    return Stroke(tuple(map(_pair, points)), width, closed)


def _pair(point: np.ndarray) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _unit(degrees: float) -> np.ndarray:
    return np.array((math.cos(math.radians(degrees)), math.sin(math.radians(degrees))))
