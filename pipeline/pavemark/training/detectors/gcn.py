"""Family "gcn": the best points tell each other what they see, and pairs are the edges of their graph.

The idea is that of attentional graph networks for slots (Min, Xu, Gong, Xiao 2021); the layers are our own.
"""

from __future__ import annotations

import math

import torch
from torch import nn

from pavemark.training.detectors.network import WIDTHS
from pavemark.training.detectors.pairs import UNLIKELY, Found, Paired

WIDTH, HEADS, LAYERS = 64, 4, 3
"""Numbers that describe a point, heads of attention, and how often points tell each other."""

REACH = 8.0
"""Cells that are taken as a unit of length."""

SEEN = WIDTHS[1] + WIDTHS[2] + 6
"""What is told of a point to begin with: features, place, direction, shape, confidence."""

BETWEEN = 9
"""What is told of a pair: way, length, both directions along and across it, both shapes."""


class Gcn(Paired):
    """Points, and a graph of them."""

    family = "gcn"
    most = 24

    def __init__(self) -> None:
        super().__init__()
        self.told = _layers(SEEN, WIDTH, WIDTH)
        self.talks = nn.ModuleList(_Talk() for _ in range(LAYERS))
        self.edge = _layers(2 * WIDTH + BETWEEN, WIDTH, 1)
        nn.init.constant_(self.edge[-1].bias, UNLIKELY)

    def pair_logits(self, features: list[torch.Tensor], found: Found) -> torch.Tensor:
        rows, columns = found.size
        seen = [found.sampled(part, found.at[:, :, None])[..., 0].transpose(1, 2) for part in features[1:]]
        middle = torch.stack([found.at[..., 0] - columns / 2, found.at[..., 1] - rows / 2], -1) / REACH
        points = torch.cat([*seen, middle, found.direction, found.l_shaped[..., None], found.confidence[..., None]], -1)
        points = self.told(points)
        # What is hardly a point has little to say.
        heard = torch.log(found.confidence + 1e-3)[:, None, None]
        for talk in self.talks:
            points = points + talk(points, heard)
        one = points[:, :, None].expand(-1, -1, self.most, -1)
        other = points[:, None].expand(-1, self.most, -1, -1)
        return self.edge(torch.cat([one, other, between(found)], -1))[..., 0]


class _Talk(nn.Module):
    """What each point hears from all: (N, K, WIDTH) → (N, K, WIDTH)."""

    def __init__(self) -> None:
        super().__init__()
        self.asked = nn.Linear(WIDTH, 3 * WIDTH)
        self.heard = _layers(2 * WIDTH, 2 * WIDTH, WIDTH)

    def forward(self, points: torch.Tensor, heard: torch.Tensor) -> torch.Tensor:
        parts = self.asked(points).unflatten(-1, (3, HEADS, WIDTH // HEADS)).permute(2, 0, 3, 1, 4)
        asks, answers, says = parts[0], parts[1], parts[2]
        attention = torch.softmax(asks @ answers.transpose(-1, -2) / math.sqrt(WIDTH // HEADS) + heard, -1)
        message = (attention @ says).transpose(1, 2).flatten(2)
        return self.heard(torch.cat([points, message], -1))


def between(found: Found) -> torch.Tensor:
    """How two points lie and point to each other: (N, K, K, BETWEEN)."""
    way = (found.at[:, None] - found.at[:, :, None]) / REACH
    length = torch.sqrt((way**2).sum(-1, keepdim=True) + 1e-6)
    along = way / length
    told = [way, length]
    for direction in (found.direction[:, :, None], found.direction[:, None]):
        told.append((along * direction).sum(-1, keepdim=True))
        told.append(along[..., :1] * direction[..., 1:] - along[..., 1:] * direction[..., :1])
    shape = found.l_shaped[..., None]
    told += [(shape[:, :, None] + 0 * length), (shape[:, None] + 0 * length)]
    return torch.cat(told, -1)


def _layers(before: int, width: int, after: int) -> nn.Sequential:
    return nn.Sequential(nn.Linear(before, width), nn.SiLU(), nn.Linear(width, after))
