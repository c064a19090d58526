"""`python -m blender_addon.carpark --out assets/demo`: make the demo images."""

from __future__ import annotations

from pathlib import Path

import click
import cv2
import numpy as np

from blender_addon.carpark import car, demo, layout, stage
from blender_addon.carpark.layout import Block
from blender_addon.carpark.pavement import Surface
from pavemark.errors import InputError
from pavemark.files import png, write

QUALITY = 92
"""JPEG quality of the shipped images."""


def _sun() -> None:
    stage.sun(np.radians(35), np.radians(48), 4.0, 0.7)


def _building() -> None:
    stage.sun(np.radians(160), np.radians(50), 4.5, 0.8)
    stage.block(Block((-8.0, 1.5), (9.0, 4.0, 9.0), np.radians(75), "wall"))


def _garage() -> None:
    lamps = [(x, y, np.pi / 2) for x in (-4.5, 0.7, 5.0) for y in (-7.5, -2.5, 2.5, 7.5)]
    stage.garage(lamps, 55.0, (0.93, 1.0, 0.97))


def _dim() -> None:
    stage.garage(
        [(-2.4, 6.0, np.pi / 2), (0.6, 7.5, np.pi / 2), (-5.5, -5.0, 0.3), (2.0, -7.5, np.pi / 2)],
        40.0,
        (0.96, 1.0, 0.9),
    )


LIGHTS = {
    "sun": _sun,
    "building": _building,
    "overcast": lambda: stage.overcast(1.0),
    "garage": _garage,
    "dim": _dim,
}


def build(view: demo.View, surface: Surface, threads: int) -> None:
    """Set up the car park of a view in Blender."""
    rng = demo.stream(view, 1)
    stage.clear(threads)
    stage.ground(surface, wavy=0.004 if view.pavement == "epoxy" else 0.0, seed=float(rng.uniform(0, 1000)))
    LIGHTS[view.light]()
    for row in view.rows:
        for where in layout.cars(row, view.turn, rng):
            stage.parked(where, car.sample(rng))
    blocks = [layout.beside(kind, side, offset, view.turn) for kind, side, offset in view.beside]
    blocks += layout.pillars(view.rows[0], view.turn) if view.pillars else ()
    for block in blocks:
        stage.block(block)
    for at in view.trees:
        stage.tree(at, rng)
    stage.ego(car.Make("saloon", view.ego.length - 0.1, view.ego.width - 0.1, (0.02, 0.02, 0.02)))


@click.command()
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder for images/, masks/ and half/.")
@click.option("--only", multiple=True, help="Name of a view; may be given more than once. Default: all.")
@click.option(
    "--threads", default=2, show_default=True, help="Threads of the renderer; the pictures do not depend on it."
)
def main(out: Path, only: tuple[str, ...], threads: int) -> None:
    """Render the car park and write the demo images with their masks."""
    unknown = sorted(set(only) - {view.name for view in demo.VIEWS})
    if unknown:
        raise click.BadParameter(f"{unknown[0]}: allowed {', '.join(v.name for v in demo.VIEWS)}", param_hint="--only")
    try:
        for view in demo.VIEWS:
            if only and view.name not in only:
                continue
            surface = demo.surface(view)
            build(view, surface, threads)
            image, mask = demo.photograph(view, surface.marked, stage.look)
            coded = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()
            folder = out / view.folder
            write(folder / "images" / f"{view.name}.jpg", coded)
            write(folder / "masks" / f"{view.name}.png", png(mask))
            click.echo(f"{view.name}  {image.shape[1]}×{image.shape[0]}")
    except InputError as error:
        raise click.ClickException(str(error)) from None


if __name__ == "__main__":
    main()
