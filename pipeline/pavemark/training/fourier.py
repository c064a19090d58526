"""A network that fills holes in the ground: fast Fourier convolutions, after LaMa (Suvorov et al., WACV 2022).

A joint of paving on one side of a hole says where the joints of the other side come in only to what sees the whole
picture at once. A convolution in the frequency domain does. The Fourier transform is written as matrix products, whose
matrices are made from the size of the input: exact at any size, and every runtime has the operators.

The network sees no brightness and no contrast. A blur of the known ground is taken off the picture, what is left is
divided by its own local strength, and what the network makes is put back the same way. In the hole it starts from a
membrane stretched across it, which joins without a step: what it makes is what ground has beyond that.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

CELL = 4
"""Pixels a side of a cell: the network works on cells, each pixel of one a channel of its own."""

FINE = 64
"""Channels of the cells on the way in and out."""

WIDTH, LOCAL = 128, 64
"""Channels of a layer of blocks of 2×2 cells, and those of them that see their neighbours only; the others go through
the spectrum."""

BLOCKS = 4
"""Residual blocks of two layers each."""

REACHES = (16.0, 6.0, 2.0)
"""Cells, standard deviations of the blurs of the smooth guess: each is believed where it finds known ground."""

FINER = (2.0, 1.0)
"""Standard deviations of the blurs that carry the known ground into the hole, in steps of two pixels."""

COARSE_SIDES, SIDES = (5,) * 3 + (3,) * 4, (5, 3, 3)
"""Sides of the means by which the membrane is pulled tight, first in steps of two pixels, then of one."""

STRENGTH_REACH = 12.0
"""Cells, standard deviation of the blur by which the local strength is measured."""

WEAKEST = 1.5 / 255
"""Least strength that what is left is divided by: below it there is nothing but rounding."""

LATTICE_REACH = 3.0
"""Blocks of 2×2 cells, standard deviation of the blur that finds what repeats from block to block."""

GRAIN = 64
"""Cells a side of the tile of noise that the network makes grain from; the tile repeats."""


def waves(length: int | Tensor, kept: int | Tensor, like: Tensor) -> tuple[Tensor, Tensor]:
    """Cosines and sines (length, kept) of the frequencies 0 … kept - 1 of a signal of so many samples."""
    n = torch.arange(length, device=like.device)
    k = torch.arange(kept, device=like.device)
    # The product is brought under one turn while it is still whole: float32 knows no large angle exactly.
    turns = (n[:, None] * k[None, :]) % length
    angle = turns.to(torch.float32) * (2 * torch.pi / length)
    return angle.cos().to(like.dtype), angle.sin().to(like.dtype)


def spectrum(x: Tensor) -> tuple[Tensor, Tensor]:
    """The half spectrum of real arrays, orthonormal: `torch.fft.rfft2(x, norm="ortho")`, real part and imaginary part.

    Parameters
    ----------
    x : Tensor (..., H, W)

    Returns
    -------
    tuple of Tensor (..., H, W // 2 + 1)
    """
    height, width = x.shape[-2:]
    cos, sin = waves(width, width // 2 + 1, x)
    real, imaginary = x @ cos, -(x @ sin)
    cos, sin = waves(height, height, x)
    norm = (height * width) ** -0.5
    return (cos @ real + sin @ imaginary) * norm, (cos @ imaginary - sin @ real) * norm


def signal(real: Tensor, imaginary: Tensor, width: int | Tensor) -> Tensor:
    """Real arrays (..., H, W) from their half spectrum: `torch.fft.irfft2(…, norm="ortho")`."""
    height, kept = real.shape[-2:]
    cos, sin = waves(height, height, real)
    real, imaginary = cos @ real - sin @ imaginary, cos @ imaginary + sin @ real
    cos, sin = waves(width, kept, real)
    k = torch.arange(kept, device=real.device)
    # All but the constant and, of an even width, the fastest wave stand for their mirror images too.
    twice = 2.0 - (k == 0).to(real.dtype) - (2 * k == width).to(real.dtype)
    return ((real * twice) @ cos.T - (imaginary * twice) @ sin.T) * (height * width) ** -0.5


class Spectral(nn.Module):
    """A convolution over the frequencies of the whole picture."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        half = channels // 2
        self.enter = nn.Conv2d(channels, half, 1)
        self.mix = nn.Conv2d(2 * half, 2 * half, 1)
        self.leave = nn.Conv2d(half, channels, 1)

    def forward(self, x: Tensor) -> Tensor:
        x = _bent(self.enter(x))
        real, imaginary = _bent(self.mix(torch.cat(spectrum(x), 1))).chunk(2, 1)
        return self.leave(x + signal(real, imaginary, x.shape[-1]))


class Layer(nn.Module):
    """A fast Fourier convolution: neighbours for one share of the channels, the spectrum for the other, and across."""

    def __init__(self) -> None:
        super().__init__()
        self.local = _conv(LOCAL, WIDTH)
        self.whole = _conv(WIDTH - LOCAL, LOCAL)
        self.spectral = Spectral(WIDTH - LOCAL)

    def forward(self, x: Tensor) -> Tensor:
        local, whole = x.split((LOCAL, WIDTH - LOCAL), 1)
        return self.local(local) + torch.cat([self.whole(whole), self.spectral(whole)], 1)


class Block(nn.Module):
    """Two layers, added to what came in."""

    def __init__(self) -> None:
        super().__init__()
        self.first, self.second = Layer(), Layer()
        self.gain = nn.Parameter(torch.full((1, WIDTH, 1, 1), 0.2))

    def forward(self, x: Tensor) -> Tensor:
        return x + self.gain * self.second(_bent(self.first(_bent(x))))


def _conv(inward: int, outward: int, stride: int = 1) -> nn.Conv2d:
    return nn.Conv2d(inward, outward, 3, stride, padding=1)


def _bent(x: Tensor) -> Tensor:
    return functional.leaky_relu(x, 0.1)


class Filler(nn.Module):
    """The network.

    Its forward pass takes `image` (B, 3, H, W), display sRGB from 0 to 1, and `mask` (B, 1, H, W), 1 in the hole and
    0 elsewhere, H and W multiples of 8, and gives the filled image (B, 3, H, W), 0 to 1, unchanged outside the hole.
    """

    def __init__(self) -> None:
        super().__init__()
        cells = CELL * CELL
        self.enter = _conv(5 * cells + 3, FINE)
        self.down = _conv(FINE, WIDTH, 2)
        self.blocks = nn.Sequential(*(Block() for _ in range(BLOCKS)))
        self.up = nn.Conv2d(WIDTH, 4 * FINE, 1)
        self.join = _conv(2 * FINE, FINE)
        self.last = _conv(FINE, FINE)
        self.leave = _conv(FINE, 3 * cells)
        self.register_buffer("grain", torch.randn(1, cells, GRAIN, GRAIN))
        for number, reach in enumerate((*REACHES, STRENGTH_REACH)):
            self.register_buffer(f"bell{number}", _bell(reach), persistent=False)
        self.register_buffer("repeated", _bell(LATTICE_REACH), persistent=False)
        for number, reach in enumerate(FINER):
            self.register_buffer(f"finer{number}", _bell(reach), persistent=False)

    def forward(self, image: Tensor, mask: Tensor) -> Tensor:
        smooth, strength = self.guess(image, mask)
        base = self.membrane(image, mask, smooth)
        made = base + strength * self.detail(base, mask, smooth, strength, self._tiled(mask))
        return image * (1 - mask) + made.clamp(0, 1) * mask

    def guess(self, image: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        """The smooth guess (B, 3, H, W), and the strength (B, 1, H, W) of what it leaves out."""
        known = 1 - mask
        weight = functional.avg_pool2d(known, CELL)
        colour = functional.avg_pool2d(image * known, CELL)
        mean = colour.mean((2, 3), keepdim=True) / weight.mean((2, 3), keepdim=True).clamp_min(1e-4)
        smooth = mean.expand_as(colour)
        both = torch.cat([colour, weight], 1)
        for number in range(len(REACHES)):
            spread = _blurred(both, getattr(self, f"bell{number}"))
            smooth = (spread[:, :3] + 0.01 * smooth) / (spread[:, 3:] + 0.01)
        smooth = functional.interpolate(smooth, scale_factor=CELL, mode="bilinear", align_corners=False)
        left = ((image - smooth) * known).square().mean(1, keepdim=True)
        energy = functional.avg_pool2d(left, CELL)
        mean = energy.mean((2, 3), keepdim=True) / weight.mean((2, 3), keepdim=True).clamp_min(1e-4)
        spread = _blurred(torch.cat([energy, weight], 1), getattr(self, f"bell{len(REACHES)}"))
        energy = (spread[:, :1] + 0.05 * mean) / (spread[:, 1:] + 0.05)
        energy = functional.interpolate(energy, scale_factor=CELL, mode="bilinear", align_corners=False)
        return smooth, (energy + WEAKEST**2).sqrt()

    def membrane(self, image: Tensor, mask: Tensor, smooth: Tensor) -> Tensor:
        """The image (B, 3, H, W) with a membrane across the hole."""
        known = 1 - mask
        weight = functional.avg_pool2d(known, 2)
        colour = functional.avg_pool2d(image * known, 2)
        both, x = torch.cat([colour, weight], 1), functional.avg_pool2d(smooth, 2)
        for number in range(len(FINER)):
            spread = _blurred(both, getattr(self, f"finer{number}"))
            x = (spread[:, :3] + 0.02 * x) / (spread[:, 3:] + 0.02)
        loose = (weight == 0).to(image.dtype)
        held = (1 - loose) * colour / weight.clamp_min(0.25)
        x = held + loose * x
        for side in COARSE_SIDES:
            x = held + loose * _averaged(x, side)
        x = functional.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)
        held = image * known
        x = held + mask * x
        for side in SIDES:
            x = held + mask * _averaged(x, side)
        return x

    def detail(self, base: Tensor, mask: Tensor, smooth: Tensor, strength: Tensor, grain: Tensor) -> Tensor:
        """What has to be added to the membrane, in units of the strength: (B, 3, H, W)."""
        left = ((base - smooth) / strength).clamp(-8, 8)
        coarse = functional.avg_pool2d(smooth, CELL)
        level = coarse.mean((2, 3), keepdim=True)
        coarse = ((coarse - level) / functional.avg_pool2d(strength, CELL)).clamp(-20, 20) * 0.2
        x = torch.cat([functional.pixel_unshuffle(torch.cat([left, mask], 1), CELL), grain, coarse], 1)
        fine = _bent(self.enter(x))
        coarse = self.blocks(self.down(fine))
        x = functional.pixel_shuffle(self.up(_bent(coarse)), 2)
        fine = _bent(self.join(_bent(torch.cat([x, fine], 1))))
        fine = fine + self.last(fine)
        made = self.leave(_bent(fine))
        return functional.pixel_shuffle(made - self._lattice(made, mask), CELL)

    def _lattice(self, made: Tensor, mask: Tensor) -> Tensor:
        """What repeats from block to block, (B, 48, h, w): no ground has a period of 8 pixels, but such networks do."""
        blocks, weight = functional.pixel_unshuffle(made, 2), functional.avg_pool2d(mask, 2 * CELL)
        spread = _blurred(torch.cat([blocks * weight, weight], 1), self.repeated)
        mean = (spread[:, :-1] / spread[:, -1:].clamp_min(1e-3)).unflatten(1, (3, -1))
        return functional.pixel_shuffle((mean - mean.mean(2, keepdim=True)).flatten(1, 2), 2)

    def _tiled(self, mask: Tensor) -> Tensor:
        height, width = mask.shape[-2] // CELL, mask.shape[-1] // CELL
        rows = torch.arange(height, device=mask.device) % GRAIN
        columns = torch.arange(width, device=mask.device) % GRAIN
        tile = self.grain.index_select(2, rows).index_select(3, columns)
        return tile.expand(mask.shape[0], -1, -1, -1)


def _bell(reach: float) -> Tensor:
    """A Gaussian (2n + 1), sum 1, cut off at two and a half standard deviations."""
    x = torch.arange(-round(2.5 * reach), round(2.5 * reach) + 1, dtype=torch.float32)
    bell = torch.exp(-0.5 * (x / reach) ** 2)
    return bell / bell.sum()


def _averaged(x: Tensor, side: int) -> Tensor:
    return functional.avg_pool2d(x, side, 1, side // 2, count_include_pad=False)


def _blurred(x: Tensor, bell: Tensor) -> Tensor:
    """Every channel blurred; beyond the picture is nothing."""
    channels, half = x.shape[1], bell.shape[0] // 2
    x = x.flatten(0, 1)[:, None]
    x = functional.conv2d(x, bell[None, None, :, None], padding=(half, 0))
    x = functional.conv2d(x, bell[None, None, None, :], padding=(0, half))
    return x.unflatten(0, (-1, channels))[:, :, 0]
