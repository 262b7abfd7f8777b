"""The paper's training losses (section 5)."""

import torch
from torch import Tensor
from torch.nn import functional

MARGIN = 1.0
"""m of the ranking loss."""

CERTAINTY = 0.99
"""Of a drawing's full ink, when it is taken for a probability."""


def ranking_loss(better: Tensor, worse: Tensor, margin: float = MARGIN) -> Tensor:
    """Hinge ranking loss L_R: the mean over pairs of max(m - f(better) + f(worse), 0).

    The paper sums; the mean differs by a constant factor, which Adam ignores, and doesn't depend on the batch size.

    Args:
        better: (P,) scores of the preferred drawings.
        worse: (P,) scores of the others.
        margin: By how much the better one should win.

    Raises:
        ValueError: The shapes differ.
    """
    if better.shape != worse.shape:
        raise ValueError(f"scores have shapes {tuple(better.shape)} and {tuple(worse.shape)}, expected equal ones")
    return torch.relu(margin - better + worse).sum() / max(better.numel(), 1)


def pair_accuracy(better: Tensor, worse: Tensor) -> float:
    """Share of pairs ordered as voted; a tie counts half, so that a constant score is at chance. NaN without pairs."""
    if better.numel() == 0:
        return float("nan")
    return float((better > worse).double().mean() + 0.5 * (better == worse).double().mean())


def cross_entropy(logits: Tensor, target: Tensor, emphasis: Tensor | None = None) -> Tensor:
    """Cross-entropy L_ce between a predicted line probability and a drawing's ink, the mean over pixels.

    Every pixel weighs the same, as in the paper: the prediction is then a probability, which is what ridge detection
    expects. Taken from log-odds, so that it stays finite, with finite gradients, where the probability rounds to 0
    or 1.

    Args:
        logits: (B, 1, H, W) log-odds of a line.
        target: (B, 1, H, W) ink in [0, 1].
        emphasis: (B,) how much each drawing counts; 1 by default.
    """
    weight = None if emphasis is None else emphasis[:, None, None, None]
    # Half as many bits would round the loss; twice as many stay.
    exact = logits.to(torch.promote_types(logits.dtype, torch.float32))
    return functional.binary_cross_entropy_with_logits(exact, target, weight)


def ink_cross_entropy(ink: Tensor, target: Tensor) -> Tensor:
    """Cross-entropy L_ce between a drawing's ink, taken for a probability, and another's: the mean over pixels.

    Ink is often 0 or 1 exactly, where the cross-entropy is infinite. So 0 and 1 are taken for 1 - `CERTAINTY` and
    `CERTAINTY`, and what is between in proportion: unlike a clamp, that leaves no pixel without a gradient.

    Args:
        ink: (P,) in [0, 1].
        target: (P,) in [0, 1].
    """
    probability = (1 - CERTAINTY) + (2 * CERTAINTY - 1) * ink
    # Written out: torch's own function refuses to run where autocast is on.
    return -(target * probability.log() + (1 - target) * (1 - probability).log()).mean()
