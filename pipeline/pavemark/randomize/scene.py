"""Draws a scene: all domains of the paper, each from a random stream of its own."""

from __future__ import annotations

import attrs

from pavemark.light import Sun
from pavemark.plate import Plate
from pavemark.randomize import (
    aisle,
    brightness,
    colour,
    curvature,
    former,
    glare,
    layout,
    noise,
    optics,
    relief,
    shadows,
    shape,
    stops,
    symbols,
    texture,
    wet,
)
from pavemark.randomize import sun as daylight
from pavemark.randomize import tyres as traffic
from pavemark.randomize.domains import Domains
from pavemark.randomize.fitted import fitted
from pavemark.randomize.palette import palette
from pavemark.randomize.row import Row, slots, strokes
from pavemark.randomize.streams import Stage, stream
from pavemark.scene import Area, Marking, Paint, Scene

_SYMBOL_MARKING = 100
_FORMER_MARKING = 200
_AISLE_MARKING = 300
"""Numbers under which what is no row draws its texture or colour: rows are 0 and 1, with room to grow."""


def randomize(
    plate: Plate,
    index: int,
    job_seed: int,
    domains: Domains,
    original: tuple[Area, ...] = (),
    blur: optics.Blur | None = None,
) -> Scene:
    """Draw one scene.

    Parameters
    ----------
    plate : Plate
        What it is painted on.
    index : int
        Number of the image in its job.
    job_seed : int
        Not negative.
    domains : Domains
    original : tuple of Area
        The image's own markings as outlines, world, metres, to be re-painted where the domains say so.
    blur : tuple of tuple of float, or None
        The measured blur of the plate, as in `pavemark.scene.Optics`.

    Returns
    -------
    Scene
        The same for the same arguments, whatever else was drawn before. An effect that is not drawn is None.
    """

    def rng(stage: Stage, *children: int):
        return stream(job_seed, index, stage, *children)

    choice = layout.choose(rng(Stage.LAYOUT, 0), domains.layout)
    rows: tuple[Row, ...] = ()
    repainted = choice.content == "original" and bool(original)
    if choice.content != "empty" and not repainted:
        drawn = shape.sample(rng(Stage.SHAPE), domains.shape, fitted())
        rows = layout.sample(job_seed, index, domains.layout, fitted(), plate, drawn, choice)

    age = texture.sample_age(job_seed, index, domains.texture)

    def coloured(*children: int) -> Paint:
        drawn = colour.sample(rng(Stage.COLOUR, *children), domains.colour, palette(), plate.ratios)
        return Paint(drawn.rgb, drawn.ratio)

    def textured(number: int, paint: Paint) -> Paint:
        return texture.sample(job_seed, index, number, domains.texture, paint, age)

    markings: list[Marking] = []
    if repainted:
        markings.append(Marking("original", textured(0, coloured(0)), areas=original))
    if rows:
        paint = coloured(0)
        along = aisle.sample(rng(Stage.AISLE), domains.aisle)
        beside = [
            (row, aisle.beside(along, row, rows[:number] + rows[number + 1 :]))
            for number, row in enumerate(rows if along is not None else ())
        ]
        for row, lying in beside:
            markings += aisle.floors(lying, row)
        for number, row in enumerate(rows):
            old = former.sample(rng(Stage.FORMER, number), domains.texture.former)
            if old is not None:
                markings.append(former.marking(old, row, coloured(_FORMER_MARKING + number)))
        if beside:
            line = textured(_AISLE_MARKING, coloured(_AISLE_MARKING))
            markings += filter(None, (aisle.marking(lying, row, line) for row, lying in beside))
        sign = symbols.sample(rng(Stage.SYMBOL), domains.layout.symbol_rate)
        if sign is not None:
            markings.append(symbols.marking(sign, rows[0], textured(_SYMBOL_MARKING, paint)))
        markings += [Marking("slot", textured(number, paint), strokes(row)) for number, row in enumerate(rows)]
        lying = stops.sample(rng(Stage.STOPS), domains.stops)
        if lying is not None:
            markings += [marking for row in rows for marking in stops.markings(lying, row)]

    def sun() -> Sun:
        return daylight.sample(job_seed, index, domains.sun)

    tracks = traffic.sample(rng(Stage.TYRES), domains.texture.tyres)
    scene = Scene(
        index=index,
        plate=plate.ref,
        shadows=shadows.sample(rng(Stage.SHADOWS), domains.shadows, plate.frame, sun),
        wet=wet.sample(rng(Stage.WET), domains.wet, plate),
        glare=glare.sample(rng(Stage.GLARE), domains.glare, plate),
        noise=noise.sample(rng(Stage.NOISE), domains.noise),
        brightness=brightness.sample(rng(Stage.BRIGHTNESS), domains.brightness),
    )
    if any((markings, scene.shadows, scene.wet, scene.glare)):
        scene = attrs.evolve(scene, optics=optics.sample(rng(Stage.OPTICS), domains.optics, blur))
    if not markings:
        return scene
    return attrs.evolve(
        scene,
        markings=tuple(markings),
        slots=tuple(slot for row in rows for slot in slots(row)),
        tyres=traffic.tyres(tracks, rows) if tracks is not None and rows else None,
        curvature=curvature.sample(rng(Stage.CURVATURE), domains.curvature),
        blend=domains.blend,
        relief=relief.sample(rng(Stage.RELIEF), domains.relief, sun),
    )
