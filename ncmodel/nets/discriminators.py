"""pix2pixHD's discriminators, which tell drawings that people chose of a view from others (Wang et al. 2018, 3.2).

Each is a PatchGAN that sees maps and drawing together and says of every patch whether it is real; several of the same
architecture look at the picture at half the resolution of the one before.
"""

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from ncmodel.nets.blocks import Pick, Standardise
from ncmodel.nets.presets import BACKGROUND, TranslationDims

SCALES = 3
"""Discriminators, as in the paper of pix2pixHD."""

LEVELS = 3
"""Convolutions of stride 2 in each."""

SLOPE = 0.2
"""Of the leaky ReLUs, where they leak."""

WIDEST = 8
"""Channels stop to double at so many times the first ones."""


class PatchDiscriminator(nn.Module):
    """4x4 convolutions, of which `LEVELS` halve the resolution: (B, inputs, H, W) -> what every layer says."""

    def __init__(self, inputs: int, width: int) -> None:
        super().__init__()
        layers: list[nn.Module] = [nn.Sequential(_convolution(inputs, width, 2), nn.LeakyReLU(SLOPE))]
        channels = width
        for level in range(1, LEVELS + 1):
            outputs = width * min(2**level, WIDEST)
            stride = 2 if level < LEVELS else 1
            norm = nn.InstanceNorm2d(outputs)
            layers.append(nn.Sequential(_convolution(channels, outputs, stride), norm, nn.LeakyReLU(SLOPE)))
            channels = outputs
        layers.append(_convolution(channels, 1, 1))
        self.layers = nn.ModuleList(layers)

    def forward(self, x: Tensor) -> list[Tensor]:
        """The features of every layer; the last one says of each patch how real it is: 1 real, 0 not."""
        found = []
        for layer in self.layers:
            x = layer(x)
            found.append(x)
        return found


def _convolution(inputs: int, outputs: int, stride: int) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 4, stride=stride, padding=2)


class MultiScaleDiscriminator(nn.Module):
    """`SCALES` discriminators, conditioned on the maps that the generator reads.

    Args:
        dims: The generator's: its width and inputs are theirs too.
        given: Names of the K maps that are handed on.
    """

    def __init__(self, dims: TranslationDims, given: tuple[str, ...] | None = None) -> None:
        super().__init__()
        self.pick = Pick(given, dims.inputs)
        self.standardise = Standardise([BACKGROUND] * len(dims.inputs))
        inputs = len(dims.inputs) + 1
        self.scales = nn.ModuleList(PatchDiscriminator(inputs, dims.width) for _ in range(SCALES))

    def forward(self, maps: Tensor, drawings: Tensor) -> list[list[Tensor]]:
        """(B, K, H, W) maps and (B, 1, H, W) drawings -> for each scale, what its discriminator's layers say."""
        x = torch.cat([self.standardise(self.pick(maps)), drawings], dim=1)
        found = []
        for scale in self.scales:
            found.append(scale(x))
            x = functional.avg_pool2d(x, 3, stride=2, padding=1, count_include_pad=False)
        return found


def least_squares(said: Sequence[Sequence[Tensor]], wanted: float) -> Tensor:
    """LSGAN (Mao et al. 2017): mean squared distance of what is said of patches from `wanted`, over the scales."""
    return torch.stack([(layers[-1] - wanted).square().mean() for layers in said]).mean()


def feature_matching(said: Sequence[Sequence[Tensor]], real: Sequence[Sequence[Tensor]]) -> Tensor:
    """How far the layers' features of drawings are from those of real ones, which are targets and get no gradient.

    The mean over scales and layers of the mean absolute difference (Wang et al. 2018, equation 4).
    """
    pairs = [pair for both in zip(said, real, strict=True) for pair in zip(*(b[:-1] for b in both), strict=True)]
    return torch.stack([(made - target.detach()).abs().mean() for made, target in pairs]).mean()
