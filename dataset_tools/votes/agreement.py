"""How far participants agree, and what else their answers depend on."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dataset_tools.votes.votes import Vote
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.types import Floats

CHOICES = DRAWINGS + 1


def krippendorff_alpha(votes: Sequence[Vote]) -> float | None:
    """Krippendorff's alpha over items, for nominal answers; 1 perfect agreement, 0 what chance gives.

    Every item has its own drawings, so answers of different items aren't of the same kind; what chance gives is taken
    over the candidates' numbers, which mean nothing across items and are therefore as good as random.

    Returns:
        None where no item has two votes, or all votes are equal.

    References:
        K. Krippendorff, Content Analysis, 2004.
    """
    import krippendorff

    counts = _counts(votes)
    if not (counts.sum(axis=1) > 1).any() or (counts.sum(axis=0) > 0).sum() < 2:
        return None
    return float(krippendorff.alpha(value_counts=counts, level_of_measurement="nominal"))


def _counts(votes: Sequence[Vote]) -> Floats:
    """(items, 9) votes for each choice."""
    rows = {item: row for row, item in enumerate(sorted({vote.item for vote in votes}))}
    counts = np.zeros((len(rows), CHOICES))
    for vote in votes:
        counts[rows[vote.item], vote.drawing + 1] += 1
    return counts


@dataclass(frozen=True)
class PositionBias:
    """How often each position on the page was chosen.

    Attributes:
        counts: Votes for positions 1..8.
        p_value: Of the chi-square test that all are chosen equally often; None without votes.
    """

    counts: tuple[int, ...]
    p_value: float | None


def position_bias(votes: Sequence[Vote]) -> PositionBias:
    """Whether participants favour positions; the drawings' order is random, so they shouldn't."""
    from scipy.stats import chisquare

    found = Counter(vote.position for vote in votes if vote.position)
    counts = tuple(found[place] for place in range(1, DRAWINGS + 1))
    return PositionBias(counts, float(chisquare(counts).pvalue) if sum(counts) else None)


def agreeing_share(votes: Sequence[Vote]) -> dict[str, tuple[int, int]]:
    """Worker -> (agreements, comparisons) with each other worker who voted on the same item."""
    by_item: dict[Item, list[Vote]] = {}
    for vote in votes:
        by_item.setdefault(vote.item, []).append(vote)
    agreed: Counter[str] = Counter()
    compared: Counter[str] = Counter()
    for group in by_item.values():
        choices = Counter(vote.drawing for vote in group)
        for vote in group:
            agreed[vote.worker] += choices[vote.drawing] - 1
            compared[vote.worker] += len(group) - 1
    return {worker: (agreed[worker], compared[worker]) for worker in sorted(compared)}
