"""Simulated votes in rounds: the medoids first, then other drawings, then the winner against drawings like it."""

from collections.abc import Sequence

import numpy as np

from dataset_tools.simulation.participants import Crowd
from eval.default_model.views import MeasuredView
from ncmodel.data.item import DRAWINGS
from ncmodel.data.pairs import Pair, Split
from ncmodel.drawing.settings import Levels
from ncmodel.types import Floats, Ints

VOTES = 3
"""Of each question, of which two must agree, as in the paper."""

NEAR = 24
"""A drawing's neighbours, among which those are that its last rounds set it against."""


def rounds(view: MeasuredView, count: int, crowd: Crowd, split: Split, rng: np.random.Generator) -> list[Pair]:
    """Ranking pairs from some questions about a view; `better` and `worse` are settings.

    Args:
        view: The view.
        count: Questions: the medoids; then by turns eight drawings at random, and the first winner with seven of its
            neighbours.
        crowd: What participants are like.
        split: Of the view's pairs.
        rng: Source of everything random.
    """
    pairs: list[Pair] = []
    winner: int | None = None
    for number in range(count):
        if number == 0:
            shown = view.shown
        elif number % 2 or winner is None:
            shown = rng.choice(view.distances.shape[1], DRAWINGS, replace=False)
        else:
            shown = np.append(rng.choice(_neighbours(winner), DRAWINGS - 1, replace=False), winner)
        best = _asked(view.distances[:, shown], crowd, rng)
        if best is None:
            continue
        chosen = int(shown[best])
        winner = chosen if winner is None else winner
        pairs += [
            Pair(view.item, chosen, int(other), split, source="simulated") for other in shown if int(other) != chosen
        ]
    return pairs


def _asked(distances: Floats, crowd: Crowd, rng: np.random.Generator) -> int | None:
    """Which of the (A, 8) drawings two of three participants prefer, each following an artist; None if no two agree."""
    artists = rng.integers(len(distances), size=VOTES)
    seen = np.log(np.maximum(distances[artists], 1e-6)) + crowd.noise * rng.gumbel(size=(VOTES, distances.shape[1]))
    votes = np.bincount(seen.argmin(axis=1), minlength=distances.shape[1])
    return int(votes.argmax()) if votes.max() > VOTES / 2 else None


def _neighbours(setting: int) -> Ints:
    """(24,) the settings that differ least from one, by their levels; the first ones among equals."""
    places = _places()
    order = np.argsort(np.abs(places - places[setting]).sum(axis=1), kind="stable")
    return np.asarray(order[1 : NEAR + 1])


def _places() -> Ints:
    """(256, 5) which level of each filter a setting has, and which switches."""
    levels: Sequence[int] = (4, 4, 4, 2, 2)
    grid = np.indices(levels).reshape(len(levels), -1).T
    assert len(grid) == len(Levels().settings)
    return grid
