"""Is any trace of the old line left? What lies along the former strokes, against the ground beside them.

A trace is judged in CIELAB, along the colour in which the paint stood out: what is left of a yellow line is yellow.
Around every point of the stroke the mean over the stroke is held against that of the ground next to its soft edge.
Ground is never even, so the same is measured where nothing ever was: with the same strokes moved to bare ground of the
same picture. It is as often brighter there as darker, so each of these counts with both signs. A trace is what stands
out more.
"""

from __future__ import annotations

from itertools import pairwise

import attrs
import cv2
import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.stats import rankdata

from pavemark.accuracy.holes import around, self_made_hole
from pavemark.ground import Frame

ALONG = 0.25
"""Metres of stroke whose mean is taken."""

BESIDE = 0.8
"""Metres a side of the square around a point from which the ground beside the stroke is taken."""

EVERY = 0.08
"""Metres from one point of the stroke to the next."""

PAINTED = 4.0
"""ΔE by which paint must have stood out at a point for it to count; worn-off paint leaves no trace to look for."""

LEAST = 20
"""Points without which nothing can be said."""

WORST = 0.1
"""Share of the points that counts as the worst."""

BINS = (-0.04, 0.0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.14, 0.16, 0.2)
"""Metres from the stroke's edge, below 0 within it, between which the profile is averaged."""


@attrs.frozen
class Residue:
    """What is left of former strokes.

    Attributes
    ----------
    paint : float
        How far the paint stood out from the ground beside it, median ΔE*ab.
    left : float
        How far what is there now stands out in the paint's direction, mean over the stroke, ΔE*ab. Above 0 a trace of
        paint is left, below 0 the stroke was filled with the opposite (a dark streak where white paint was).
    noise : float
        Standard deviation of the same over bare ground (robust, from the median absolute value), ΔE*ab.
    worst : float
        Mean of the tenth that stands out most, less the same of bare ground, ΔE*ab: a trace in few places.
    z : float
        `left` in units of `noise`.
    auc : float
        How often a point of the former stroke stands out more than one of bare ground: 0.5 where they cannot be told
        apart, 1 where the stroke always does, 0 where it always stands out the other way.
    rim : float
        As `left`, over the soft edge of the stroke in place of the stroke itself: dark or light outlines.
    texture : float
        Texture energy on the stroke and its soft edge as a share of that beside it, over the same on bare ground:
        below 1 the stroke shows as a smooth streak.
    profile : tuple of float
        What stands out in the paint's direction, ΔE*ab, by the distance from the stroke's edge: a mean for each two
        neighbours of BINS, nan where no pixel lies there.
    """

    paint: float
    left: float
    noise: float
    worst: float
    z: float
    auc: float
    rim: float
    texture: float
    profile: tuple[float, ...]


def residue(
    before: np.ndarray, after: np.ndarray, marking: np.ndarray, ground: np.ndarray, frame: Frame
) -> Residue | None:
    """Measure what is left of markings.

    Parameters
    ----------
    before, after : ndarray (H, W, 3) uint8
        Display sRGB, as taken, and with the markings taken off by whatever means.
    marking : ndarray (H, W) bool
        Where the markings were.
    ground : ndarray (H, W) bool
        Where there is ground, painted or bare.
    frame : Frame

    Returns
    -------
    Residue or None
        None where paint never stood out, or bare ground has no room for the same strokes.
    """
    moved = self_made_hole(marking, marking, ground, frame)
    if moved is None:
        return None
    there = _Strokes(marking & ground, around(marking, frame) & ground, ground & ~around(marking, frame), frame)
    elsewhere = _Strokes(
        moved.move.apply(marking, marking.shape) & moved.mask, moved.mask, there.beside & ~moved.mask, frame
    )
    old, new = _lab(before), _lab(after)
    paint = there.contrast(old, there.stroke)
    strength = np.linalg.norm(paint, axis=-1)
    shows = strength >= PAINTED  # nan, where nothing was measured, does not
    direction = np.where(shows[..., None], paint / np.maximum(strength, PAINTED)[..., None], np.nan)
    same = moved.move.apply(np.nan_to_num(direction), marking.shape)
    same[~same.any(-1)] = np.nan

    def trace(strokes: _Strokes, part: np.ndarray, direction: np.ndarray) -> np.ndarray:
        along = (strokes.contrast(new, part) * direction).sum(-1)[strokes.points]
        return along[np.isfinite(along)]

    now, bare = trace(there, there.stroke, direction), trace(elsewhere, elsewhere.stroke, same)
    rim = trace(there, there.edge, direction)
    if min(map(len, (now, bare, rim))) < LEAST:
        return None
    noise = float(1.4826 * np.median(np.abs(bare)))
    left = float(now.mean())
    chance = np.concatenate([bare, -bare])
    bare_texture = elsewhere.texture(new)
    return Residue(
        paint=float(np.median(strength[shows & there.points])),
        left=left,
        noise=noise,
        worst=_worst(now) - _worst(chance),
        z=left / noise if noise else float("nan"),
        auc=_separability(now, chance),
        rim=float(rim.mean()),
        texture=there.texture(new) / bare_texture if bare_texture else float("nan"),
        profile=there.profile(new, direction, frame.scale),
    )


