"""Thresholds on lines, against the formulas written out segment by segment."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ncmodel.drawing.arguments import plan_of
from ncmodel.drawing.thresholding import fade, survivors
from ncmodel.errors import ArgumentError
from ncmodel.types import FILTERED_FAMILIES, Floats, LineFamily, LineSet, Threshold, Thresholds, Unit

INVERSE = (LineFamily.RIDGES, LineFamily.VALLEYS, LineFamily.APPARENT)


def lines(family: LineFamily, feature: Floats, denominator: Floats | None = None, scale: float = 0.01) -> LineSet:
    """Segments one beside the other along x, each from y = 0 to y = 1."""
    index = np.arange(len(feature), dtype=np.float64)
    zeros, ones = np.zeros_like(index), np.ones_like(index)
    points = np.stack([np.stack([index, zeros, zeros], 1), np.stack([index, ones, zeros], 1)], axis=1)
    bottom = np.ones_like(feature) if denominator is None else denominator
    return LineSet(family, points, np.arange(len(feature)), feature, bottom, scale)


@pytest.mark.parametrize("family", INVERSE)
def test_inverse_fade_drops_segments_below_at_both_ends(family: LineFamily) -> None:
    threshold, scale = 0.1, 0.01  # vanishes at 10
    feature = np.array([[5.0, 9.9], [5.0, 20.0], [40.0, 20.0], [10.0, 10.0]])
    faded = fade(lines(family, feature, scale=scale), Threshold(threshold))
    assert faded.face.tolist() == [1, 2]
    np.testing.assert_allclose(faded.alpha, [[0.0, 0.5], [0.75, 0.5]])
    np.testing.assert_allclose(faded.points[:, :, 1], [[0, 1], [0, 1]])


def test_suggestive_contours_are_cut_where_they_fall_below() -> None:
    scale, t = 1e-4, 0.01
    # Strength x = scale * num / den: 0.02 -> 0, below all along, and above all along.
    num, den = np.array([[100.0, 0.0], [40.0, 40.0], [300.0, 100.0]]), np.array([[0.5, 0.5], [0.5, 0.5], [0.3, 0.1]])
    faded = fade(lines(LineFamily.SUGGESTIVE, num, den, scale), Threshold(t))
    assert faded.face.tolist() == [0, 2]
    np.testing.assert_allclose(faded.points[0, :, 1], [0.0, 0.5])
    np.testing.assert_allclose(faded.alpha, [[0.01 / 0.04, 0.0], [0.09 / 0.12, 0.09 / 0.12]], atol=1e-12)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(*[st.floats(0, 1e3)] * 2, *[st.floats(1e-3, 1)] * 2, st.sampled_from([-1, 1])), min_size=1),
    st.floats(0, 0.5),
)
def test_suggestive_cut_agrees_with_the_test_at_every_point(
    values: list[tuple[float, float, float, float, int]], t: float
) -> None:
    table = np.array(values)
    given_lines = lines(LineFamily.SUGGESTIVE, table[:, :2] * table[:, 4:], table[:, 2:4] * table[:, 4:], 1e-3)
    faded = fade(given_lines, Threshold(t))
    assert np.isfinite(faded.alpha).all()
    assert ((faded.alpha >= 0) & (faded.alpha <= 1)).all()
    for at in np.linspace(0.05, 0.95, 7):
        num = given_lines.feature @ [1 - at, at]
        strength = given_lines.scale * num / (given_lines.denominator @ [1 - at, at])
        low, high = faded.points[:, 0, 1] - 1e-9, faded.points[:, 1, 1] + 1e-9
        kept = np.isin(np.arange(len(values)), faded.face[(low <= at) & (at <= high)])
        clear = np.abs(strength - t) > 1e-9
        np.testing.assert_array_equal(kept[clear], (strength >= t)[clear])


@pytest.mark.parametrize("family", FILTERED_FAMILIES)
def test_percentile_units_follow_the_equations(family: LineFamily) -> None:
    rng = np.random.default_rng(0)
    feature, t, p90 = rng.uniform(-5, 50, (200, 2)), 0.4, 20.0
    faded = fade(lines(family, feature, scale=3.0), Threshold(t, "p90", p90))
    along = faded.points[:, :, 1]
    value = feature[faded.face, :1] + along * (feature[faded.face, 1:] - feature[faded.face, :1])
    np.testing.assert_allclose(faded.alpha, np.maximum(1 - t * p90 / np.maximum(value, 1e-9), 0), atol=1e-9)
    assert set(faded.face) == set(np.flatnonzero((feature > t * p90).any(axis=1)))


@pytest.mark.parametrize("family", FILTERED_FAMILIES)
@pytest.mark.parametrize("unit", ["rtsc", "p90"])
def test_threshold_zero_keeps_all_and_infinity_nothing(family: LineFamily, unit: Unit) -> None:
    feature = np.array([[3.0, 1e-6], [2.0, 5.0]])
    everything = fade(lines(family, feature), Threshold(0.0, unit))
    assert len(everything) == 2
    assert (everything.alpha > 0).all()
    for huge in (1e300, np.inf):
        assert len(fade(lines(family, feature), Threshold(huge, unit))) == 0


@pytest.mark.parametrize("family", [LineFamily.CONTOURS, LineFamily.BOUNDARIES, LineFamily.CREASES])
def test_other_families_have_no_threshold(family: LineFamily) -> None:
    faded = fade(lines(family, np.ones((3, 2))), Threshold(123.0))
    assert (faded.alpha == 1).all()
    assert len(faded) == 3


@pytest.mark.parametrize("family", LineFamily)
def test_no_lines(family: LineFamily) -> None:
    assert len(fade(lines(family, np.ones((0, 2))), Threshold(0.1))) == 0
    assert survivors(lines(family, np.ones((0, 2))), Threshold(0.1)).shape == (0,)


@pytest.mark.parametrize("family", FILTERED_FAMILIES)
@pytest.mark.parametrize("value", [-0.1, float("nan"), -float("inf")])
def test_impossible_thresholds_are_refused(family: LineFamily, value: float) -> None:
    with pytest.raises(ArgumentError, match=f"thresholds: found {family}={value}, expected a number >= 0"):
        plan_of(thresholds=Thresholds().with_values(**{family.value: value}))


def test_possible_thresholds() -> None:
    possible = Thresholds(None, 0.0, 1e300, float("inf"))
    assert plan_of(thresholds=possible).thresholds == possible


@pytest.mark.parametrize("family", FILTERED_FAMILIES)
@pytest.mark.parametrize("threshold", [1e308, float("inf")])
def test_a_huge_threshold_leaves_nothing(family: LineFamily, threshold: float) -> None:
    """Also where it overflows in the lines' own units and their denominators are 0."""
    strong = lines(family, np.full((3, 2), 1e30), np.array([[0.0, 1.0], [0.0, 0.0], [-1.0, 0.0]]), 1e-4)
    assert not survivors(strong, Threshold(threshold)).any()
    assert len(fade(strong, Threshold(threshold)).points) == 0
