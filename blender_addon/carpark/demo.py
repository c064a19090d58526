"""The views that are shipped as demo images, and how one is made."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from blender_addon.carpark import layout, pavement
from blender_addon.carpark.layout import WHITE, YELLOW, Row
from pavemark.cameras import rig, sensor, stitch
from pavemark.colour import quantise
from pavemark.ground import Frame

GROUND, MARKING, NOT_GROUND = 0, 1, 2
"""Values of a mask."""

HALF = Frame(300, 300, 22.7)
"""A half-view is 96 columns of this: 0.044 m a pixel."""

_deg = np.radians

MIDDLE = stitch.Ego()
SMALL = stitch.Ego(3.8, 1.75, _deg(20), _deg(33))
WIDE = stitch.Ego(4.2, 1.95, _deg(27), _deg(24), feather=0.1, ragged=0.05)
LONG = stitch.Ego(4.7, 1.9, _deg(17), _deg(15), feather=0.005)


@attrs.frozen
class View:
    """A picture to be made.

    Attributes
    ----------
    name : str
    seed : int
    pavement : str
        A key of `pavement.KINDS`.
    light : str
        A key of `LIGHTS` in `__main__`.
    rows : tuple of Row
    turn : float
        Radians between the lane and the car.
    beside : tuple of (kind, side, offset)
        Kerbs, walls and verges along the lane.
    pillars : bool
        Whether the first row has them.
    arrow : tuple of float or None
        Middle of an arrow in the lane.
    trees : tuple of (x, y)
        They stand, or rather float, where their shade falls into the picture.
    camera : int
        Pixels of a camera's picture.
    noise : float
        Noise of the sensors, 1 in daylight.
    exposure : float
        Mean linear light of the pictures.
    ego : Ego
    half : str or None
        "left" or "right" for a half-view.
    """

    name: str
    seed: int
    pavement: str
    light: str
    rows: tuple[Row, ...] = ()
    turn: float = 0.0
    beside: tuple[tuple[str, str, float], ...] = ()
    pillars: bool = False
    arrow: tuple[float, float] | None = None
    trees: tuple[tuple[float, float], ...] = ()
    camera: int = 720
    noise: float = 1.0
    exposure: float = 0.18
    ego: stitch.Ego = MIDDLE
    half: str | None = None

    @property
    def frame(self) -> Frame:
        """The ground that is stitched; a half-view is cut from it."""
        return HALF if self.half else Frame()

    @property
    def folder(self) -> str:
        """Where its images/ and masks/ lie: half-views have a scale, and so a job, of their own."""
        return "half" if self.half else "."


def stream(view: View, stage: int) -> np.random.Generator:
    """A stream of random numbers for each stage of a view."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(view.seed, spawn_key=(stage,))))


VIEWS: tuple[View, ...] = (
    View(
        "asphalt_perpendicular", 11, "asphalt", "sun",
        rows=(Row("right", 2.35, width=0.12, wear=0.15, parked=(-2, 1), shift=0.4),
              Row("left", 2.9, wear=0.3, parked=(-1,))),
        turn=_deg(4), arrow=(-0.9, 4.0), camera=680,
    ),
    View(
        "patched_open", 12, "patched", "overcast", ego=SMALL,
        rows=(Row("left", 2.2, outline="open", wear=0.38, entrance=2.4, shift=0.9, parked=(1,)),),
        turn=_deg(-7), beside=(("kerb", "right", 2.9), ("verge", "right", 3.06)), camera=560,
    ),
    View(
        "brick_slanted", 13, "brick", "sun", ego=SMALL,
        rows=(Row("right", 2.3, slant=_deg(60), entrance=2.8, width=0.14, wear=0.3, parked=(-1,)),),
        turn=_deg(3), trees=((1.5, 6.6), (0.4, 2.2), (5.4, 8.0), (1.2, -1.0)), camera=640,
    ),
    View(
        "tiles_parallel", 14, "tiles", "building", ego=WIDE,
        rows=(Row("right", 2.0, entrance=6.0, depth=2.2, outline="closed",
                  width=0.1, wear=0.34, parked=(0,), shift=-0.5),),
        turn=_deg(-4), beside=(("kerb", "right", 4.6),), camera=560,
    ),
    View(
        "concrete_yellow", 15, "concrete", "sun",
        rows=(Row("left", 2.4, colour=YELLOW, outline="closed", wear=0.25, width=0.1, numbered=True, parked=(-2, 0)),),
        turn=_deg(-2), beside=(("wall", "right", 3.4),), camera=620,
    ),
    View(
        "epoxy_garage", 16, "epoxy", "garage", ego=LONG,
        rows=(Row("right", 2.6, outline="half-closed", wear=0.1, numbered=True, parked=(-1, 2), shift=0.6),
              Row("left", 2.3, wear=0.1, numbered=True, parked=(1,))),
        turn=_deg(2), pillars=True, arrow=(0.3, 4.2), camera=620, noise=1.2,
    ),
    View(
        "epoxy_dim", 17, "epoxy", "dim", ego=WIDE,
        rows=(Row("left", 2.1, outline="corner", wear=0.15, width=0.1, numbered=True, parked=(-1,), shift=0.3),),
        turn=_deg(5), beside=(("wall", "right", 2.9),), camera=520, noise=1.5, exposure=0.09,
    ),
    View(
        "grid_corner", 18, "grid", "overcast", ego=SMALL,
        rows=(Row("left", 2.3, outline="half-closed", colour=YELLOW, wear=0.2, entrance=2.5, parked=(0,)),
              Row("right", 2.5, outline="corner", colour=YELLOW, wear=0.2, parked=(-2,))),
        turn=_deg(-5), camera=640,
    ),
    View(
        "asphalt_bare", 19, "patched", "sun", ego=SMALL, turn=_deg(6),
        beside=(("kerb", "left", 3.3), ("verge", "left", 3.46)), trees=((2.2, 5.5), (4.2, -0.6), (7.0, 6.5)),
        camera=600,
    ),
    View(
        "half_brick_L", 21, "brick", "overcast", half="left",
        rows=(Row("left", 2.1, width=0.12, wear=0.15, parked=(-2, 1), shift=0.3),), turn=_deg(-2), camera=560,
    ),
    View(
        "half_epoxy_R", 22, "epoxy", "garage", half="right",
        rows=(Row("right", 2.3, wear=0.1, numbered=True, parked=(1,), outline="half-closed"),), turn=_deg(3),
        pillars=True, camera=560, noise=1.2,
    ),
    View(
        "half_grid_L", 23, "grid", "sun", ego=LONG, half="left",
        rows=(Row("left", 1.9, colour=YELLOW, wear=0.15, parked=(-2, 0, 1)),), turn=_deg(1), camera=560,
    ),
    View(
        "half_concrete_R", 24, "concrete", "dim", half="right",
        rows=(Row("right", 2.0, slant=_deg(120), entrance=2.8, wear=0.2, parked=(-1,)),), turn=_deg(-3), camera=520,
        noise=1.5, exposure=0.12,
    ),
)  # fmt: skip


