"""Scores become shares of people: known temperatures are found again, and what is off is seen."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair
from ncmodel.model.preference import Preference, Votes, cross_fitted, fit_preference, reliability

ITEM = Item("cow", "0")


def test_a_share_is_the_logistic_function_of_the_difference() -> None:
    """Bradley and Terry's closed form: odds of e to the difference over T."""
    assert Preference(2.0).share(2.0 * math.log(3.0)) == pytest.approx(0.75)
    assert Preference(0.5).share(0.0) == 0.5


@given(st.floats(-50.0, 50.0), st.floats(0.01, 100.0))
def test_the_shares_of_two_drawings_are_a_whole(difference: float, temperature: float) -> None:
    preference = Preference(temperature)
    assert preference.share(difference) + preference.share(-difference) == pytest.approx(1.0)


@pytest.mark.parametrize("temperature", [0.05, 1.0, 30.0])
def test_the_temperature_that_votes_were_drawn_with_is_found(temperature: float) -> None:
    difference = np.linspace(0.1, 3.0, 40) * temperature
    share = Preference(temperature).share(difference)
    votes = Votes(difference, 1000.0 * share, 1000.0 * (1.0 - share))
    assert fit_preference(votes).temperature == pytest.approx(temperature, rel=0.01)


def test_a_module_that_is_always_right_stays_short_of_certainty() -> None:
    votes = Votes(np.array([1.0, 2.0]), np.array([3.0, 3.0]), np.zeros(2))
    assert 0.7 < fit_preference(votes).share(1.0) < 0.999


def test_a_module_that_is_mostly_wrong_says_nothing() -> None:
    votes = Votes(np.array([-1.0, -2.0, 0.5]), np.full(3, 4.0), np.ones(3))
    assert fit_preference(votes).share(2.0) == pytest.approx(0.5, abs=0.01)


def test_a_module_that_says_the_same_of_all_drawings_has_some_temperature() -> None:
    assert fit_preference(Votes(np.zeros(2), np.ones(2), np.zeros(2))).share(0.0) == 0.5


def test_votes_for_other_drawings_are_shared_out_among_the_pairs() -> None:
    """Of 10 votes 6 went to the best drawing; the other 4 are those of its two rivals together."""
    pairs = [Pair(ITEM, 0, worse, "validation", votes_for=6, votes=10) for worse in (1, 2)]
    pairs.append(Pair(Item("cow", "1"), 3, 4, "validation"))
    votes = Votes.of(pairs, better=[3.0, 3.0, 1.0], worse=[1.0, 2.0, 4.0])
    assert votes.difference.tolist() == [2.0, 1.0, -3.0]
    assert votes.wins.tolist() == [6.0, 6.0, 1.0]
    assert votes.losses.tolist() == [2.0, 2.0, 0.0]
    with pytest.raises(ValueError, match="at least one"):
        Votes.of([], [], [])


def test_predictions_that_hold_have_no_calibration_error() -> None:
    predicted = np.array([0.55, 0.75, 0.2])
    found = reliability(predicted, 100.0 * predicted, 100.0 * (1.0 - predicted))
    assert found.error == pytest.approx(0.0, abs=1e-12)
    assert [b.predicted for b in found.bins] == pytest.approx([0.55, 0.75, 0.8])
    assert all(b.observed in b.interval for b in found.bins)


def test_the_calibration_error_is_the_mean_distance_weighted_by_votes() -> None:
    """Said 95 %, seen 75 % of 4 votes; said 55 %, seen 55 % of 12: 0.2 * 4 / 16."""
    found = reliability(np.array([0.95, 0.45]), np.array([3.0, 5.4]), np.array([1.0, 6.6]))
    assert found.error == pytest.approx(0.05)
    assert [b.votes for b in found.bins] == pytest.approx([12.0, 4.0])


def test_probabilities_are_judged_on_shapes_that_their_temperature_has_not_seen() -> None:
    """One shape's votes say that scores mean much, the other's that they mean little: each gets the other's."""
    votes = Votes(np.array([1.0, 1.0]), np.array([99.0, 60.0]), np.array([1.0, 40.0]))
    sure, unsure = (fit_preference(votes.take(np.array(keep))).share(1.0) for keep in ([True, False], [False, True]))
    assert cross_fitted(votes, ["cow", "fox"]) == pytest.approx([unsure, sure])
