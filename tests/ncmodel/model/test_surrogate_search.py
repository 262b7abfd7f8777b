"""The surrogate search on functions whose maximum is known, and the surrogate against closed forms."""

import numpy as np
import pytest

from ncmodel.errors import UsageError
from ncmodel.model.surrogate_search import EXPLORING, NEAREST, SURE, Look, Surrogate, optimise_with_surrogate
from ncmodel.model.threshold_search import BUDGETS, LARGE_BUDGETS, budget_named, optimise
from ncmodel.types import Floats
from tests.helpers.known_scores import LARGEST, Knees, Known

LOOKS = LARGE_BUDGETS["balanced"].looks

TOP = np.array([0.8, 0.3, 0.95, 0.45])
"""Shares of ink."""


def shares(t: Floats) -> Floats:
    return np.interp(t, [0.0, 0.5, LARGEST], [1.0, 0.5, 0.0])


def hill(t: Floats) -> float:
    return float(-np.square(shares(t) - TOP).sum())


def two_hills(t: Floats) -> float:
    """A broad low hill where all is drawn; a higher one with little of the second family, nothing of the last."""
    x = shares(t)
    broad, narrow = np.square(x - 1.0).sum(), np.square(x - [0.6, 0.15, 0.5, 0.0]).sum()
    return float(np.exp(-broad) + 1.5 * np.exp(-6 * narrow))


def test_the_surrogate_goes_through_what_it_is_told() -> None:
    """Scores and slopes of a sum of sines, and between them within a few standard deviations."""
    columns, rows = np.meshgrid(np.arange(4), np.arange(3))
    places = (np.stack([columns, rows], axis=2).reshape(-1, 2) + 0.5) / [4, 3]
    between = np.random.default_rng(0).random((200, 2))

    def sines(x: Floats) -> tuple[Floats, Floats]:
        return np.sin(3 * x).sum(axis=1), 3 * np.cos(3 * x)

    scores, slopes = sines(places)
    known = zip(places, scores.tolist(), slopes, strict=True)
    surrogate = Surrogate([Look(place, place, np.eye(2), score, slope) for place, score, slope in known])
    mean, deviation = surrogate(places)
    mean, deviation = mean * surrogate.unit, deviation * surrogate.unit
    np.testing.assert_allclose(mean, scores, atol=0.02)
    assert (deviation < 0.05).all()
    ahead = [(surrogate(places + step)[0] - surrogate(places - step)[0]) / 2e-3 for step in 1e-3 * np.eye(2)]
    np.testing.assert_allclose(np.stack(ahead, axis=1) * surrogate.unit, slopes, atol=0.1)
    mean, deviation = (part * surrogate.unit for part in surrogate(between))
    assert (np.abs(mean - sines(between)[0]) < 3 * deviation).all()
    assert deviation.max() < 0.05
    far = surrogate(np.array([[9.0, 9.0]]))
    assert far[1] * surrogate.unit > 10 * deviation.max()


def test_the_surrogate_knows_drawings_by_what_they_look_like() -> None:
    """Two families that lie on each other: one number tells what is seen of both, and a look at one tells of both."""
    change = np.array([[1.0], [1.0]])
    surrogate = Surrogate(
        [
            Look(np.array([x, 0.0]), np.array([x]), change, -np.square(x - 0.3).sum(), np.full(2, -2 * (x - 0.3)))
            for x in (0.0, 0.5, 1.0)
        ]
    )
    mean, deviation = surrogate(np.array([[0.3], [0.8]]))
    np.testing.assert_allclose(mean * surrogate.unit, [0.0, -0.25], atol=0.01)
    assert (deviation * surrogate.unit < 0.05).all()


def test_slopes_are_those_of_the_drawing_s_change() -> None:
    """Along a way in which the drawing doesn't change, neither does the expected score."""
    look = Look(np.zeros(2), np.zeros(2), np.array([[1.0, 0.0], [0.0, 0.0]]), 1.0, np.array([2.0, 0.0]))
    other = Look(np.ones(2), np.array([0.4, 0.0]), look.change, 1.5, np.array([0.5, 0.0]))
    surrogate = Surrogate([look, other])
    step = np.array([[1e-3, 0.0], [-1e-3, 0.0]])
    up, down = surrogate(step)[0] * surrogate.unit
    assert (up - down) / 2e-3 == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize(("looks", "close"), [(LOOKS, 0.03), (LARGE_BUDGETS["accurate"].looks, 0.01)])
def test_a_maximum_inside_is_found(looks: int, close: float) -> None:
    drawing = Known(hill)
    found = optimise_with_surrogate(drawing, drawing, looks)
    np.testing.assert_allclose(shares(np.array(found.thresholds)), TOP, atol=close)
    assert found.score == hill(np.array(found.thresholds))
    assert found.evaluations == drawing.calls
    assert drawing.calls == looks + 1
    assert found.converged
    assert not found.flat


