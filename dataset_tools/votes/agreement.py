"""How far participants agree, and what else their answers depend on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import chdtrc

from dataset_tools.votes.votes import ITEM, drawings_of
from ncmodel.data.item import DRAWINGS


def krippendorff_alpha(votes: pd.DataFrame) -> float | None:
    """Krippendorff's alpha over items, for nominal answers; 1 perfect agreement, 0 what chance gives.

    Every item has its own drawings, so answers of different items aren't of the same kind; what chance gives is taken
    over the candidates' numbers, which mean nothing across items and are therefore as good as random.

    Returns:
        None where no item has two votes, or all votes are equal.

    References:
        K. Krippendorff, Content Analysis, 2004.
    """
    import krippendorff

    found = votes.assign(drawing=drawings_of(votes)).groupby([*ITEM, "drawing"]).size().unstack(fill_value=0)
    counts = found.reindex(columns=range(-1, DRAWINGS), fill_value=0).to_numpy(np.float64)
    if not (counts.sum(axis=1) > 1).any() or (counts.sum(axis=0) > 0).sum() < 2:
        return None
    return float(krippendorff.alpha(value_counts=counts, level_of_measurement="nominal"))


@dataclass(frozen=True)
class PositionBias:
    """How often each position on the page was chosen.

    Attributes:
        counts: Votes for positions 1..8.
        p_value: Of the chi-square test that all are chosen equally often; None without votes.
    """

    counts: tuple[int, ...]
    p_value: float | None


def position_bias(votes: pd.DataFrame) -> PositionBias:
    """Whether participants favour positions; the drawings' order is random, so they shouldn't."""
    found = votes["position"].value_counts()
    counts = tuple(int(found.get(place, 0)) for place in range(1, DRAWINGS + 1))
    return PositionBias(counts, evenness(counts) if sum(counts) else None)


def evenness(counts: Sequence[int]) -> float:
    """The p value of Pearson's chi-square test that all counts, of which one is above 0, come of equal chances."""
    # As `scipy.stats.chisquare`, which takes a millisecond to look at its arguments: one for each of many participants.
    expected = sum(counts) / len(counts)
    return float(chdtrc(len(counts) - 1, sum((count - expected) ** 2 for count in counts) / expected))


def agreeing_share(votes: pd.DataFrame) -> dict[str, tuple[int, int]]:
    """Worker -> (agreements, comparisons) with each other worker who voted on the same item."""
    drawn = votes.assign(drawing=drawings_of(votes))
    shares = pd.DataFrame(
        {
            "worker": drawn["worker"],
            "agreed": drawn.groupby([*ITEM, "drawing"])["worker"].transform("size") - 1,
            "compared": drawn.groupby(ITEM)["worker"].transform("size") - 1,
        }
    )
    return {worker: (agreed, compared) for worker, agreed, compared in shares.groupby("worker").sum().itertuples()}
