"""The body of a parked car as a mesh: rings lofted from nose to tail. Metres, nose towards +X, wheels on Z = 0."""

from __future__ import annotations

import attrs
import numpy as np

STATIONS = {
    # Share of the length from nose (+0.5) to tail; half width as share; underside, belt line and roof line in metres.
    "saloon": (
        (0.500, 0.76, 0.34, 0.58, 0.60), (0.485, 0.88, 0.24, 0.68, 0.71), (0.440, 0.97, 0.20, 0.76, 0.80),
        (0.330, 1.00, 0.19, 0.83, 0.89), (0.200, 1.00, 0.19, 0.90, 0.97), (0.040, 1.00, 0.19, 0.93, 1.38),
        (-0.080, 1.00, 0.19, 0.94, 1.46), (-0.220, 1.00, 0.19, 0.95, 1.41), (-0.370, 0.99, 0.19, 0.97, 1.08),
        (-0.460, 0.95, 0.21, 0.96, 1.01), (-0.490, 0.88, 0.26, 0.88, 0.92), (-0.500, 0.78, 0.36, 0.80, 0.82),
    ),
    "estate": (
        (0.500, 0.78, 0.38, 0.70, 0.73), (0.485, 0.90, 0.28, 0.82, 0.86), (0.440, 0.97, 0.23, 0.90, 0.95),
        (0.340, 1.00, 0.22, 0.95, 1.01), (0.240, 1.00, 0.22, 1.00, 1.07), (0.090, 1.00, 0.22, 1.02, 1.56),
        (-0.080, 1.00, 0.22, 1.03, 1.64), (-0.280, 1.00, 0.22, 1.04, 1.62), (-0.430, 0.99, 0.22, 1.05, 1.52),
        (-0.470, 0.96, 0.24, 1.04, 1.20), (-0.492, 0.90, 0.30, 0.96, 1.04), (-0.500, 0.80, 0.42, 0.86, 0.90),
    ),
}  # fmt: skip

PAINT, GLASS, PLASTIC = 0, 1, 2
"""Materials of a face."""


@attrs.frozen
class Make:
    """A parked car's looks.

    Attributes
    ----------
    body : str
        A key of STATIONS.
    length, width : float
        Metres.
    colour : tuple of float
        Reflectance of the paint, linear light.
    """

    body: str
    length: float
    width: float
    colour: tuple[float, float, float]


_COLOURS = (
    (0.75, 0.75, 0.74), (0.75, 0.75, 0.74), (0.02, 0.02, 0.025), (0.03, 0.03, 0.035), (0.28, 0.29, 0.30),
    (0.10, 0.11, 0.12), (0.35, 0.02, 0.02), (0.03, 0.06, 0.20), (0.30, 0.24, 0.16),
)  # fmt: skip


def sample(rng: np.random.Generator) -> Make:
    """Draw a car as one stands in any car park."""
    return Make(
        body=str(rng.choice(sorted(STATIONS))),
        length=float(rng.uniform(4.2, 4.75)),
        width=float(rng.uniform(1.75, 1.88)),
        colour=_COLOURS[int(rng.integers(len(_COLOURS)))],
    )


def body(make: Make) -> tuple[np.ndarray, list[tuple[int, ...]], list[int]]:
    """The body without its wheels: vertices (N, 3), faces as vertex numbers, and the material of each face."""
    rings = [_ring(make, *station) for station in STATIONS[make.body]]
    count = len(rings[0])
    faces, materials = [], []
    for k in range(len(rings) - 1):
        for j in range(count):
            j1 = (j + 1) % count
            faces.append((k * count + j, k * count + j1, (k + 1) * count + j1, (k + 1) * count + j))
            materials.append(_material(make, k, min(j, count - 1 - j)))
    faces += [tuple(range(count))[::-1], tuple((len(rings) - 1) * count + j for j in range(count))]
    materials += [PLASTIC, PAINT]
    return np.concatenate(rings), faces, materials


def _ring(make: Make, along: float, share: float, under: float, belt: float, roof: float) -> np.ndarray:
    """A cross-section from the underside up the left flank, over the roof and down the right, (N, 3)."""
    half = make.width / 2 * share
    cabin = roof - belt > 0.15
    top = half * (0.74 if cabin else 0.86)
    flank = [
        (0.90 * half, under), (0.99 * half, under + 0.10), (half, (under + belt) / 2), (0.99 * half, belt - 0.10),
        (0.95 * half, belt), (top * 1.04, roof - 0.07 if cabin else roof - 0.01), (top * 0.86, roof),
    ]  # fmt: skip
    section = [*flank, *[(-y, z) for y, z in reversed(flank)]]
    return np.array([(along * make.length, y, z) for y, z in section])


def _material(make: Make, k: int, j: int) -> int:
    """Of the face between ring k and the next and between points j and j + 1 of the left flank."""
    roofs = [station[4] - station[3] for station in STATIONS[make.body]]
    here, there = roofs[k] > 0.15, roofs[k + 1] > 0.15
    if j <= 0 or j == 13:
        return PLASTIC
    if here and there and j == 4:
        return GLASS
    if here != there and j >= 4:
        return GLASS
    return PAINT