def test_the_last_looks_go_elsewhere_where_nothing_is_to_be_gained() -> None:
    """Once the hill's top is known: there may be another one."""
    asked = list[Floats]()

    def flat_top(t: Floats) -> float:
        asked.append(shares(t))
        return -max(float(np.square(shares(t) - TOP).sum()) - 0.02, 0.0)

    drawing = Known(flat_top)
    optimise_with_surrogate(drawing, drawing, LOOKS)
    looked_at = np.array(asked[:: 1 + 2 * len(TOP)])[:LOOKS]  # each with two steps along every family for its slope
    away = np.abs(looked_at - TOP).max(axis=1)
    assert away[int(EXPLORING * LOOKS) : int(SURE * LOOKS)].max() < 0.1
    assert away[int(SURE * LOOKS) :].max() > 0.2


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_maximum_in_a_corner_is_found(sign: float) -> None:
    drawing = Known(lambda t: sign * float(shares(t).sum()))
    found = optimise_with_surrogate(drawing, drawing, LOOKS)
    np.testing.assert_allclose(shares(np.array(found.thresholds)), 0.5 + 0.5 * sign, atol=NEAREST)


def test_the_higher_of_two_hills_is_found_at_a_tenth_of_the_evaluations() -> None:
    drawing, climbed = Known(two_hills), Known(two_hills)
    found, thorough = optimise_with_surrogate(drawing, drawing, LOOKS), optimise(climbed, BUDGETS["balanced"])
    assert found.score > thorough.score - 0.02
    assert drawing.calls <= climbed.calls / 5


def test_the_unit_of_scores_does_not_matter() -> None:
    """The ranking loss leaves it open."""
    scaled = [Known(lambda t, f=f: f * two_hills(t) - f) for f in (1.0, 1e-4, 1e4)]  # type: ignore[misc]
    one, *others = (optimise_with_surrogate(drawing, drawing, LOOKS).thresholds for drawing in scaled)
    for other in others:
        np.testing.assert_allclose(shares(np.array(other)), shares(np.array(one)), atol=0.02)


def test_only_exact_scores_count() -> None:
    exact, rough = Known(two_hills), Known(lambda t: two_hills(t) + 100)
    found = optimise_with_surrogate(exact, rough, LOOKS)
    assert found.score == two_hills(np.array(found.thresholds))
    assert exact.calls == 1
    assert rough.calls == LOOKS


def test_families_without_lines_are_left_alone() -> None:
    drawing = Known(hill, present=np.array([True, False, False, True]))
    found = optimise_with_surrogate(drawing, drawing, LOOKS)
    np.testing.assert_allclose(shares(np.array(found.thresholds))[[0, 3]], TOP[[0, 3]], atol=0.02)
    assert found.thresholds[1:3] == (0.0, 0.0)
    assert found.present == (True, False, False, True)


def test_a_view_without_any_filtered_line_is_scored_once() -> None:
    drawing = Known(hill, present=np.zeros(4, dtype=np.bool_))
    found = optimise_with_surrogate(drawing, drawing, LOOKS)
    assert (found.thresholds, found.evaluations, found.trials) == ((0.0, 0.0, 0.0, 0.0), 1, ())


@pytest.mark.parametrize(("gain", "expected"), [(0.5, True), (-0.5, False)])
def test_boundaries_are_drawn_where_they_help(gain: float, expected: bool) -> None:
    drawing = Known(hill, boundary_gain=gain)
    found = optimise_with_surrogate(drawing, drawing, LOOKS)
    assert found.boundaries is expected
    assert found.score == pytest.approx(max(gain, 0.0), abs=0.01)
    assert found.evaluations == drawing.calls
    assert drawing.calls == LOOKS + 4


def test_a_constant_score_says_so_and_gives_the_first_place() -> None:
    drawing = Known(lambda t: 0.25)
    found = optimise_with_surrogate(drawing, drawing, LOOKS)
    assert found.flat
    assert found.thresholds == (Knees().threshold(0.6),) * 4


def test_scores_that_are_not_numbers_lose_to_those_that_are() -> None:
    drawing = Known(lambda t: float("nan") if t[0] > 1.0 else hill(t))
    found = optimise_with_surrogate(drawing, drawing, LOOKS)
    assert found.thresholds[0] <= 1.0
    assert np.isfinite(found.score)
    nothing = Known(lambda t: float("nan"))
    with pytest.raises(UsageError, match="no score that is a number"):
        optimise_with_surrogate(nothing, nothing, LOOKS)


def test_the_search_is_deterministic() -> None:
    first, again = (optimise_with_surrogate(Known(two_hills), Known(two_hills), LOOKS) for _ in range(2))
    assert first == again


def test_large_ranking_modules_have_budgets_of_their_own() -> None:
    assert budget_named("balanced", large=True).looks == LOOKS
    assert budget_named("balanced").looks == 0
    looks = [budget.looks for budget in LARGE_BUDGETS.values()]
    assert looks == sorted(looks)
