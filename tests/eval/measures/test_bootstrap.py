"""Intervals against known values, coverage by simulation, and pairing."""

import numpy as np
import pytest

from eval.measures.bootstrap import pair_accuracy, percentile_interval, resampled_means
from ncmodel.report.intervals import Interval, wilson_interval


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    # Closed form at the ends: 0 successes give [0, z^2 / (n + z^2)].
    [(0, 10, 0.0, 3.8414588 / 13.8414588), (10, 10, 10 / 13.8414588, 1.0), (0, 0, 0.0, 1.0)],
)
def test_wilson_at_the_ends(successes: int, trials: int, low: float, high: float) -> None:
    interval = wilson_interval(successes, trials)
    assert (interval.low, interval.high) == pytest.approx((low, high), abs=1e-6)


def test_wilson_solves_its_equation() -> None:
    interval = wilson_interval(37, 90)
    z = 1.959963984540054
    for end in (interval.low, interval.high):
        assert abs(37 / 90 - end) == pytest.approx(z * np.sqrt(end * (1 - end) / 90))


def test_an_interval_holds_its_ends() -> None:
    assert 0.0 in Interval(0.0, 1.0)
    assert 1.0 in Interval(0.0, 1.0)
    assert 1.1 not in Interval(0.0, 1.0)


def test_resampling_one_cluster_changes_nothing() -> None:
    values = np.array([[1.0, 10.0], [3.0, 30.0]])
    np.testing.assert_allclose(resampled_means(values, ["a", "a"], resamples=5), np.tile([2.0, 20.0], (5, 1)))


def test_resampled_means_are_those_of_whole_clusters() -> None:
    values = np.array([[0.0], [0.0], [0.0], [1.0]])
    means = resampled_means(values, ["big", "big", "big", "small"], seed=3, resamples=1000)[:, 0]
    # Two clusters drawn with replacement: big twice, one of each, small twice.
    assert set(np.round(means, 12)) == {0.0, 0.25, 1.0}
    assert (means == 0.25).mean() == pytest.approx(0.5, abs=0.05)


def test_the_bootstrap_covers_the_true_mean_about_as_often_as_it_says() -> None:
    rng = np.random.default_rng(5)
    covered = 0
    for trial in range(200):
        shapes = np.repeat(np.arange(30), 4)
        values = rng.normal(size=30)[shapes] + 0.3 * rng.normal(size=120)
        covered += 0.0 in percentile_interval(
            resampled_means(values[:, None], list(shapes), seed=trial, resamples=400)[:, 0]
        )
    assert 0.88 <= covered / 200 <= 0.98


def test_lengths_must_agree() -> None:
    with pytest.raises(ValueError, match="2 items for 1 cluster"):
        resampled_means(np.zeros((2, 1)), ["a"])
    with pytest.raises(ValueError, match="at least one"):
        resampled_means(np.zeros((0, 1)), [])
    with pytest.raises(ValueError, match="1 better, 2 worse, 1 shapes"):
        pair_accuracy([1.0], [1.0, 2.0], ["a"])
    with pytest.raises(ValueError, match="at least one"):
        pair_accuracy([], [], [])
    with pytest.raises(ValueError, match="not a number"):
        pair_accuracy([1.0], [float("nan")], ["a"])


def test_pairs_in_the_right_order_are_counted_and_ties_halved() -> None:
    found = pair_accuracy([2.0, 1.0, 0.0, 5.0], [1.0, 1.0, 3.0, -5.0], ["a", "a", "b", "b"])
    assert found.accuracy == (1 + 0.5 + 0 + 1) / 4
    assert (found.pairs, found.shapes) == (4, 2)
    assert found.accuracy in found.wilson
    assert found.accuracy in found.bootstrap


def test_the_same_seed_gives_the_same_interval_and_another_a_different_one() -> None:
    rng = np.random.default_rng(0)
    scores, shapes = rng.normal(size=(2, 60)), [f"shape {n % 12}" for n in range(60)]
    first, again, other = (pair_accuracy(scores[0], scores[1], shapes, seed) for seed in (1, 1, 2))
    assert first == again
    assert first.bootstrap != other.bootstrap


def test_pairs_of_one_shape_that_stand_together_widen_the_interval() -> None:
    shapes = [f"shape {n // 20}" for n in range(200)]
    better = [1.0 if n // 20 < 7 else -1.0 for n in range(200)]
    found = pair_accuracy(better, [0.0] * 200, shapes)
    assert found.accuracy == 0.7
    assert found.bootstrap.high - found.bootstrap.low > 2 * (found.wilson.high - found.wilson.low)
