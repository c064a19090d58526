"""Detectors that were trained and written as ONNX: "detector 1" (docs/detectors.md)."""

from __future__ import annotations

import math
from pathlib import Path

import attrs
import numpy as np

from pavemark import onnx
from pavemark.detect.detection import Detection
from pavemark.detect.pairing import paired
from pavemark.detect.scaling import scaled, size_at
from pavemark.detect.suppression import strongest
from pavemark.errors import InputError
from pavemark.ground import Frame

CONTRACT = "detector 1"

FAMILIES = ("dmpr", "gcn", "deepps")
"""A family "dmpr" pairs points by rules; the others say themselves which points are a slot's."""

LEAST = 0.05
"""Confidence from which on points and slots are told: down to it precision can be shown against recall."""

SLACK = 1e-3
"""By how much a share may lie outside 0 to 1."""


@attrs.frozen(eq=False)
class Learned:
    """A trained detector; a `pavemark.detect.detection.Detector`.

    Attributes
    ----------
    family : str
    version : str
        SHA-256 of the file.
    pixels_per_metre : float
        The scale it looks at.
    stride : int
        Pixels a cell at that scale.
    """

    family: str
    version: str
    pixels_per_metre: float
    stride: int
    _network: onnx.Network

    def covered(self, frame: Frame) -> tuple[float, float]:
        """Width and height that the grid covers, in pixels of the image."""
        ratio = self._ratio(frame)
        rows, columns = self._cells(frame)
        # By rounding it could be a hair less than the image, and points on its border would lie outside.
        return (
            max(float(frame.width), columns * self.stride * ratio[0]),
            max(float(frame.height), rows * self.stride * ratio[1]),
        )

    def grid(self, image: np.ndarray, frame: Frame) -> np.ndarray:
        """What is said of each cell: (R, C, 3) float64, confidence and place.

        Raises
        ------
        InputError
            When the network fails, or says what is no finite number or no share.
        """
        return self._shares(self._looked(image, frame, "grid")[0][0, :3]).transpose(1, 2, 0)

    def embedding(self, image: np.ndarray, frame: Frame) -> np.ndarray:
        """What the image looks like to the detector: (E,) float64. Near-duplicates lie close to each other.

        Raises
        ------
        InputError
            As `grid`.
        """
        return self._looked(image, frame, "embedding")[0][0].astype(np.float64)

    def look(self, image: np.ndarray, frame: Frame) -> tuple[np.ndarray, np.ndarray]:
        """`grid` and `embedding` at the price of one; it raises what they raise."""
        said, seen = self._looked(image, frame, "grid", "embedding")
        return self._shares(said[0, :3]).transpose(1, 2, 0), seen[0].astype(np.float64)

    def detect(self, image: np.ndarray, frame: Frame) -> Detection:
        """Find points and slots in an image (H, W, 3) uint8, display sRGB.

        Raises
        ------
        InputError
            As `grid`.
        """
        if self.family == "dmpr":
            (said,) = self._looked(image, frame, "grid")
            points, confidence, directions, l_shaped = self._cells_said(said[0])
            pairs = None
        else:
            said, told, pairs = self._looked(image, frame, "grid", "points", "pairs")
            points, confidence, pairs = told[0, :, :2].astype(np.float64), self._shares(told[0, :, 2]), pairs[0]
            pairs = self._shares(pairs)
            places, _, directions, l_shaped = self._cells_said(said[0])
            nearest = np.hypot(*(places[None] - points[:, None]).transpose(2, 0, 1)).argmin(1)
            directions, l_shaped = directions[nearest], l_shaped[nearest]
        points = points * self._ratio(frame)
        # The input reaches beyond the image, to whole cells; and what is likely no point is none.
        within = ((points >= 0) & (points <= (frame.width, frame.height))).all(1)
        chosen = np.flatnonzero(within & (confidence >= LEAST))
        chosen = chosen[strongest(points[chosen] / frame.scale, confidence[chosen])]
        points, confidence = points[chosen], confidence[chosen]
        directions, l_shaped = directions[chosen], l_shaped[chosen]
        if pairs is None:
            slots, sure = paired(points / frame.scale, directions, l_shaped > 0.5, confidence)
        else:
            slots, sure = _told(pairs[np.ix_(chosen, chosen)], confidence)
        likely = sure >= LEAST
        return Detection(points, confidence, directions, l_shaped, slots[likely], sure[likely])

    def _ratio(self, frame: Frame) -> np.ndarray:
        """How many pixels of an image one that the network sees is, right and down."""
        size = frame.width, frame.height
        return np.array(size) / size_at(size, frame.scale, self.pixels_per_metre)

    def _cells(self, frame: Frame) -> tuple[int, int]:
        """Rows and columns of the grid."""
        width, height = size_at((frame.width, frame.height), frame.scale, self.pixels_per_metre)
        return -(-height // self.stride), -(-width // self.stride)

    def _looked(self, image: np.ndarray, frame: Frame, *names: str) -> list[np.ndarray]:
        """What the network says of an image, by the names of its outputs."""
        rows, columns = self._cells(frame)
        seen = scaled(image, frame.scale, self.pixels_per_metre)
        below, beside = rows * self.stride - seen.shape[0], columns * self.stride - seen.shape[1]
        seen = np.pad(seen, ((0, below), (0, beside), (0, 0)), mode="edge")
        planes = np.ascontiguousarray(seen.transpose(2, 0, 1)[None], np.float32) / np.float32(255)
        sides = {port.name: port.shape for port in self._network.outputs}
        shapes = {
            "grid": (1, 6, rows, columns),
            "embedding": (1, sides["embedding"][1]),
            **({} if self.family == "dmpr" else _paired_shapes(sides["points"][1])),
        }
        return self._network.run_all({"image": planes}, {name: shapes[name] for name in names})

    def _cells_said(self, grid: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Place in pixels that the network sees, confidence, direction and probability of an L of every cell."""
        shares = self._shares(grid[[0, 1, 2, 5]])
        rows, columns = grid.shape[1:]
        corner = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), -1)
        points = (corner + shares[1:3].transpose(1, 2, 0)) * self.stride
        arms = grid[3:5].astype(np.float64).transpose(1, 2, 0).reshape(-1, 2)
        lengths = np.hypot(*arms.T)[:, None]
        # A direction of no length is none: any is as good.
        directions = np.where(lengths > 0, arms / np.where(lengths > 0, lengths, 1), (1.0, 0.0))
        return points.reshape(-1, 2), shares[0].ravel(), directions, shares[3].ravel()

    def _shares(self, values: np.ndarray) -> np.ndarray:
        least, most = float(values.min(initial=0)), float(values.max(initial=0))
        if least < -SLACK or most > 1 + SLACK:
            raise InputError(
                self._network.path, f"confidences, places and probabilities run from {least:g} to {most:g}: 0 to 1"
            )
        return np.clip(values.astype(np.float64), 0, 1)


def _paired_shapes(many: int) -> dict[str, tuple[int, ...]]:
    return {"points": (1, many, 3), "pairs": (1, many, many)}


def _told(pairs: np.ndarray, confidence: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slots that a network tells: of two points that may be one either way, the likelier way."""
    pairs = np.minimum(pairs, np.minimum(confidence[:, None], confidence[None]))
    forth = np.triu(pairs >= pairs.T, 1)
    back = np.tril(pairs > pairs.T, -1)
    slots = np.argwhere((forth | back) & (pairs > 0))
    sure = pairs[slots[:, 0], slots[:, 1]]
    order = np.lexsort((slots[:, 1], slots[:, 0], -sure))
    return slots[order].astype(np.int64), sure[order]


def opened(path: Path, threads: int = onnx.THREADS) -> Learned:
    """Open a trained detector.

    Parameters
    ----------
    path : Path
    threads : int
        Threads within an operator; another number gives other last bits.

    Raises
    ------
    InputError
        When it cannot be opened, is no detector, or has other inputs, outputs or metadata than the contract's.
    """
    network = onnx.opened(path, threads)
    said = network.metadata
    if said.get("pavemark") != CONTRACT:
        raise InputError(path, f'is not a detector: its metadata must say "pavemark" = "{CONTRACT}"')
    family = said.get("family")
    if family not in FAMILIES:
        raise InputError(path, f"family = {family!r}: {', '.join(FAMILIES)} are allowed")
    scale, stride = _number(path, said, "pixels_per_metre", 1000), _number(path, said, "stride", 256)
    if stride != int(stride):
        raise InputError(path, f"stride = {stride:g}: a whole number of pixels is allowed")
    _port(path, network.inputs, "image", (None, 3, None, None))
    if len(network.inputs) > 1:
        raise InputError(path, f"has the inputs {', '.join(map(str, network.inputs))}: image alone is allowed")
    _port(path, network.outputs, "grid", (None, 6, None, None))
    _whole(path, _port(path, network.outputs, "embedding", (None, None)).shape[1], "embedding")
    if family != "dmpr":
        many = _port(path, network.outputs, "points", (None, None, 3)).shape[1]
        _whole(path, many, "points")
        _port(path, network.outputs, "pairs", (None, many, many))
    return Learned(family, network.sha256, scale, int(stride), network)


def _number(path: Path, said: dict[str, str], name: str, most: float) -> float:
    try:
        value = float(said.get(name, ""))
    except ValueError:
        value = math.nan
    if not 1 <= value <= most:
        raise InputError(path, f"{name} = {said.get(name)!r}: 1 to {most:g} is allowed in its metadata")
    return value


def _port(path: Path, ports: tuple[onnx.Port, ...], name: str, shape: tuple[int | None, ...]) -> onnx.Port:
    """The port of that name; sides that are None may have any length."""
    for port in ports:
        if port.name != name:
            continue
        fits = len(port.shape) == len(shape) and all(
            None in (wanted, side) or wanted == side for wanted, side in zip(shape, port.shape, strict=True)
        )
        if port.type == "float" and fits:
            return port
        sides = ", ".join("?" if side is None else str(side) for side in shape)
        raise InputError(path, f"{port}: {name} float [{sides}] is allowed")
    raise InputError(path, f"has no {name}: it has {', '.join(map(str, ports))}")


def _whole(path: Path, side: int | None, name: str) -> None:
    if side is None:
        raise InputError(path, f"{name}: its length is free; a fixed one is allowed")
