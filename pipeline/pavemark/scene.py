"""The contract of the house: whatever can be drawn is in a Scene.

Whoever has a scene, and the plate it names, can redo the image to the bit. A scene lists its effects; one that
is None is not drawn, not rendered and not computed. Lengths are metres, angles radians, positions world (X, Y).
"""

from __future__ import annotations

import re

import attrs

from pavemark.ground import Frame
from pavemark.light import Glare, Relief, Shadows, Wet
from pavemark.records import one_of, within

Point = tuple[float, float]
Path = tuple[Point, ...]
RGB = tuple[float, float, float]

REACH = 1e5
"""Metres from the origin beyond which a coordinate is taken for a mistake."""

_NAME = re.compile(r"[^/\\\x00-\x1f]{1,200}")


def plain_name(instance: object, attribute: attrs.Attribute, value: str) -> None:
    """Validator: a file's stem that cannot leave its folder."""
    if not _NAME.fullmatch(value) or value.startswith(".") or ".." in value or ":" in value:
        raise ValueError(
            f"{attribute.name} = {value!r}: a plain name without path, colon, '..' or first dot is allowed"
        )


def _hash(instance: object, attribute: attrs.Attribute, value: str) -> None:
    if not re.fullmatch(r"[0-9a-f]{64}", value):
        raise ValueError(f"{attribute.name} = {value!r}: 64 hexadecimal digits are allowed")


def _some(count: int):
    def check(instance: object, attribute: attrs.Attribute, value: tuple) -> None:
        if len(value) < count:
            raise ValueError(f"{attribute.name} has {len(value)} points: at least {count} are allowed")

    return check


def _anticlockwise(instance: object, attribute: attrs.Attribute, value: Path) -> None:
    for (ax, ay), (bx, by), (cx, cy) in zip(value, value[1:] + value[:1], value[2:] + value[:2], strict=True):
        if not (bx - ax) * (cy - by) - (by - ay) * (cx - bx) > 0:
            raise ValueError(
                f"{attribute.name} turn right or not at all at ({bx:g}, {by:g}): allowed are convex slots, "
                "corners anticlockwise seen from above"
            )


_seed = within(0, 2**63 - 1)
_share = within(0.0, 1.0)


@attrs.frozen
class PlateRef:
    """The clean background a scene is painted on.

    Attributes
    ----------
    name : str
        Stem of the real image it was made from.
    sha256 : str
        Hash of the plate (pixels and ground), see `pavemark.plate.Plate.sha256`.
    frame : Frame
    """

    name: str = attrs.field(validator=plain_name)
    sha256: str = attrs.field(validator=_hash)
    frame: Frame = attrs.field(factory=Frame)


@attrs.frozen
class Stroke:
    """A line of paint along a centre path, ends cut square, corners mitred.

    Attributes
    ----------
    path : tuple of Point
        Centre line, before the curvature.
    width : float
        Metres across.
    closed : bool
        Whether the last point joins the first.
    """

    path: Path = attrs.field(validator=[_some(2), within(-REACH, REACH)])
    width: float = attrs.field(validator=within(0.001, 10.0))
    closed: bool = False


@attrs.frozen
class Area:
    """A filled shape: an outer ring and holes, for symbols and for re-painted original markings."""

    ring: Path = attrs.field(validator=[_some(3), within(-REACH, REACH)])
    holes: tuple[Path, ...] = attrs.field(default=(), validator=within(-REACH, REACH))


@attrs.frozen
class Grain:
    """Fine roughness of paint on asphalt.

    Attributes
    ----------
    size : float
        Metres over which the brightness varies.
    contrast : float
        By how much of itself it varies, up and down.
    seed : float
        Of the roughness: another one puts its grains elsewhere.
    """

    size: float = attrs.field(validator=within(0.001, 1.0))
    contrast: float = attrs.field(validator=_share)
    seed: float = attrs.field(validator=within(0, 1000))


@attrs.frozen
class Wear:
    """Paint rubbed off, from the edges inwards and under the tyres.

    Attributes
    ----------
    amount : float
        Share of paint lost in the middle of the line, 0 fresh to 1 gone.
    edge : float
        Metres over which the wear from the outline fades.
    edge_amount : float
        Wear added at the outline.
    tyre_amount : float
        Wear added under a tyre track.
    size : float
        Metres of the patches that wear leaves.
    seed : float
        Of the patches: another one puts them elsewhere.
    """

    amount: float = attrs.field(validator=_share)
    edge: float = attrs.field(validator=within(0.001, 1.0))
    edge_amount: float = attrs.field(validator=_share)
    tyre_amount: float = attrs.field(validator=_share)
    size: float = attrs.field(validator=within(0.005, 2.0))
    seed: float = attrs.field(validator=within(0, 1000))


