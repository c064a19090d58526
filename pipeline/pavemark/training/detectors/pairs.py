"""What the families that find pairs themselves have in common: the best points, and who of them is paired."""

from __future__ import annotations

import attrs
import numpy as np
import torch
from torch.nn import functional

from pavemark.training.detectors.lessons import Lesson
from pavemark.training.detectors.network import (
    DIRECTION,
    SHAPE,
    STRIDE,
    Points,
    Targets,
    activated,
    point_losses,
    targets,
)

BESIDE = 0.9
"""Cells within which a point beside a more confident one is that point once more."""

ROUNDS = 8
"""Points in a row, each beside the next, up to which it is exact who of them is told once more."""

UNLIKELY = -4.0
"""Logit of a pair to begin with."""

FIRST = 2.0
"""What is added to the confidence of true points as pairs are learnt: they are looked at however unsure they are."""


@attrs.frozen(eq=False)
class Found:
    """The best points of each image, the most confident first.

    Attributes
    ----------
    at : Tensor (N, K, 2)
        Place, in cells.
    confidence : Tensor (N, K)
        Nought where there are no more points.
    direction : Tensor (N, K, 2)
    l_shaped : Tensor (N, K)
    cell : Tensor (N, K) int64
        Row by row.
    size : tuple of int
        Rows and columns.
    """

    at: torch.Tensor
    confidence: torch.Tensor
    direction: torch.Tensor
    l_shaped: torch.Tensor
    cell: torch.Tensor
    size: tuple[int, int]

    def sampled(self, features: torch.Tensor, places: torch.Tensor) -> torch.Tensor:
        """Features (N, C, H, W) at places (N, A, B, 2), in cells: (N, C, A, B)."""
        rows, columns = self.size
        x, y = places[..., 0] * (2 / columns) - 1, places[..., 1] * (2 / rows) - 1
        return functional.grid_sample(
            features, torch.stack([x, y], -1), mode="bilinear", padding_mode="border", align_corners=False
        )


class Paired(Points):
    """Finds points, and says of each pair of the best whether it is the entrance of a slot."""

    most: int
    """K, the number of points that are looked at."""

    def pair_logits(self, features: list[torch.Tensor], found: Found) -> torch.Tensor:
        """(N, K, K): that the points i and j are p1 and p2 of a slot."""
        raise NotImplementedError

    def loss(self, image: torch.Tensor, lessons: list[Lesson]) -> dict[str, torch.Tensor]:
        raw, features = self(image)
        wanted = targets(lessons, raw.shape[-2:])
        losses = point_losses(raw, wanted)
        with torch.no_grad():
            found = best(activated(raw), self.most, FIRST * wanted.there)
        truth, weight = _wanted(lessons, wanted, found)
        # Points are learnt as without pairs, whose errors are many times as large to begin with.
        logits = self.pair_logits([part.detach() for part in features], found)
        entropy = functional.binary_cross_entropy_with_logits(logits, truth, weight, reduction="sum")
        return losses | {"pairs": entropy / truth.sum().clamp(min=1)}

    def outputs(self, image: torch.Tensor) -> dict[str, torch.Tensor]:
        raw, features = self(image)
        grid = activated(raw)
        found = best(grid, self.most)
        # No point is paired with itself, nor one that is not there.
        apart = 1 - torch.eye(self.most)
        there = (found.confidence > 0).float()
        chance = torch.sigmoid(self.pair_logits(features, found)) * apart * there[:, :, None] * there[:, None]
        return {
            "grid": grid,
            "embedding": features[-1].mean((2, 3)),
            "points": torch.cat([found.at * STRIDE, found.confidence[..., None]], -1),
            "pairs": chance,
        }


def best(grid: torch.Tensor, most: int, first: torch.Tensor | None = None) -> Found:
    """The best points of a grid, each once.

    Parameters
    ----------
    grid : Tensor (N, 6, R, C)
        Activated.
    most : int
        How many.
    first : Tensor (N, 1, R, C), or None
        What is added to the confidence where it is asked which are the best.
    """
    rows, columns = grid.shape[-2:]
    across = torch.arange(columns).to(grid) + grid[:, 1]
    down = torch.arange(rows).to(grid)[:, None] + grid[:, 2]
    rank = grid[:, 0] if first is None else grid[:, 0] + first[:, 0]
    told = torch.stack([across, down, *grid[:, DIRECTION].unbind(1), grid[:, SHAPE][:, 0], grid[:, 0], rank], 1)
    # A small picture has fewer cells than points are asked for.
    told = torch.cat([told.flatten(2), told.new_zeros(told.shape[0], told.shape[1], 2 * most)], 2)
    _, cell = torch.topk(told[:, -1], 2 * most)
    told = _taken(told, cell)
    gap = told[:, :2, :, None] - told[:, :2, None]
    beside = ((gap**2).sum(1) < BESIDE**2) * torch.tril(torch.ones(2 * most, 2 * most), -1)
    alone = torch.ones_like(told[:, 0])
    # Who is left out itself leaves nobody out, so that each round settles one more of a row of neighbours.
    for _ in range(ROUNDS):
        alone = ((beside * alone[:, None]).sum(2) == 0).to(grid)
    _, chosen = torch.topk(told[:, -1] * alone, most)
    told, alone, cell = _taken(told, chosen), torch.gather(alone, 1, chosen), torch.gather(cell, 1, chosen)
    return Found(
        told[:, :2].transpose(1, 2), told[:, 5] * alone, told[:, 2:4].transpose(1, 2), told[:, 4], cell, (rows, columns)
    )


def _taken(told: torch.Tensor, chosen: torch.Tensor) -> torch.Tensor:
    return torch.gather(told, 2, chosen[:, None].expand(-1, told.shape[1], -1))


def _wanted(lessons: list[Lesson], wanted: Targets, found: Found) -> tuple[torch.Tensor, torch.Tensor]:
    """What is to be said of each pair (N, K, K), and how much it counts: nought where no slots are labelled."""
    many, most = found.cell.shape
    truth = np.zeros((many, most, most), np.float32)
    weight = np.zeros((many, most, most), np.float32)
    for n, lesson in enumerate(lessons):
        if lesson.slots is None:
            continue
        weight[n] = 1 - np.eye(most)
        number = {cell: k for k, cell in reversed(list(enumerate(found.cell[n].tolist())))}
        places = {point: number.get(row * found.size[1] + column) for point, (row, column) in wanted.cells[n].items()}
        for i, j in lesson.slots.tolist():
            one, other = places.get(i), places.get(j)
            if one is not None and other is not None:
                truth[n, one, other] = 1
    return torch.from_numpy(truth), torch.from_numpy(weight)
