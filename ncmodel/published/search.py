"""The published schedule of the search for thresholds: ten random starts, 50 x 20 steps of L-BFGS each."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import torch

from ncmodel.errors import UsageError
from ncmodel.model.threshold_search import Optimum, Trial
from ncmodel.published.scoring import MOST
from ncmodel.types import Floats, Mask


class Slope(Protocol):
    """A score with its gradient."""

    @property
    def present(self) -> Mask:
        """(4,) which families have lines."""

    def slope(self, thresholds: Floats) -> tuple[float, Floats]:
        """The score at one (4,) t, and its (4,) gradient."""


@dataclass(frozen=True)
class Schedule:
    """The published one.

    Attributes:
        starts: Random t that are climbed from, uniform in [0, 1]^4.
        steps: Most steps of the optimiser from each.
        inner: Most iterations of L-BFGS a step.
        patience: Steps without a better score, all in all, after which a start is given up.
        rate: The optimiser's learning rate.
        seed: Of the starts.
    """

    starts: int = 10
    steps: int = 50
    inner: int = 20
    patience: int = 5
    rate: float = 0.01
    seed: int = 2048


def published_search(drawing: Slope, schedule: Schedule | None = None) -> Optimum:
    """The best t that any evaluation of the schedule came by.

    Raises:
        UsageError: No score is a number.
    """
    schedule = schedule or Schedule()
    # numpy's legacy generator: the published starts are its.
    starts = np.random.RandomState(schedule.seed).uniform(size=(schedule.starts, 4))
    trials = tuple(_climb(drawing, schedule, start) for start in starts)
    best = max(trials, key=lambda trial: trial.score)
    if not np.isfinite(best.score):
        raise UsageError("the ranking module gives no score that is a number: its weights don't fit these drawings")
    scores = [trial.score for trial in trials]
    return Optimum(
        thresholds=best.thresholds,
        present=tuple(bool(p) for p in drawing.present),
        boundaries=False,
        score=best.score,
        evaluations=sum(trial.evaluations for trial in trials),
        converged=best.converged,
        flat=max(scores) == min(scores),
        trials=trials,
    )


def _climb(drawing: Slope, schedule: Schedule, start: Floats) -> Trial:
    """From one start; the best of all evaluations counts."""
    t = torch.tensor(start.tolist())
    optimiser = torch.optim.LBFGS([t], lr=schedule.rate, max_iter=schedule.inner)
    best, reached, evaluations, fruitless = -np.inf, tuple(start.tolist()), 0, 0

    def evaluate() -> torch.Tensor:
        nonlocal best, reached, evaluations
        score, slope = drawing.slope(t.double().numpy())
        t.grad = -torch.from_numpy(slope).to(t.dtype)
        evaluations += 1
        if score > best:
            best, reached = score, tuple(t.clamp(0.0, MOST).tolist())
        return torch.tensor(-score)

    for _ in range(schedule.steps):
        before = best
        optimiser.step(evaluate)  # type: ignore[no-untyped-call]
        fruitless += best <= before
        if fruitless >= schedule.patience:
            break
    return Trial(tuple(start.tolist()), reached, best, evaluations, fruitless >= schedule.patience)
