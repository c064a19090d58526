"""The roadside, estimated from the straight edges of former markings and of the free ground."""

from __future__ import annotations

import math

import attrs
import cv2
import numpy as np

from pavemark.ground import Frame
from pavemark.plate import Roadside

CERTAIN = 0.3
"""Confidence from which a roadside is believed; see docs/free-ground.md for how often it is right then."""

SHORTEST = 0.4
"""Metres of straight edge that tell a direction."""

BEND = 1.5
"""Pixels by which an edge may leave its chord: the stairs of a mask do by one."""

BESIDE = 2
"""Pixels from the frame's border and the ego car within which an edge is theirs."""

GROUND_WEIGHT = 0.3
"""Weight of an edge of the free ground beside one of a marking: cars and pillars are smeared away from the cameras."""

SPREAD = 2.0
"""Degrees, standard deviation, that edges of one direction scatter: lines break at the cameras' seams."""

AGREEING = 4.0
"""Degrees within which edges agree with a direction."""

ALONG = 8.0
"""Degrees, standard deviation, of the roadside about the car's way where it was measured; so a slanted row's separating
lines are not taken for its entrance line."""

ANYWAY = 0.1
"""Weight of directions that this speaks against: cars do stand askew."""

ENOUGH = 2.0
"""Metres of agreeing edge for half of the confidence: one stroke is no roadside."""

LINE = 0.12
"""Metres, standard deviation, within which edges lie on one line."""

LONGEST = 4.0
"""Metres of edge beyond which a line is none the more the roadside's: lane lines are the longest of all."""

LEAST_VOTES = 1.5
"""Votes, about metres of edge, that make a roadside's line."""


@attrs.frozen(eq=False)
class _Edges:
    """Straight edges: their ends (N, 2, 2) in world metres and their weight (N,) for each metre."""

    ends: np.ndarray
    weight: np.ndarray

    @property
    def length(self) -> np.ndarray:
        return np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=-1)

    @property
    def angle(self) -> np.ndarray:
        """Radians (N,) from X, modulo π."""
        along = self.ends[:, 1] - self.ends[:, 0]
        return np.arctan2(along[:, 1], along[:, 0])


def find_roadside(markings: np.ndarray, ground: np.ndarray, ego: np.ndarray, frame: Frame) -> Roadside | None:
    """Estimate the roadside.

    Slots lie along a roadside or at right angles to it, and so do their lines, kerbs, walls and parked cars: the
    direction is the one, modulo a quarter turn, on which the longest straight edges agree.

    Parameters
    ----------
    markings : ndarray (H, W) bool
        Former markings: their strokes are the best evidence.
    ground : ndarray (H, W) bool
        Free ground; its edges count less. Those along the frame's border and the ego car count nothing.
    ego : ndarray (H, W) bool
        Where the ego car stands.
    frame : Frame

    Returns
    -------
    Roadside or None
        None where the edges are few or do not agree.
    """
    foreign = cv2.dilate(ego.astype(np.uint8), np.ones((2 * BESIDE + 5, 2 * BESIDE + 5), np.uint8)) > 0
    foreign[:BESIDE] = foreign[-BESIDE:] = True
    foreign[:, :BESIDE] = foreign[:, -BESIDE:] = True
    strokes = _straight(markings, foreign, frame, 1.0)
    # Paint is no edge of the ground it lies on.
    outline = _straight(ground | markings, foreign, frame, GROUND_WEIGHT)
    edges = _Edges(np.concatenate([strokes.ends, outline.ends]), np.concatenate([strokes.weight, outline.weight]))
    if not len(edges.weight):
        return None
    turn, confidence = _turn(edges, frame)
    if confidence < CERTAIN:
        return None
    direction = math.radians(90.0 + turn)
    left, right = _lines(strokes, outline, direction, _middle(ego, frame))
    return Roadside(direction, left, right, confidence)


def _straight(mask: np.ndarray, foreign: np.ndarray, frame: Frame, weight: float) -> _Edges:
    """The straight pieces of a mask's outline, each the line that fits its pixels best."""
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    found = []
    for contour in contours:
        pixels = contour[:, 0]
        for piece in _pieces(pixels):
            if len(piece) < SHORTEST * frame.scale or foreign[piece[:, 1], piece[:, 0]].mean() > 0.3:
                continue
            points = piece + 0.5
            # Corners are round: the tenth at either end does not say how the line runs, only how far.
            cut = len(piece) // 10
            straight = points[cut : len(piece) - cut]
            centre = straight.mean(0)
            _, _, axes = np.linalg.svd(straight - centre, full_matrices=False)
            found.append(centre + ((points[[0, -1]] - centre) @ axes[0])[:, None] * axes[0])
    ends = frame.to_world(np.array(found).reshape(-1, 2, 2))
    return _Edges(ends, np.full(len(ends), weight))