def surface(view: View) -> pavement.Surface:
    """The ground of a view with its markings."""
    coats = [layout.painted(row, view.turn) for row in view.rows]
    if view.arrow:
        coats.append(layout.arrow(view.arrow, view.turn, WHITE))
    return pavement.surface(view.pavement, coats, stream(view, 0))


Look = Callable[[rig.Fisheye, rig.Mount, tuple[int, int, int, int]], dict[str, np.ndarray]]


def photograph(view: View, marked: np.ndarray, look: Look) -> tuple[np.ndarray, np.ndarray]:
    """Take the four pictures of a view and stitch them.

    Parameters
    ----------
    view : View
    marked : ndarray (N, N), float32
        The markings of its `surface`.
    look : callable
        Renders one camera, see `stage.look`.

    Returns
    -------
    image : ndarray (H, W, 3), uint8
        Display sRGB.
    mask : ndarray (H, W), uint8
        GROUND, MARKING, NOT_GROUND, stitched the same way. Markings are as sharp far away as they are near, since
        they are looked up where the cameras' rays meet the ground and not in the cameras' pixels.
    """
    rng = stream(view, 2)
    fisheye = rig.Fisheye(view.camera)
    shares = stitch.sectors(view.frame, view.ego)
    black = stitch.silhouette(view.frame, view.ego, rng)
    pictures, ground, seen_at, lies_at = {}, {}, {}, {}
    for side, mount in rig.mounts(view.ego.length - 0.1, view.ego.width - 0.1).items():
        # The stitching believes the nominal mount; the camera hangs a little off it, so lines break at the seams.
        real = rig.loosened(rng, mount, np.radians(0.22))
        electronics = sensor.sample(rng, view.noise, view.exposure)
        seen_at[side] = stitch.lookup(view.frame, fisheye, mount)
        share = np.where(black, 0, shares[side])
        if view.half and not share[:, _columns(view)].any():
            share = shares[side]
        left, top, right, bottom = window = stitch.window(seen_at[side], share, fisheye.size)
        layers = look(fisheye, real, window)
        used = np.zeros((fisheye.size, fisheye.size), bool)
        used[top:bottom, left:right] = True
        pictures[side] = sensor.develop(layers["light"], used & (layers["ground"] > 0.5), electronics)
        ground[side] = layers["ground"]
        rays = fisheye.unproject(seen_at[side])
        lies_at[side] = pavement.FRAME.to_image(real.to_ground(rays)).astype(np.float32)
    image = quantise(stitch.stitch(pictures, seen_at, shares))
    seen_ground = stitch.stitch(ground, seen_at, shares) > 0.5
    seen_marked = stitch.stitch(dict.fromkeys(rig.SIDES, marked), lies_at, shares) > 0.5
    mask = np.where(seen_ground, np.where(seen_marked, MARKING, GROUND), NOT_GROUND).astype(np.uint8)
    image[black], mask[black] = 0, NOT_GROUND
    columns = _columns(view)
    return image[:, columns], mask[:, columns]


def _columns(view: View) -> slice:
    """The columns of the stitched frame that the view keeps: for a half-view 96, of which 12 show the car."""
    if view.half is None:
        return slice(0, view.frame.width)
    inner = int(view.frame.width / 2 - view.ego.width / 2 * view.frame.scale) + 12
    return (
        slice(inner - 96, inner)
        if view.half == "left"
        else slice(view.frame.width - inner, view.frame.width - inner + 96)
    )
