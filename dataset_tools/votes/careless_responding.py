"""Signs that a participant didn't look, beyond failed sentinels: for the audit, and for stricter aggregation.

None of them proves anything, so they exclude nobody unless the requester asks for it.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from statistics import median

import pandas as pd
from scipy.special import bdtr, bdtrc

from dataset_tools.votes.agreement import agreeing_share, evenness
from ncmodel.data.item import DRAWINGS

FASTEST_SECONDS = 1.5
"""Nobody looks at eight drawings in less, as a median."""

LEAST_LIKELY = 1e-4
"""A sign counts where chance gives it less often than this: once in ten thousand honest participants."""

LEAST_VOTES = 8
"""Fewer answers say nothing."""


def flags(votes: pd.DataFrame) -> dict[str, tuple[str, ...]]:
    """Worker -> signs of not looking; workers without any are left out.

    Args:
        votes: All votes, sentinels too.
    """
    ordered = votes.sort_values(["worker", "assignment", "questionnaire", "question"])
    positions = ordered.dropna(subset="position").groupby("worker")["position"].agg(list)
    times = votes.groupby("worker")["seconds"].agg(["count", "median"])
    agreeing = agreeing_share(votes[~votes["sentinel"]])
    usual = _usual_agreement(agreeing)
    copies = _copies(votes)
    found = {
        worker: (
            *_positions(positions.get(worker, [])),
            *_speed(count, typical),
            *_disagreement(agreeing.get(worker, (0, 0)), usual),
            *copies.get(worker, ()),
        )
        for worker, count, typical in times.itertuples()
    }
    return {worker: signs for worker, signs in found.items() if signs}


def _positions(shown: Sequence[int]) -> list[str]:
    """Always the same answer, or positions in a pattern."""
    if len(shown) < LEAST_VOTES:
        return []
    place, count = Counter(shown).most_common(1)[0]
    if count >= 0.9 * len(shown):
        return [f"answer {place} in {count} of {len(shown)} questions"]
    steps = Counter((b - a) % DRAWINGS for a, b in pairwise(shown))
    step, times = steps.most_common(1)[0]
    if step and bdtrc(times - 1, len(shown) - 1, 1 / DRAWINGS) < LEAST_LIKELY / DRAWINGS:
        return [f"positions in steps of {step}"]
    counts = [shown.count(position) for position in range(1, DRAWINGS + 1)]
    uneven = sum(counts) >= LEAST_VOTES and evenness(counts) < LEAST_LIKELY
    return ["favours some positions"] if uneven else []


def _speed(count: int, typical: float) -> list[str]:
    return [] if count < LEAST_VOTES or typical >= FASTEST_SECONDS else [f"{typical:.1f} s a question"]


def _usual_agreement(agreeing: Mapping[str, tuple[int, int]]) -> float:
    """The median share of agreement, from which few outliers can't lead away."""
    shares = [agreed / compared for agreed, compared in agreeing.values() if compared]
    return median(shares) if shares else 0.0


def _disagreement(own: tuple[int, int], usual: float) -> list[str]:
    agreed, compared = own
    if compared < LEAST_VOTES or bdtr(agreed, compared, usual) >= LEAST_LIKELY:
        return []
    return [f"agrees in {agreed} of {compared}, others in {100 * usual:.0f} %"]


def _copies(votes: pd.DataFrame) -> dict[str, list[str]]:
    """Workers whose answers to a questionnaire equal another's, all of them."""
    ordered = votes.sort_values(["question", "choice"])
    answers = ordered.groupby(["questionnaire", "worker"], as_index=False)[["question", "choice"]].agg(tuple)
    known = answers[answers["question"].map(len) >= LEAST_VOTES]
    groups = known.groupby(["questionnaire", "question", "choice"])["worker"].agg(list)
    alike = [workers for workers in groups if len(workers) > 1]
    return {worker: [f"same answers as {next(w for w in group if w != worker)}"] for group in alike for worker in group}
