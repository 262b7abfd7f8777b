"""The image translation branch: maps of a view in, per-pixel line probability out (section 3.2, appendix 2)."""

import itertools

import torch
from torch import Tensor, nn

from ncmodel.nets.blocks import Pick, ResidualBlock, Standardise, conv_norm
from ncmodel.nets.presets import BACKGROUND, Blocks, TranslationDims


def _up(inputs: int, outputs: int, style: Blocks) -> nn.Sequential:
    """The tables' Conv(3x3, stride=1/2): (B, inputs, H, W) -> (B, outputs, 2H, 2W), batch norm, ReLU."""
    biased = style == "pix2pixhd"
    convolution = nn.ConvTranspose2d(inputs, outputs, 3, stride=2, padding=1, output_padding=1, bias=biased)
    return nn.Sequential(convolution, nn.BatchNorm2d(outputs), nn.ReLU(inplace=True))


class TranslationBranch(nn.Module):
    """Table 5 of the paper's appendix, at the width and depth of `dims`.

    Args:
        dims: The architecture.
        given: Names of the K maps that it is handed; those that it reads, by default.

    Attributes:
        layers: The rows of the table in order, without the input and with the last sigmoid left to `forward`.
    """

    def __init__(self, dims: TranslationDims, given: tuple[str, ...] | None = None) -> None:
        super().__init__()
        self.dims, style = dims, dims.style
        widths = [dims.width * 2**level for level in range(dims.levels + 1)]
        ends = list(itertools.pairwise(widths))
        self.pick = Pick(given, dims.inputs)
        self.standardise = Standardise([BACKGROUND] * len(dims.inputs))
        self.layers = nn.ModuleList(
            [
                nn.Sequential(conv_norm(len(dims.inputs), dims.width, 7, 1, style), nn.ReLU(inplace=True)),
                *(nn.Sequential(conv_norm(a, b, 3, 2, style), nn.ReLU(inplace=True)) for a, b in ends),
                nn.Sequential(*(ResidualBlock(widths[-1], widths[-1], 1, style) for _ in range(dims.blocks))),
                *(_up(b, a, style) for a, b in reversed(ends)),
                nn.Conv2d(dims.width, 1, 7, padding=3, padding_mode="reflect" if style == "pix2pixhd" else "zeros"),
            ]
        )

    def logits(self, maps: Tensor) -> Tensor:
        """(B, K, H, W) maps -> (B, 1, H, W) log-odds of a line; H and W multiples of 2^levels."""
        return self.translate(self.standardise(self.pick(maps)))

    def translate(self, x: Tensor) -> Tensor:
        """(B, inputs, H, W) standardised maps -> (B, 1, H, W) log-odds of a line."""
        for layer in self.layers:
            x = layer(x)
        return x

    def forward(self, maps: Tensor) -> Tensor:
        """(B, K, H, W) maps -> (B, 1, H, W) probability of a line at each pixel."""
        return torch.sigmoid(self.logits(maps))

    def expect_ink(self, share: float) -> None:
        """Start from the prior: the last bias makes an untrained branch predict `share` of ink everywhere."""
        last = self.layers[-1]
        assert isinstance(last, nn.Conv2d)
        assert last.bias is not None
        with torch.no_grad():
            last.bias.fill_(torch.logit(torch.tensor(share), eps=1e-3).item())
