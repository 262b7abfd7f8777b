"""Votes weighed by how right each participant seems to be: Dawid and Skene's model with one coin a participant.

A. P. Dawid, A. M. Skene, Maximum likelihood estimation of observer error-rates using the EM algorithm, 1979; here
with one accuracy a participant instead of a confusion matrix, for every item has its own 8 drawings.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dataset_tools.votes.votes import Vote
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.types import Floats

CHOICES = DRAWINGS + 1
"""What an item's truth can be: one of 8 drawings, or none of them."""

PRIOR_RIGHT, PRIOR_WRONG = 4.0, 2.0
"""Imagined right and wrong answers of every participant: few real ones can't make anybody infallible."""


@dataclass(frozen=True, eq=False)
class Belief:
    """The probability of each choice (-1 none, 0..7) being an item's right one."""

    probabilities: Floats

    def choice_above(self, posterior: float) -> int | None:
        """The choice that is at least this probable, if there is one."""
        best = int(np.argmax(self.probabilities))
        return best - 1 if self.probabilities[best] >= posterior else None


def one_coin(votes: Sequence[Vote], iterations: int = 200, tolerance: float = 1e-8) -> dict[Item, Belief]:
    """Expectation maximisation over items' right choices and participants' accuracies.

    A participant is right with probability p, and errs evenly over the item's other choices: 8, or fewer where drawings
    are the same picture. It starts from the shares of votes and ends when no probability moves by more than
    `tolerance`.

    Args:
        votes: Votes on items, in any order.
        iterations: At most.
        tolerance: Largest change that counts as none.
    """
    if not votes:
        return {}
    items = sorted({vote.item for vote in votes})
    workers = sorted({vote.worker for vote in votes})
    rows, names = {item: i for i, item in enumerate(items)}, {worker: i for i, worker in enumerate(workers)}
    ordered = sorted((rows[vote.item], names[vote.worker], vote.drawing + 1) for vote in votes)
    item, worker, choice = np.array(ordered).T
    belief = np.zeros((len(items), CHOICES))
    np.add.at(belief, (item, choice), 1.0)
    belief /= belief.sum(axis=1, keepdims=True)
    exists = np.zeros(belief.shape, dtype=np.bool_)
    for vote in votes:
        exists[rows[vote.item], [0, *(drawing + 1 for drawing in vote.twins)]] = True
    wrong = exists.sum(axis=1)[item] - 1  # choices that a wrong vote spreads over
    answered = np.bincount(worker, minlength=len(workers))
    for _ in range(iterations):
        right = np.bincount(worker, weights=belief[item, choice], minlength=len(workers))
        accuracy = (right + PRIOR_RIGHT) / (answered + PRIOR_RIGHT + PRIOR_WRONG)
        gain = np.log(accuracy)[worker] - np.log((1.0 - accuracy)[worker] / wrong)
        evidence = np.where(exists, 0.0, -np.inf)
        np.add.at(evidence, (item, choice), gain)
        updated = np.exp(evidence - evidence.max(axis=1, keepdims=True))
        updated /= updated.sum(axis=1, keepdims=True)
        moved = float(np.abs(updated - belief).max())
        belief = updated
        if moved < tolerance:
            break
    return {name: Belief(belief[row]) for name, row in rows.items()}