def _pieces(pixels: np.ndarray) -> list[np.ndarray]:
    """A closed contour (N, 2) cut where Douglas-Peucker bends it."""
    corners = {tuple(corner) for corner in cv2.approxPolyDP(pixels[:, None], BEND, True)[:, 0].tolist()}
    at = [k for k, pixel in enumerate(pixels.tolist()) if tuple(pixel) in corners]
    around = np.concatenate([pixels, pixels])
    return [around[a : b + 1] for a, b in zip(at, [*at[1:], at[0] + len(pixels)], strict=True)]


def _turn(edges: _Edges, frame: Frame) -> tuple[float, float]:
    """Degrees from the car's way to the direction on which edges agree, -45 to 45, and the confidence."""
    angle = np.degrees(edges.angle) - 90.0
    weight = edges.weight * edges.length
    # An edge of n pixels is known to a pixel's step over its length.
    spread = np.maximum(SPREAD, np.degrees(0.7 / (edges.length * frame.scale)))
    grid = np.arange(-45.0, 45.0, 0.25)
    votes = (weight / spread * np.exp(-0.5 * (_quarter(angle - grid[:, None]) / spread) ** 2)).sum(1)
    votes *= ANYWAY + (1 - ANYWAY) * np.exp(-0.5 * (grid / ALONG) ** 2)
    best = grid[votes.argmax()]
    off = _quarter(angle - best)
    near = np.abs(off) < AGREEING
    agreeing = float(weight[near].sum())
    if agreeing == 0:
        return best, 0.0
    turn = float(best + np.average(off[near], weights=weight[near]))
    return turn, agreeing / float(weight.sum()) * agreeing / (agreeing + ENOUGH)


def _quarter(degrees: np.ndarray) -> np.ndarray:
    """Degrees modulo a quarter turn, -45 to 45."""
    return (degrees + 45.0) % 90.0 - 45.0


def _middle(ego: np.ndarray, frame: Frame) -> np.ndarray:
    """World position (2,) of the ego car's patch; the frame's centre where there is none."""
    if not ego.any():
        return np.zeros(2)
    v, u = np.nonzero(ego)
    return frame.to_world(np.array([u.mean() + 0.5, v.mean() + 0.5]))


def _lines(strokes: _Edges, outline: _Edges, direction: float, car: np.ndarray) -> tuple[float | None, float | None]:
    """Where the roadside begins left and right of the car, metres along the normal from the frame's centre."""
    normal = np.array([-math.sin(direction), math.cos(direction)])
    here = float(car @ normal)
    found: list[float | None] = []
    for side in (1, -1):
        line = _line(strokes, direction, normal, here, side, ends=True)
        if line is None:
            line = _line(outline, direction, normal, here, side, ends=False)
        found.append(line)
    return found[0], found[1]


def _line(edges: _Edges, direction: float, normal: np.ndarray, here: float, side: int, ends: bool) -> float | None:
    """The line to one side of the car that has both: edges along it and, with `ends`, separating lines that end there.

    Lane lines and walkways run beside the roadside and are as long, but no separating line begins at them.
    """
    across = (edges.ends @ normal - here) * side
    off = np.degrees(np.abs((edges.angle - direction + math.pi / 2) % math.pi - math.pi / 2))
    along, between = off < AGREEING, off > 30.0
    offset, length = across[along].mean(1), edges.length[along]
    begins = across[between].min(1) if ends else np.empty(0)
    grid = np.arange(LINE, max(across.max(initial=0.0), 2 * LINE), 0.05)
    long = np.minimum((length * _bell(grid, offset)).sum(1), LONGEST)
    # 0.3 m: what counts where an entrance line is not painted at all.
    votes = (long + 0.3) * (1 + _bell(grid, begins).sum(1))
    best = float(grid[votes.argmax()])
    if votes.max() < LEAST_VOTES:
        return None
    near = np.abs(offset - best) < 2 * LINE
    return here + side * (float(np.average(offset[near], weights=length[near])) if near.any() else best)


def _bell(grid: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """How much each of the offsets (N,) says for each place of the grid (M,): (M, N), 0 to 1."""
    return np.exp(-0.5 * ((grid[:, None] - offset) / LINE) ** 2)
