"""Family "deepps": every two of the best points are looked at again, in a piece that is turned along the way between.

The idea is that of DeepPS (Zhang, Huang, Li, Xiong 2018), whose pairs are classified by their pieces of the image; ours
are pieces of the finest features, and all of them are made within the graph.
"""

from __future__ import annotations

import torch
from torch import nn

from pavemark.training.detectors.network import WIDTHS
from pavemark.training.detectors.pairs import UNLIKELY, Found, Paired

ALONG, ACROSS = (-0.2, 1.2, 20), (0.5, -0.3, 8)
"""From where to where a piece reaches, in lengths of the way from p1 to p2 and to its left, and in how many samples."""

DEPTH = 8
"""Channels of what is cut."""

USUAL = 6.0
"""Cells that are taken as a unit of length."""


class DeepPs(Paired):
    """Points, and a classifier of the pieces between them."""

    family = "deepps"
    most = 16

    def __init__(self) -> None:
        super().__init__()
        self.thin = nn.Conv2d(WIDTHS[0], DEPTH, 1)
        self.piece = nn.Sequential(
            nn.Conv2d(DEPTH, 16, 3, 2, 1),
            nn.SiLU(),
            nn.Conv2d(16, 32, 3, 2, 1),
            nn.SiLU(),
            nn.Flatten(),
        )
        rows, columns = -(-ACROSS[2] // 4), -(-ALONG[2] // 4)
        self.judged = nn.Sequential(nn.Linear(32 * rows * columns + 3, 64), nn.SiLU(), nn.Linear(64, 1))
        nn.init.constant_(self.judged[-1].bias, UNLIKELY)

    def pair_logits(self, features: list[torch.Tensor], found: Found) -> torch.Tensor:
        first = found.at[:, :, None].expand(-1, -1, self.most, -1).flatten(1, 2)
        second = found.at[:, None].expand(-1, self.most, -1, -1).flatten(1, 2)
        along = second - first
        # With v down, what is left of the way as seen.
        left = torch.stack([along[..., 1], -along[..., 0]], -1)
        down, right = torch.meshgrid(torch.linspace(*ACROSS), torch.linspace(*ALONG), indexing="ij")
        places = (
            first[:, :, None]
            + right.flatten()[:, None] * along[:, :, None]
            + down.flatten()[:, None] * left[:, :, None]
        )
        cut = found.sampled(self.thin(features[0]), places).permute(0, 2, 1, 3)
        pieces = cut.reshape(-1, DEPTH, ACROSS[2], ALONG[2])
        length = torch.sqrt((along**2).sum(-1) + 1e-6) / USUAL
        sure = [
            found.confidence[:, :, None].expand(-1, -1, self.most),
            found.confidence[:, None].expand(-1, self.most, -1),
        ]
        told = torch.stack([length.flatten(), *(one.flatten() for one in sure)], -1)
        return self.judged(torch.cat([self.piece(pieces), told], -1)).reshape(-1, self.most, self.most)
