"""The neural ranking module: how plausible a drawing is for a view (section 3.3, appendix 3). Higher is better."""

import torch
from torch import Tensor, nn

from ncmodel.nets.blocks import Pick, Standardise, residual_stages
from ncmodel.nets.devices import full_numbers
from ncmodel.nets.presets import BACKGROUND, RankingDims


class RankingModule(nn.Module):
    """ResNet-34 with one more stage, drawing and maps as input and one output (table 6), at the width of `dims`.

    The first convolution is linear, so its share that comes from the maps is the same for all drawings of one view. Who
    scores many drawings of a view computes it once (`embed`) and then calls `score`; `forward` does both.

    Args:
        dims: The architecture.
        given: Names of the K maps that it is handed; those that it reads, by default.

    Attributes:
        stem: The 7x7 convolution over drawing and maps (in this order), batch norm after it in `stem_norm`.
        stages: The five groups of residual blocks.
    """

    def __init__(self, dims: RankingDims, given: tuple[str, ...] | None = None) -> None:
        super().__init__()
        self.dims = dims
        self.standardise_drawing = Standardise([0.0])
        self.pick = Pick(given, dims.inputs)
        self.standardise_maps = Standardise([BACKGROUND] * len(dims.inputs))
        self.stem = nn.Conv2d(1 + len(dims.inputs), dims.width, 7, stride=2, padding=3, bias=False)
        self.stem_norm = nn.BatchNorm2d(dims.width)
        self.pool = nn.MaxPool2d(3, stride=2, padding=1)
        self.stages = residual_stages(dims.width, dims.blocks)
        self.head = nn.Linear(dims.width * 2 ** (len(dims.blocks) - 1), 1)

    def embed(self, maps: Tensor) -> Tensor:
        """The stem's share that comes from the maps: (B, K, H, W) -> (B, width, H/2, W/2)."""
        weight = self.stem.weight[:, 1:]
        return nn.functional.conv2d(self.standardise_maps(self.pick(maps)), weight, stride=2, padding=3)

    def score(self, drawings: Tensor, embedded: Tensor) -> Tensor:
        """Scores of drawings whose maps are embedded already.

        Args:
            drawings: (B, 1, H, W) ink.
            embedded: (B, width, H/2, W/2) from `embed`, or (1, ...) when all drawings are of one view.

        Returns:
            (B,) scores, higher is better.
        """
        weight = self.stem.weight[:, :1]
        drawn = nn.functional.conv2d(self.standardise_drawing(drawings), weight, stride=2, padding=3)
        return self.rank(drawn + embedded)

    def rank(self, x: Tensor) -> Tensor:
        """(B, width, H/2, W/2) what the stem makes of drawings and maps -> (B,) scores, higher is better."""
        x = self.pool(torch.relu(self.stem_norm(x)))
        for stage in self.stages:
            x = stage(x)
        # Always in full precision: bfloat16 would round scores to steps of a hundredth.
        with full_numbers(x.device):
            scores: Tensor = self.head(x.mean(dim=(2, 3), dtype=self.head.weight.dtype))[:, 0]
        return scores

    def forward(self, drawings: Tensor, maps: Tensor) -> Tensor:
        """(B, 1, H, W) ink and (B, K, H, W) maps -> (B,) scores."""
        return self.score(drawings, self.embed(maps))
