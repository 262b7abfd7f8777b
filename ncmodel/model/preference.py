"""From scores to shares of people: how many prefer one drawing to another (Bradley and Terry 1952).

The share of people who prefer drawing A to drawing B is the logistic function of (score of A - score of B)/T. The
temperature T makes scores of a ranking module, whose scale the ranking loss leaves open, agree with votes on shapes
that it wasn't trained on (Guo et al. 2017: On calibration of modern neural networks).
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncmodel.data.pairs import Pair
from ncmodel.report.intervals import Interval, wilson_interval
from ncmodel.types import Floats

UNCALIBRATED = 1.0
"""The temperature of a module of which no votes are known: the ranking loss wants differences of 1."""

BINS = 5
"""Of the reliability diagram: held-out votes are few."""

COLDEST, HOTTEST = 1e-3, 1e3
"""Temperatures, as multiples of the scores' root mean square difference, between which the best one is looked for."""


@dataclass(frozen=True)
class Preference:
    """What differences of scores mean for people.

    Attributes:
        temperature: T, positive.
    """

    temperature: float

    def share(self, difference: Any) -> Any:
        """The share of people who prefer the first of two drawings, from its score minus the other's."""
        from scipy.special import expit

        return expit(np.asarray(difference, dtype=np.float64) / self.temperature)


@dataclass(frozen=True, eq=False)
class Votes:
    """Votes on pairs of drawings, and what a ranking module says of them.

    Attributes:
        difference: (N,) score of the drawing that was preferred minus that of the other.
        wins: (N,) votes for the preferred one.
        losses: (N,) votes for the other one.
    """

    difference: Floats
    wins: Floats
    losses: Floats

    def __post_init__(self) -> None:
        if not len(self.difference) == len(self.wins) == len(self.losses) or not len(self.difference):
            raise ValueError("expected as many differences as votes, and at least one")

    @staticmethod
    def of(pairs: Sequence[Pair], better: Sequence[float], worse: Sequence[float]) -> "Votes":
        """The votes behind ranking pairs.

        A pair doesn't say how many chose its other drawing, but how many didn't choose the preferred one: these are
        shared out evenly among the item's pairs. Where votes are unknown, a pair is one vote.

        Args:
            pairs: All pairs of some items.
            better: Scores of the preferred drawings.
            worse: Scores of the others.
        """
        sharing = Counter(pair.item for pair in pairs)
        counts = [
            (1.0, 0.0)
            if pair.votes is None or pair.votes_for is None
            else (float(pair.votes_for), (pair.votes - pair.votes_for) / sharing[pair.item])
            for pair in pairs
        ]
        wins, losses = np.array(counts, dtype=np.float64).reshape(-1, 2).T
        return Votes(np.asarray(better, np.float64) - np.asarray(worse, np.float64), wins, losses)

    def take(self, keep: NDArray[np.bool_]) -> "Votes":
        """Some of the pairs."""
        return Votes(self.difference[keep], self.wins[keep], self.losses[keep])


@dataclass(frozen=True)
class Bin:
    """Pairs of which about the same was said.

    Attributes:
        predicted: Mean predicted share of votes for the drawing with the higher score, 0.5..1.
        observed: Its share of the votes.
        interval: Of the observed share.
        votes: How many there are.
    """

    predicted: float
    observed: float
    interval: Interval
    votes: float


@dataclass(frozen=True)
class Reliability:
    """How predicted shares agree with votes.

    Attributes:
        bins: The reliability diagram.
        error: Expected calibration error: the mean distance of predicted and observed share, weighted by votes.
    """

    bins: tuple[Bin, ...]
    error: float


def fit_preference(votes: Votes) -> Preference:
    """The temperature under which votes are likeliest.

    Half a vote for either side of a typical pair is added: it keeps the temperature finite where the module is right
    about every vote.
    """
    from scipy.optimize import minimize_scalar

    scale = float(np.sqrt(np.mean(votes.difference**2)))
    if scale == 0.0:
        return Preference(1.0)
    x = np.append(votes.difference / scale, 1.0)
    wins, losses = np.append(votes.wins, 0.5), np.append(votes.losses, 0.5)

    def cost(log_temperature: float) -> float:
        z = x / np.exp(log_temperature)
        return float(wins @ np.logaddexp(0.0, -z) + losses @ np.logaddexp(0.0, z))

    found = minimize_scalar(cost, bounds=(np.log(COLDEST), np.log(HOTTEST)), method="bounded", options={"xatol": 1e-6})
    return Preference(float(scale * np.exp(found.x)))


def reliability(predicted: Floats, wins: Floats, losses: Floats, bins: int = BINS) -> Reliability:
    """The reliability diagram of predicted shares.

    Args:
        predicted: (N,) share of people who prefer the first drawing of each pair.
        wins: (N,) votes for the first.
        losses: (N,) votes for the second.
        bins: Equal parts of 0.5..1 in which pairs are gathered; each pair is seen from the drawing predicted to win.
    """
    turned = predicted < 0.5
    share = np.where(turned, 1.0 - predicted, predicted)
    won, lost = np.where(turned, losses, wins), np.where(turned, wins, losses)
    place = np.minimum((2.0 * (share - 0.5) * bins).astype(np.intp), bins - 1)
    found, error, total = [], 0.0, float((won + lost).sum())
    for number in range(bins):
        own = place == number
        count = float((won + lost)[own].sum())
        if count > 0.0:
            predicted_share = float(share[own] @ (won + lost)[own]) / count
            observed = float(won[own].sum()) / count
            interval = wilson_interval(round(won[own].sum()), max(1, round(count)))
            found.append(Bin(predicted_share, observed, interval, count))
            error += abs(predicted_share - observed) * count / total
    return Reliability(tuple(found), error)


def cross_fitted(votes: Votes, shapes: Sequence[str]) -> Floats:
    """(N,) share of people who prefer the first drawing of each pair, its temperature fitted on the other shapes.

    With one shape alone, on that.
    """
    shape = np.array(shapes)
    predicted = np.empty(len(shape))
    for held_out in dict.fromkeys(shapes):
        own = shape == held_out
        fitted = fit_preference(votes if own.all() else votes.take(~own))
        predicted[own] = fitted.share(votes.difference[own])
    return predicted