class _Strokes:
    """Strokes, their soft edge, and the ground beside them."""

    def __init__(self, stroke: np.ndarray, hole: np.ndarray, beside: np.ndarray, frame: Frame) -> None:
        self.stroke = stroke
        self.hole = hole
        self.edge = hole & ~stroke
        self.beside = beside
        self._along, self._beside = (2 * max(1, round(reach * frame.scale / 2)) + 1 for reach in (ALONG, BESIDE))
        self._fine = max(1.0, 0.03 * frame.scale)
        step = max(1, round(EVERY * frame.scale))
        self.points = np.zeros_like(stroke)
        self.points[::step, ::step] = stroke[::step, ::step]

    def contrast(self, lab: np.ndarray, part: np.ndarray) -> np.ndarray:
        """Mean over a part near each pixel less that over the ground beside, (H, W, 3); nan where one is not there."""
        return _mean(lab, part, self._along) - _mean(lab, self.beside, self._beside)

    def profile(self, lab: np.ndarray, direction: np.ndarray, scale: float) -> tuple[float, ...]:
        """What stands out in the direction of the nearest stroke, by the distance from its edge."""
        outwards, nearest = distance_transform_edt(~self.stroke, return_indices=True)
        distance = np.where(self.stroke, 0.5 - distance_transform_edt(self.stroke), outwards - 0.5) / scale
        above = lab - _mean(lab, self.beside, self._beside)
        along = (above * direction[nearest[0], nearest[1]]).sum(-1)
        seen = (self.hole | self.beside) & np.isfinite(along)
        parts = [along[seen & (distance >= low) & (distance < high)] for low, high in pairwise(BINS)]
        return tuple(float(part.mean()) if part.size else float("nan") for part in parts)

    def texture(self, lab: np.ndarray) -> float:
        """Texture energy in the hole as a share of that of the ground beside; the median over the points."""
        fine = (lab[..., 0] - cv2.GaussianBlur(lab[..., 0], (0, 0), self._fine)) ** 2
        inside, outside = (
            _mean(fine, part, reach)[self.points]
            for part, reach in ((self.hole, self._along), (self.beside, self._beside))
        )
        return float(np.sqrt(np.nanmedian(inside / np.maximum(outside, 1e-9))))


def _mean(values: np.ndarray, part: np.ndarray, side: int) -> np.ndarray:
    """Mean of values (H, W[, C]) over the pixels of a part in the square around each pixel; nan without any."""
    weight = part.astype(np.float64)
    near = cv2.boxFilter(weight, -1, (side, side), normalize=False, borderType=cv2.BORDER_CONSTANT)
    shape = (*part.shape, *(1,) * (values.ndim - 2))
    total = cv2.boxFilter(
        values * weight.reshape(shape), -1, (side, side), normalize=False, borderType=cv2.BORDER_CONSTANT
    )
    # Less than a row of the square is too little to stand for the ground there.
    near[near < side] = np.nan
    return total / near.reshape(shape)


def _worst(values: np.ndarray) -> float:
    return float(np.sort(values)[-max(1, round(WORST * len(values))) :].mean())


def _separability(first: np.ndarray, second: np.ndarray) -> float:
    """How often a value of the first is larger than one of the second, ties half."""
    ranks = rankdata(np.concatenate([first, second]))[: len(first)].sum()
    return float((ranks - len(first) * (len(first) + 1) / 2) / (len(first) * len(second)))


def _lab(image: np.ndarray) -> np.ndarray:
    return cv2.cvtColor(image.astype(np.float32) / 255, cv2.COLOR_RGB2LAB).astype(np.float64)
