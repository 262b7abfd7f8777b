"""Signs that a participant didn't look, beyond failed sentinels: for the audit, and for stricter aggregation.

None of them proves anything, so they exclude nobody unless the requester asks for it.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from statistics import median

from scipy.special import bdtr, bdtrc

from dataset_tools.votes.agreement import agreeing_share
from dataset_tools.votes.votes import Vote
from ncmodel.data.item import DRAWINGS

FASTEST_SECONDS = 1.5
"""Nobody looks at eight drawings in less, as a median."""

LEAST_LIKELY = 1e-4
"""A sign counts where chance gives it less often than this: once in ten thousand honest participants."""

LEAST_VOTES = 8
"""Fewer answers say nothing."""


def flags(votes: Sequence[Vote]) -> dict[str, tuple[str, ...]]:
    """Worker -> signs of not looking; workers without any are left out.

    Args:
        votes: All votes, sentinels too.
    """
    by_worker: dict[str, list[Vote]] = {}
    for vote in votes:
        by_worker.setdefault(vote.worker, []).append(vote)
    agreeing = agreeing_share([vote for vote in votes if not vote.sentinel])
    usual = _usual_agreement(agreeing)
    copies = _copies(by_worker)
    found = {
        worker: (
            *_positions(own),
            *_speed(own),
            *_disagreement(agreeing.get(worker, (0, 0)), usual),
            *copies.get(worker, ()),
        )
        for worker, own in sorted(by_worker.items())
    }
    return {worker: signs for worker, signs in found.items() if signs}


def _positions(votes: Sequence[Vote]) -> list[str]:
    """Always the same answer, or positions in a pattern."""
    from scipy.stats import chisquare

    shown = [vote.position for vote in sorted(votes, key=_order) if vote.position is not None]
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
    uneven = sum(counts) >= LEAST_VOTES and chisquare(counts).pvalue < LEAST_LIKELY
    return ["favours some positions"] if uneven else []


def _order(vote: Vote) -> tuple[str, str, int]:
    return vote.assignment, vote.questionnaire, vote.question


def _speed(votes: Sequence[Vote]) -> list[str]:
    known = [vote.seconds for vote in votes if vote.seconds is not None]
    if len(known) < LEAST_VOTES or median(known) >= FASTEST_SECONDS:
        return []
    return [f"{median(known):.1f} s a question"]


def _usual_agreement(agreeing: Mapping[str, tuple[int, int]]) -> float:
    """The median share of agreement, from which few outliers can't lead away."""
    shares = [agreed / compared for agreed, compared in agreeing.values() if compared]
    return median(shares) if shares else 0.0


def _disagreement(own: tuple[int, int], usual: float) -> list[str]:
    agreed, compared = own
    if compared < LEAST_VOTES or bdtr(agreed, compared, usual) >= LEAST_LIKELY:
        return []
    return [f"agrees in {agreed} of {compared}, others in {100 * usual:.0f} %"]


def _copies(by_worker: Mapping[str, Sequence[Vote]]) -> dict[str, list[str]]:
    """Workers whose answers to a questionnaire equal another's, all of them."""
    seen: dict[tuple[str, tuple[tuple[int, int], ...]], list[str]] = {}
    for worker, votes in by_worker.items():
        questionnaires = {vote.questionnaire for vote in votes}
        for name in questionnaires:
            answers = tuple(sorted((v.question, v.choice) for v in votes if v.questionnaire == name))
            if len(answers) >= LEAST_VOTES:
                seen.setdefault((name, answers), []).append(worker)
    twins = [sorted(set(workers)) for workers in seen.values() if len(set(workers)) > 1]
    return {worker: [f"same answers as {next(w for w in group if w != worker)}"] for group in twins for worker in group}
