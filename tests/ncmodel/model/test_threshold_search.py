"""The threshold search on functions whose maximum is known, and where there is none."""

from dataclasses import replace

import numpy as np
import pytest

from ncmodel.errors import UsageError
from ncmodel.model.threshold_search import BUDGETS, Budget, budget_named, optimise
from ncmodel.types import Floats
from tests.helpers.known_scores import Knees, Known

INSIDE = np.array([0.3, 1.1, 0.05, 2.0])


def hill(t: Floats) -> float:
    return float(-np.square(t - INSIDE).sum())


def two_hills(t: Floats) -> float:
    """A broad low hill at the origin and a narrower, higher one where the second family has faded."""
    return float(np.exp(-np.square(t).sum()) + 1.5 * np.exp(-3 * np.square(t - [0.0, 3.5, 0.0, 0.0]).sum()))


@pytest.mark.parametrize("preset", BUDGETS)
def test_a_maximum_inside_is_found(preset: str) -> None:
    found = optimise(Known(hill), BUDGETS[preset])
    close = {"draft": 0.7, "balanced": 1e-3, "accurate": 1e-5}[preset]
    np.testing.assert_allclose(found.thresholds, INSIDE, atol=close)
    assert not found.flat
    assert found.converged or preset == "draft"


def test_a_maximum_at_the_bound_is_found() -> None:
    found = optimise(Known(lambda t: -float(t.sum())), BUDGETS["balanced"])
    assert found.thresholds == (0.0, 0.0, 0.0, 0.0)
    assert optimise(Known(lambda t: float(t.sum())), BUDGETS["balanced"]).thresholds == (4.0, 4.0, 4.0, 4.0)


def test_the_higher_of_two_hills_is_climbed() -> None:
    found = optimise(Known(two_hills), BUDGETS["balanced"])
    assert found.thresholds[1] == pytest.approx(3.5, abs=0.05)
    assert found.score == pytest.approx(1.5, abs=0.01)
    assert len(found.trials) == BUDGETS["balanced"].climbs


def test_a_point_of_the_grid_is_kept_where_climbing_gains_nothing() -> None:
    """A spike at one grid point, whose slope leads nowhere."""
    for budget in (BUDGETS["balanced"], BUDGETS["accurate"]):
        low, high = (Knees().threshold(share) for share in (budget.shares[1], 0.0))
        spike = [low, high, low, high]
        found = optimise(Known(lambda t, spike=spike: float(t.tolist() == spike)), budget)  # type: ignore[misc]
        assert (list(found.thresholds), found.score) == (spike, 1.0)


def test_rough_scores_only_say_where_to_climb() -> None:
    exact, rough = (optimise(Known(two_hills, rough_error=error), BUDGETS["balanced"]) for error in (0.0, 100.0))
    assert rough == exact
    assert rough.score < 2
    bare = Known(hill, present=np.zeros(4, dtype=np.bool_), rough_error=100.0)
    assert optimise(bare, BUDGETS["draft"]).score == hill(np.zeros(4))


def test_every_evaluation_is_counted() -> None:
    drawing = Known(hill, boundary_gain=-1.0)
    assert optimise(drawing, BUDGETS["balanced"]).evaluations == drawing.calls


def test_more_budget_never_scores_lower() -> None:
    rng = np.random.default_rng(0)
    for _ in range(5):
        centres, heights = rng.uniform(0, 4, (6, 4)), rng.uniform(0.5, 1.5, 6)

        def hills(t: Floats, centres: Floats = centres, heights: Floats = heights) -> float:
            return float((heights * np.exp(-np.square(t - centres).sum(axis=1))).sum())

        draft, balanced, accurate = (optimise(Known(hills), BUDGETS[name]).score for name in BUDGETS)
        assert draft <= balanced + 1e-6
        assert balanced <= accurate + 1e-2


def test_families_without_lines_are_left_alone() -> None:
    present = np.array([True, False, False, True])
    drawing = Known(hill, present=present)
    found = optimise(drawing, BUDGETS["balanced"])
    np.testing.assert_allclose(found.thresholds, [0.3, 0.0, 0.0, 2.0], atol=1e-3)
    assert found.present == (True, False, False, True)
    grid = len(BUDGETS["balanced"].shares) ** 2
    assert drawing.calls < grid + 3 * 2 * BUDGETS["balanced"].iterations + 10


@pytest.mark.parametrize("preset", BUDGETS)
def test_a_view_without_any_filtered_line_is_scored_once(preset: str) -> None:
    found = optimise(Known(hill, present=np.zeros(4, dtype=np.bool_)), BUDGETS[preset])
    assert (found.thresholds, found.evaluations, found.trials) == ((0.0, 0.0, 0.0, 0.0), 1, ())


def test_a_constant_score_says_so_and_gives_the_middle_of_the_grid() -> None:
    found = optimise(Known(lambda t: 0.25), BUDGETS["balanced"])
    assert found.flat
    assert found.score == 0.25
    middle = Knees().threshold(BUDGETS["balanced"].shares[0])
    assert found.thresholds == (middle,) * 4


def test_scores_that_are_not_numbers_lose_to_those_that_are() -> None:
    found = optimise(Known(lambda t: float("nan") if t[0] > 1.0 else hill(t)), BUDGETS["balanced"])
    assert found.thresholds[0] <= 1.0
    assert np.isfinite(found.score)


def test_only_scores_that_are_not_numbers_is_an_error() -> None:
    with pytest.raises(UsageError, match="no score that is a number"):
        optimise(Known(lambda t: float("nan")), BUDGETS["balanced"])


@pytest.mark.parametrize(("gain", "expected"), [(0.5, True), (-0.5, False)])
def test_boundaries_are_drawn_where_they_help(gain: float, expected: bool) -> None:
    found = optimise(Known(hill, boundary_gain=gain), BUDGETS["balanced"])
    assert found.boundaries is expected
    assert found.score == pytest.approx(max(gain, 0.0), abs=1e-4)


def test_views_without_boundaries_draw_none() -> None:
    assert optimise(Known(hill), BUDGETS["balanced"]).boundaries is False


def test_the_search_is_deterministic() -> None:
    first, again = (optimise(Known(two_hills, boundary_gain=0.1), BUDGETS["accurate"]) for _ in range(2))
    assert first == again


def test_a_budget_of_ones_own() -> None:
    one_point = Budget((0.5,), full_grid=True, climbs=0, iterations=0)
    found = optimise(Known(hill), one_point)
    assert (found.evaluations, found.thresholds) == (1, (0.5,) * 4)


@pytest.mark.parametrize("wrong", [{"shares": ()}, {"shares": (2.0,)}, {"climbs": -1}, {"climbs": 0}])
def test_budgets_that_make_no_sense_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="expected"):
        replace(BUDGETS["draft"], **wrong)  # type: ignore[arg-type]


def test_unknown_budgets_are_named() -> None:
    with pytest.raises(UsageError, match="'fast', expected one of instant, draft, balanced, accurate"):
        budget_named("fast")
