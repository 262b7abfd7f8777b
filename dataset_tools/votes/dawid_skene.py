"""Votes weighed by how right each participant seems to be: Dawid and Skene's model with one coin a participant.

A. P. Dawid, A. M. Skene, Maximum likelihood estimation of observer error-rates using the EM algorithm, 1979; here
with one accuracy a participant instead of a confusion matrix, for every item has its own 8 drawings.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from dataset_tools.questionnaires.identical_drawings import from_text
from dataset_tools.votes.votes import ITEM, drawings_of, items_of
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


def one_coin(votes: pd.DataFrame, iterations: int = 200, tolerance: float = 1e-8) -> dict[Item, Belief]:
    """Expectation maximisation over items' right choices and participants' accuracies.

    A participant is right with probability p, and errs evenly over the item's other choices: 8, or fewer where drawings
    are the same picture. It starts from the shares of votes and ends when no probability moves by more than
    `tolerance`.

    Args:
        votes: Votes on items, in any order.
        iterations: At most.
        tolerance: Largest change that counts as none.
    """
    if votes.empty:
        return {}
    answers = pd.DataFrame(
        {
            "item": votes.groupby(ITEM).ngroup(),
            "worker": votes.groupby("worker").ngroup(),
            "choice": drawings_of(votes) + 1,
        }
    )
    item, worker, choice = answers.sort_values(["item", "worker", "choice"]).to_numpy().T
    items, workers = items_of(votes), worker.max() + 1
    belief = np.zeros((len(items), CHOICES))
    np.add.at(belief, (item, choice), 1.0)
    belief /= belief.sum(axis=1, keepdims=True)
    exists = np.zeros(belief.shape, dtype=np.bool_)
    exists[:, 0] = True
    for row, text in set(zip(answers["item"], votes["twins"], strict=True)):
        exists[row, np.array(from_text(text)) + 1] = True
    wrong = exists.sum(axis=1)[item] - 1  # choices that a wrong vote spreads over
    answered = np.bincount(worker, minlength=workers)
    for _ in range(iterations):
        right = np.bincount(worker, weights=belief[item, choice], minlength=workers)
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
    return {name: Belief(belief[row]) for row, name in enumerate(items)}
