"""The network that finds marking points: one grid at one scale, as DMPR-PS has it, with a small body of our own."""

from __future__ import annotations

import attrs
import numpy as np
import torch
from torch import nn
from torch.nn import functional

from pavemark.training.detectors.lessons import Lesson

STRIDE = 16
"""Pixels a cell."""

WIDTHS = (24, 48, 96)
"""Channels at 4, 8 and 16 pixels a cell: 0.25 million weights."""

CONFIDENCE, PLACE, DIRECTION, SHAPE = slice(0, 1), slice(1, 3), slice(3, 5), slice(5, 6)
"""Where in the grid's channels each is."""

NEAR = 0.05
"""Cells below which an error of place counts by its square: a pixel. Beyond it counts by its length, for labels set by
hand are now and then far off."""

RARE = -3.5
"""Logit of the confidence to begin with: a cell in thirty has a point."""


class Points(nn.Module):
    """Finds marking points: family "dmpr", and the first half of the others.

    Display RGB (N, 3, H, W), 0 to 1, sides whole STRIDEs → raw grid (N, 6, H/STRIDE, W/STRIDE), and the features it
    was made from at 4, 8 and 16 pixels a cell.
    """

    family = "dmpr"

    def __init__(self) -> None:
        super().__init__()
        fine, middle, coarse = WIDTHS
        self.fine = nn.Sequential(*_conv(3, fine, 6, 4), *_conv(fine, fine))
        self.middle = nn.Sequential(*_conv(fine, middle, 3, 2), *_conv(middle, middle))
        self.coarse = nn.Sequential(*_conv(middle, coarse, 3, 2), *_conv(coarse, coarse), *_conv(coarse, coarse))
        self.head = nn.Conv2d(coarse, 6, 1)
        with torch.no_grad():
            self.head.bias[0] = RARE

    def forward(self, image: torch.Tensor) -> tuple[torch.Tensor, list[torch.Tensor]]:
        # Learning in bfloat16 halves the time; places are told apart in more digits than it has.
        with torch.autocast("cpu", torch.bfloat16, enabled=self.training):
            fine = self.fine(image - 0.4)
            middle = self.middle(fine)
            coarse = self.coarse(middle)
        features = [fine.float(), middle.float(), coarse.float()]
        return self.head(features[-1]), features

    def loss(self, image: torch.Tensor, lessons: list[Lesson]) -> dict[str, torch.Tensor]:
        """What is to be made small, by its name; `lessons` are those that the images are of."""
        raw, _ = self(image)
        return point_losses(raw, targets(lessons, raw.shape[-2:]))

    def outputs(self, image: torch.Tensor) -> dict[str, torch.Tensor]:
        """What the ONNX file gives, by name."""
        raw, features = self(image)
        return {"grid": activated(raw), "embedding": features[-1].mean((2, 3))}


def _conv(before: int, width: int, side: int = 3, stride: int = 1) -> list[nn.Module]:
    conv = nn.Conv2d(before, width, side, stride, (side - 1) // 2 if side % 2 else 1, bias=False)
    return [conv, nn.BatchNorm2d(width), nn.SiLU(inplace=True)]


def activated(raw: torch.Tensor) -> torch.Tensor:
    """The grid of the contract from the raw one: shares, a unit vector and a probability (N, 6, R, C)."""
    direction = functional.normalize(raw[:, DIRECTION], dim=1, eps=1e-6)
    return torch.cat([torch.sigmoid(raw[:, :3]), direction, torch.sigmoid(raw[:, SHAPE])], 1)


@attrs.frozen(eq=False)
class Targets:
    """What a grid should say.

    Attributes
    ----------
    grid : Tensor (N, 6, R, C)
        As the activated grid; nought where there is no point.
    there : Tensor (N, 1, R, C)
        1 where there is a point.
    known : Tensor (N, 1, R, C)
        1 where its direction and shape are labelled too.
    cells : list of dict of int to (row, column)
        Of each image, the cell of each point that has one: of several in a cell one only.
    """

    grid: torch.Tensor
    there: torch.Tensor
    known: torch.Tensor
    cells: list[dict[int, tuple[int, int]]]


def targets(lessons: list[Lesson], size: tuple[int, int]) -> Targets:
    """What a grid of `size` rows and columns should say of images.

    Of several points in a cell the one nearest to its middle counts, as in `pavemark.select.point_loss`.
    """
    rows, columns = size
    grid = np.zeros((len(lessons), 6, rows, columns), np.float32)
    known = np.zeros((len(lessons), 1, rows, columns), np.float32)
    cells: list[dict[int, tuple[int, int]]] = []
    for n, lesson in enumerate(lessons):
        place, cell = np.modf(lesson.points / STRIDE)
        taken: dict[tuple[int, int], int] = {}
        # The nearest comes last, and stays.
        for k in np.lexsort((lesson.points[:, 0], lesson.points[:, 1], ((place - 0.5) ** 2).sum(1)))[::-1].tolist():
            at = int(cell[k, 1]), int(cell[k, 0])
            taken[at] = k
            grid[n, 0, *at] = 1
            grid[n, PLACE, *at] = place[k]
            if lesson.directions is not None and lesson.l_shaped is not None:
                known[n, 0, *at] = 1
                grid[n, DIRECTION, *at] = lesson.directions[k]
                grid[n, SHAPE, *at] = lesson.l_shaped[k]
        cells.append({k: at for at, k in taken.items()})
    told = torch.from_numpy(grid)
    return Targets(told, told[:, CONFIDENCE], torch.from_numpy(known), cells)


def point_losses(raw: torch.Tensor, wanted: Targets) -> dict[str, torch.Tensor]:
    """The parts of the loss of a raw grid, each per true point.

    The confidence is learnt as a probability, by cross entropy: the point loss's square is met by the same values, and
    cross entropy also learns where it is quite wrong.
    """
    grid, there, known = wanted.grid, wanted.there, wanted.known
    points, labelled = there.sum().clamp(min=1), known.sum().clamp(min=1)
    entropy = functional.binary_cross_entropy_with_logits(raw[:, CONFIDENCE], there, reduction="sum")
    off = functional.smooth_l1_loss(torch.sigmoid(raw[:, PLACE]), grid[:, PLACE], reduction="none", beta=NEAR)
    place = (off * there).sum()
    unit = functional.normalize(raw[:, DIRECTION], dim=1, eps=1e-6)
    direction = ((unit - grid[:, DIRECTION]) ** 2 * known).sum()
    shape = functional.binary_cross_entropy_with_logits(raw[:, SHAPE], grid[:, SHAPE], reduction="none")
    return {
        "confidence": entropy / points,
        "place": 5 * place / points,
        "direction": direction / labelled,
        "shape": 0.5 * (shape * known).sum() / labelled,
    }
