"""The published schedule, held against what is known of it on scores that are plain functions."""

import numpy as np
import pytest

from ncmodel.errors import UsageError
from ncmodel.published.search import Schedule, published_search
from ncmodel.types import Floats, Mask

pytestmark = pytest.mark.usefixtures("one_thread")


class Bowl:
    """A score whose best t is known; remembers where it was asked."""

    def __init__(self, best: tuple[float, ...], height: float = 1.0) -> None:
        self.best, self.height = np.array(best), height
        self.asked: list[Floats] = []

    @property
    def present(self) -> Mask:
        return np.ones(4, dtype=np.bool_)

    def slope(self, thresholds: Floats) -> tuple[float, Floats]:
        self.asked.append(thresholds.copy())
        apart = thresholds - self.best
        return self.height * (1.0 - float(apart @ apart)), -2.0 * self.height * apart


def test_the_starts_are_the_published_ones_and_the_best_evaluation_wins() -> None:
    bowl = Bowl((0.5, 0.25, 0.75, 0.1))
    found = published_search(bowl, Schedule(steps=1, inner=4, rate=1.0))
    assert found.thresholds == pytest.approx(bowl.best, abs=0.01)
    assert [trial.start for trial in found.trials] == [tuple(t) for t in np.random.RandomState(2048).rand(10, 4)]
    assert found.evaluations == len(bowl.asked)
    scores = [1.0 - float(((asked - bowl.best) ** 2).sum()) for asked in bowl.asked]
    assert found.score == pytest.approx(max(scores), abs=1e-6)
    assert not found.boundaries


def test_the_schedule_is_the_published_one() -> None:
    assert Schedule() == Schedule(starts=10, steps=50, inner=20, patience=5, rate=0.01, seed=2048)


def test_a_start_is_given_up_after_five_steps_without_a_gain() -> None:
    flat = Bowl((0.0, 0.0, 0.0, 0.0), height=0.0)
    found = published_search(flat, Schedule(starts=2))
    # The first step gains, from nothing; each of the five after it asks once, as there is no slope.
    assert [trial.evaluations for trial in found.trials] == [6, 6]
    assert all(trial.converged for trial in found.trials)
    assert found.flat


def test_steps_and_inner_iterations_are_bounded() -> None:
    far = Bowl((4.0, 4.0, 4.0, 4.0))
    found = published_search(far, Schedule(starts=1, steps=3, inner=2))
    assert 3 <= found.evaluations <= 3 * 3
    assert not found.converged


def test_a_score_that_is_no_number_is_told() -> None:
    with pytest.raises(UsageError, match="no score that is a number"):
        published_search(Bowl((0.0, 0.0, 0.0, 0.0), height=float("nan")), Schedule(starts=1, steps=1))