@attrs.frozen
class Chips:
    """Flakes broken out down to the ground.

    Attributes
    ----------
    size : float
        Metres of the cells that flakes are.
    share : float
        Share of the cells that have broken out.
    seed : float
        Of the cells: another one breaks others out.
    """

    size: float = attrs.field(validator=within(0.005, 1.0))
    share: float = attrs.field(validator=_share)
    seed: float = attrs.field(validator=within(0, 1000))


@attrs.frozen
class Cracks:
    """A network of cracks through the paint.

    Attributes
    ----------
    size : float
        Metres of the cells between cracks.
    width : float
        Metres across a crack.
    seed : float
        Of the network: another one runs elsewhere.
    """

    size: float = attrs.field(validator=within(0.02, 5.0))
    width: float = attrs.field(validator=within(0.0005, 0.1))
    seed: float = attrs.field(validator=within(0, 1000))


@attrs.frozen
class Dirt:
    """Dust and rubber that darken the paint.

    Attributes
    ----------
    size : float
        Metres of the stains.
    strength : float
        Share of the paint's light that the darkest stain takes away.
    seed : float
        Of the stains: another one puts them elsewhere.
    """

    size: float = attrs.field(validator=within(0.01, 10.0))
    strength: float = attrs.field(validator=_share)
    seed: float = attrs.field(validator=within(0, 1000))


PATTERNS = ("stripes", "checks", "dots", "waves", "bricks", "rings", "cells", "weave")


@attrs.frozen
class Pattern:
    """A regular pattern in the paint, the way of a background-pattern generator.

    Attributes
    ----------
    kind : str
        What the pattern is made of, one of PATTERNS.
    size : float
        Period in metres.
    angle : float
        Radians, counter-clockwise.
    strength : float
        Share of the paint's opacity that the pattern takes away in its dark parts.
    seed : float
        Of the pattern: another one shifts it.
    """

    kind: str = attrs.field(validator=one_of(*PATTERNS))
    size: float = attrs.field(validator=within(0.01, 5.0))
    angle: float = attrs.field(validator=within(-7.0, 7.0))
    strength: float = attrs.field(validator=_share)
    seed: float = attrs.field(validator=within(0, 1000))


@attrs.frozen
class Paint:
    """What a marking is painted with.

    Attributes
    ----------
    rgb : tuple of float
        Absolute colour, display sRGB, 0–255 (the paper's way).
    ratio : tuple of float
        The same paint as reflectance ratio to the ground it lies on, linear light, 1 = as the ground; on ground with a
        hue of its own (a green floor) to the grey of its luminance.
    opacity : float
        Share of the ground that the paint hides before any wear.
    """

    rgb: RGB = attrs.field(validator=within(0, 255))
    ratio: RGB = attrs.field(validator=within(0.01, 100.0))
    opacity: float = attrs.field(default=1.0, validator=_share)
    grain: Grain | None = None
    wear: Wear | None = None
    chips: Chips | None = None
    cracks: Cracks | None = None
    dirt: Dirt | None = None
    pattern: Pattern | None = None


@attrs.frozen
class Marking:
    """One coat of paint: strokes and areas painted together, their union one outline.

    Attributes
    ----------
    kind : str
        "slot" for slot lines, "original" for the image's own markings re-painted, "former" for an older coat
        that shows below and "floor" for painted ground (no labels), "aisle" for lines beside a row, crossings and
        hatching, "symbol" for arrows, letters and the like, "stop" for what wheels roll against (no labels).
    """

    kind: str = attrs.field(validator=one_of("slot", "original", "former", "floor", "aisle", "symbol", "stop"))
    paint: Paint
    strokes: tuple[Stroke, ...] = ()
    areas: tuple[Area, ...] = ()


@attrs.frozen
class Slot:
    """A parking slot.

    Attributes
    ----------
    corners : tuple of 4 Point
        p1, p2, p3, p4 before the curvature, convex, anticlockwise seen from above. p1 → p2 is the entrance line and its
        ends are the marking points (centre lines crossing); the slot lies to the left of p1 → p2. p4 lies behind
        p1, p3 behind p2, along the separating lines.
    kind : str
        How it lies to the aisle: "perpendicular", "parallel" or "slanted".
    marks : tuple of 2 str
        "T" or "L", the shape of the marking point at p1 and at p2.
    outline : str
        Which lines are painted: "closed" all four sides; "half-closed" no back line, entrance whole; "open" (U)
        no entrance line; "corner" an entrance line only at the marking points, separating lines there or whole.
    """

    corners: tuple[Point, Point, Point, Point] = attrs.field(validator=[within(-REACH, REACH), _anticlockwise])
    kind: str = attrs.field(validator=one_of("perpendicular", "parallel", "slanted"))
    marks: tuple[str, str] = attrs.field(validator=one_of("T", "L"))
    outline: str = attrs.field(validator=one_of("closed", "half-closed", "open", "corner"))


