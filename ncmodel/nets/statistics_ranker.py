"""A ranker on plain numbers: how good a drawing is, by how much of which lines it shows and how much there is.

Some small networks vote (their mean is the score), each trained on its own draws of the pairs. Beside them stands the
habit: what they think of each setting on average over the training views. Where numbers say little of a view, the habit
should decide; how much each counts is learnt on validation votes (`mix`).
"""

import torch
from torch import Tensor, nn

from ncmodel.nets.presets import StatisticsDims

VOICES = ("statistics", "habit", "picture")
"""What `mix` weighs: this ranker, its habit, and the ranking module that looks at pictures."""


class StatisticsRanker(nn.Module):
    """Scores of drawings from their numbers; higher is better.

    Letters in shapes: N drawings, F numbers, E networks, S settings.

    Attributes:
        mean: (F,) of the training drawings' numbers.
        inverse_scale: (F,) one over their standard deviation; 0 for what never varies.
        habit: (S,) mean score of each setting over the training views.
        mix: (3,) weights of `VOICES` in the logarithm of the odds that people prefer one drawing to another.
    """

    mean: Tensor
    inverse_scale: Tensor
    habit: Tensor
    mix: Tensor

    def __init__(self, dims: StatisticsDims) -> None:
        super().__init__()
        self.dims = dims
        self.register_buffer("mean", torch.zeros(dims.numbers))
        self.register_buffer("inverse_scale", torch.ones(dims.numbers))
        self.register_buffer("habit", torch.zeros(dims.settings))
        self.register_buffer("mix", torch.tensor([1.0, 0.0, 0.0]))
        self.first = nn.Parameter(torch.zeros(dims.networks, dims.numbers, dims.width))
        self.bias = nn.Parameter(torch.zeros(dims.networks, 1, dims.width))
        self.last = nn.Parameter(torch.zeros(dims.networks, dims.width, 1))
        self.dropout = nn.Dropout(dims.dropout)

    def initialise(self, generator: torch.Generator) -> None:
        """Draw the weights."""
        for weights in (self.first, self.last):
            nn.init.normal_(weights, std=weights.shape[1] ** -0.5, generator=generator)
        nn.init.zeros_(self.bias)

    def fit_scales(self, numbers: Tensor) -> None:
        """Measure mean and scale on (N, F) numbers."""
        scale, mean = torch.std_mean(numbers, dim=0, correction=0)
        self.mean.copy_(mean)
        self.inverse_scale.copy_(torch.where(scale > 1e-4, 1.0 / scale, torch.zeros_like(scale)))

    def votes(self, numbers: Tensor) -> Tensor:
        """(E, N) scores by each network, of (N, F) numbers or of (E, N, F), each network's own."""
        scaled = self.dropout((numbers - self.mean) * self.inverse_scale)
        hidden = nn.functional.gelu(scaled @ self.first + self.bias)
        scores: Tensor = (hidden @ self.last)[..., 0]
        return scores

    def forward(self, numbers: Tensor) -> Tensor:
        """(N, F) numbers -> (N,) scores."""
        return self.votes(numbers).mean(dim=0)
