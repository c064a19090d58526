"""The effects that need light: what casts shadows into the picture, what stands up from the ground, what gleams.

The plate has its own light already; each effect says by what that light is multiplied or what gleams on top of it.
Lengths are metres, angles radians, positions world (X, Y) or (X, Y, Z), Z up from the ground; radiance is linear light,
1 being the white of the plate's own exposure.
"""

from __future__ import annotations

import math

import attrs

from pavemark.records import one_of, within

Foot = tuple[float, float]
Place = tuple[float, float, float]
RGB = tuple[float, float, float]

FAR = 1e3
"""Metres from the origin beyond which nothing is taken to light or shade the picture."""

_seed = within(0, 1000)
_share = within(0.0, 1.0)
_radiance = within(0.0, 100.0)
_place = within(-FAR, FAR)


def _above_ground(instance: object, attribute: attrs.Attribute, value: Place) -> None:
    if not value[2] > 0:
        raise ValueError(f"{attribute.name} at {value}: a place above the ground is allowed, Z > 0")


def _eyes(instance: object, attribute: attrs.Attribute, value: tuple[Place, ...]) -> None:
    if not value:
        raise ValueError(f"{attribute.name} is empty: at least one camera is allowed")
    for place in value:
        _above_ground(instance, attribute, place)


@attrs.frozen
class Sun:
    """Light from far off.

    Attributes
    ----------
    azimuth : float
        Where it stands, anticlockwise from the world's X.
    elevation : float
        Above the horizon.
    angle : float
        Its diameter as seen from the ground; haze widens it.
    """

    azimuth: float = attrs.field(validator=within(-7.0, 7.0))
    elevation: float = attrs.field(validator=within(0.05, math.pi / 2))
    angle: float = attrs.field(default=0.0093, validator=within(0.0, 0.5))


@attrs.frozen
class Lamp:
    """A globe of light.

    Attributes
    ----------
    place : Place
        Its middle.
    radius : float
        Of the globe: the larger, the softer its shadows.
    """

    place: Place = attrs.field(validator=[_place, _above_ground])
    radius: float = attrs.field(validator=within(0.001, 2.0))

    def __attrs_post_init__(self) -> None:
        if self.place[2] <= self.radius:
            raise ValueError(f"place is {self.place[2]:g} m high: more than the radius, {self.radius:g} m, is allowed")


CASTERS = ("tree", "pole", "car", "roof")


@attrs.frozen
class Caster:
    """A thing that stands outside the frame, seen by its shadow alone.

    Attributes
    ----------
    kind : str
        What it is, one of CASTERS.
    foot : Foot
        The middle of what it covers of the ground.
    size : Place
        Length, width and height of the box it fills; along its own axes.
    turn : float
        Anticlockwise, of its length from the world's X.
    seed : int
        Of a tree's crown.
    """

    kind: str = attrs.field(validator=one_of(*CASTERS))
    foot: Foot = attrs.field(validator=_place)
    size: Place = attrs.field(validator=within(0.02, 100.0))
    turn: float = attrs.field(default=0.0, validator=within(-7.0, 7.0))
    seed: int = attrs.field(default=0, validator=within(0, 2**31 - 1))


@attrs.frozen
class Shadows:
    """Shadows of things outside the frame.

    Attributes
    ----------
    left : RGB
        Share of the light that is left where its source is hidden whole: of a lamp, straight below it.
    sun : Sun or None
    lamp : Lamp or None
        The source, one of the two.
    casters : tuple of Caster
        What casts them.
    """

    left: RGB = attrs.field(validator=_share)
    sun: Sun | None = None
    lamp: Lamp | None = None
    casters: tuple[Caster, ...] = ()

    def __attrs_post_init__(self) -> None:
        if (self.sun is None) == (self.lamp is None):
            raise ValueError("sun and lamp: exactly one of them is allowed")


@attrs.frozen
class Relief:
    """Paint that stands up from the ground, as thermoplastic does: its rims are lit, or cast a shadow.

    Attributes
    ----------
    height : float
        Metres from the ground to the top of the paint.
    bevel : float
        Width of the slope from the outline up to the full height.
    sun : Sun
    left : float
        Share of the light that does not come from the sun.
    """

    height: float = attrs.field(validator=within(0.0005, 0.05))
    bevel: float = attrs.field(validator=within(0.0005, 0.1))
    sun: Sun
    left: float = attrs.field(validator=_share)


@attrs.frozen
class Wet:
    """Wet patches, which are darker, and puddles in them, which mirror what stands around and the sky.

    Attributes
    ----------
    share : float
        Share of the ground that is wet.
    pools : float
        Share of the wet ground that lies under water.
    size : float
        Metres of the patches.
    darkening : float
        Share of the light that wet ground swallows.
    sky : RGB
        Radiance of the sky that puddles mirror; 1 is the picture's white.
    around : RGB
        Radiance of what stands around, below the skyline.
    skyline : float
        Elevation up to which things stand around, on the mean.
    eyes : tuple of Place
        The cameras. Each point of the ground is seen by the nearest.
    seed : float
        Of the patches: another one wets other ground.
    """

    share: float = attrs.field(validator=_share)
    pools: float = attrs.field(validator=_share)
    size: float = attrs.field(validator=within(0.05, 20.0))
    darkening: float = attrs.field(validator=_share)
    sky: RGB = attrs.field(validator=_radiance)
    around: RGB = attrs.field(validator=_radiance)
    skyline: float = attrs.field(validator=within(0.0, math.pi / 2))
    eyes: tuple[Place, ...] = attrs.field(validator=[_place, _eyes])
    seed: float = attrs.field(validator=_seed)


@attrs.frozen
class Tube:
    """A lit tube or panel, level, that shines downwards.

    Attributes
    ----------
    place : Place
        Its middle.
    length : float
        Metres from end to end.
    width : float
        Metres across.
    turn : float
        Its length's, anticlockwise from the world's X.
    radiance : RGB
        Of its light; 1 is the picture's white.
    """

    place: Place = attrs.field(validator=[_place, _above_ground])
    length: float = attrs.field(validator=within(0.01, 50.0))
    width: float = attrs.field(validator=within(0.01, 10.0))
    turn: float = attrs.field(validator=within(-7.0, 7.0))
    radiance: RGB = attrs.field(validator=within(0.0, 1000.0))


@attrs.frozen
class Glare:
    """Lamps mirrored in a smooth floor.

    Attributes
    ----------
    tubes : tuple of Tube
    roughness : float
        Of the floor: 0 a mirror, 1 dull (the square root of GGX's alpha).
    reflectance : float
        Share of the light that the floor mirrors straight up; at grazing angles it is more (Schlick, 1994).
    eyes : tuple of Place
        The cameras. Each point of the ground is seen by the nearest.
    """

    tubes: tuple[Tube, ...]
    roughness: float = attrs.field(validator=within(0.01, 1.0))
    reflectance: float = attrs.field(validator=_share)
    eyes: tuple[Place, ...] = attrs.field(validator=[_place, _eyes])