@attrs.frozen
class Tyres:
    """Where wheels roll, for wear and dirt.

    Attributes
    ----------
    tracks : tuple of Path
        Centre paths of the tracks.
    width : float
        Metres across a track.
    """

    tracks: tuple[Path, ...] = attrs.field(validator=within(-REACH, REACH))
    width: float = attrs.field(validator=within(0.05, 1.0))


@attrs.frozen
class Curvature:
    """Elastic deformation of the geometry (paper: factor 100–200).

    Attributes
    ----------
    alpha : float
        The factor, in pixels of 1/60 m.
    sigma : float
        Smoothing length of the random field in metres.
    """

    alpha: float = attrs.field(validator=within(0.0, 1000.0))
    sigma: float = attrs.field(validator=within(0.02, 5.0))
    seed: int = attrs.field(validator=_seed)


@attrs.frozen
class Optics:
    """What the cameras did to the picture, suffered by the markings too.

    Attributes
    ----------
    blur : tuple of tuple of float
        Standard deviation in pixels of the blur, on a coarse grid over the frame (rows top to bottom), read
        bilinearly with the outer nodes on the frame's border.
    """

    blur: tuple[tuple[float, ...], ...] = attrs.field(validator=within(0.0, 20.0))

    @blur.validator
    def _rectangular(self, attribute: attrs.Attribute, value: tuple) -> None:
        if not value or not value[0] or len({len(row) for row in value}) != 1:
            raise ValueError("blur: rows of one length are allowed, at least one number")


@attrs.frozen
class Blend:
    """How the decals enter the plate.

    Attributes
    ----------
    method : str
        "reflectance": Poisson editing of log linear light, colours as ratios. "normal", "mixed": Poisson editing
        in display space with absolute colours (the paper). "alpha": plain over in display space.
    margin : int
        Pixels by which the solving domain is wider than the marking.
    ground_texture : float
        Share of the plate's own texture kept under the paint ("reflectance" only).
    edge_blur : bool
        5×5 Gaussian on the mask's edge.
    """

    method: str = attrs.field(default="reflectance", validator=one_of("reflectance", "normal", "mixed", "alpha"))
    margin: int = attrs.field(default=2, validator=within(1, 64))
    ground_texture: float = attrs.field(default=0.4, validator=_share)
    edge_blur: bool = False


@attrs.frozen
class Brightness:
    """Illumination of the whole image (paper: 0.5–1.5).

    Attributes
    ----------
    factor : float
        How many times as bright the illumination channel becomes.
    """

    factor: float = attrs.field(validator=within(0.0, 10.0))


@attrs.frozen
class Noise:
    """Sensor noise over the whole image.

    Attributes
    ----------
    kind : str
        How it is distributed: "gaussian", "laplacian" or "salt-and-pepper".
    amount : float
        Standard deviation in levels of 255; for salt-and-pepper the share of pixels hit.
    """

    kind: str = attrs.field(validator=one_of("gaussian", "laplacian", "salt-and-pepper"))
    amount: float = attrs.field(validator=within(0.0, 128.0))
    seed: int = attrs.field(validator=_seed)

    @amount.validator
    def _share_of_pixels(self, attribute: attrs.Attribute, value: float) -> None:
        if self.kind == "salt-and-pepper" and value > 1:
            raise ValueError(f"amount = {value}: allowed 0 to 1 for salt-and-pepper, a share of the pixels")


@attrs.frozen
class Scene:
    """One synthetic image, whole.

    Attributes
    ----------
    index : int
        Number of the image in its job.
    plate : PlateRef
    markings : tuple of Marking
        Bottom first: a later one covers an earlier one.
    slots : tuple of Slot
    rays : int
        Rays a pixel with which the decals are rendered; see `pavemark.plan.Pass`.
    """

    index: int = attrs.field(validator=within(0, 2**53))
    plate: PlateRef
    markings: tuple[Marking, ...] = ()
    slots: tuple[Slot, ...] = ()
    tyres: Tyres | None = None
    curvature: Curvature | None = None
    optics: Optics | None = None
    blend: Blend | None = None
    relief: Relief | None = None
    shadows: Shadows | None = None
    wet: Wet | None = None
    glare: Glare | None = None
    brightness: Brightness | None = None
    noise: Noise | None = None
    rays: int = attrs.field(default=1, validator=within(1, 65536))
    version: int = attrs.field(default=1, validator=within(1, 1))

    def __attrs_post_init__(self) -> None:
        if self.markings and self.blend is None:
            raise ValueError("blend is missing: a scene with markings needs one")
        for caster in self.shadows.casters if self.shadows is not None else ():
            if all(abs(at) <= side / 2 for at, side in zip(caster.foot, self.plate.frame.size, strict=True)):
                place = f"({caster.foot[0]:g}, {caster.foot[1]:g})"
                raise ValueError(
                    f"shadows.casters: a {caster.kind} stands in the picture, at {place}: outside it is allowed"
                )
        if self.relief is not None and not self.markings:
            raise ValueError("relief is given without markings: it is theirs, so some are needed")
