"""Where the cameras of a plate's car sit: what gleams on the ground is seen from there."""

from __future__ import annotations

from pavemark.cameras.rig import mounts
from pavemark.light import Place
from pavemark.plate import Plate
from pavemark.randomize.car import find_car


def eyes(plate: Plate) -> tuple[Place, ...]:
    """The cameras of the car that stands in a plate: in the grille, under the mirrors, over the rear plate."""
    car = find_car(plate)
    sides = mounts(2 * car.half_length, 2 * car.half_width).values()
    return tuple((car.x + x, y, z) for x, y, z in (mount.position for mount in sides))
