"""The measures against brute force, their symmetries, and every empty or extreme case."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from eval.measures.metrics import (
    MEASURES,
    Measures,
    compare_lines,
    f1_score,
    mean_measures,
    measure,
    tolerance_from_page,
)
from ncmodel.chamfer import Lines, chamfer_distance
from ncmodel.errors import UsageError
from ncmodel.types import Mask
from tests.helpers.oracles import drawing_measures

FLOAT32_DISTANCE = 1e-6
"""Relative rounding of a distance transform in float32."""


@st.composite
def two_masks(draw: st.DrawFn) -> tuple[Mask, Mask]:
    shape = draw(array_shapes(min_dims=2, max_dims=2, max_side=12))
    return draw(arrays(np.bool_, shape)), draw(arrays(np.bool_, shape))


tolerances = st.one_of(st.sampled_from([0.0, 1.0, math.sqrt(2), 2.0, math.sqrt(5), 100.0]), st.floats(0.0, 8.0))


@given(two_masks(), tolerances)
def test_measures_equal_brute_force(masks: tuple[Mask, Mask], tolerance: float) -> None:
    a, b = masks
    found = measure(a, b, tolerance)
    if not (a.any() and b.any()):
        assert found.chamfer in (0.0, math.hypot(*a.shape))
        return
    expected = drawing_measures(a, b, tolerance)
    assert (found.precision, found.recall, found.iou) == (expected["precision"], expected["recall"], expected["iou"])
    assert found.chamfer == pytest.approx(expected["chamfer"], rel=FLOAT32_DISTANCE)
    assert found.f1 == f1_score(expected["precision"], expected["recall"])


@given(two_masks(), tolerances)
def test_swapping_the_drawings_swaps_precision_and_recall_only(masks: tuple[Mask, Mask], tolerance: float) -> None:
    a, b = masks
    there, back = measure(a, b, tolerance), measure(b, a, tolerance)
    assert (there.precision, there.recall) == (back.recall, back.precision)
    assert (there.iou, there.f1, there.chamfer) == pytest.approx((back.iou, back.f1, back.chamfer))


@given(two_masks(), tolerances)
def test_turning_both_pictures_changes_nothing(masks: tuple[Mask, Mask], tolerance: float) -> None:
    a, b = masks
    turned = measure(np.rot90(a).copy(), np.rot90(b).copy(), tolerance)
    still = measure(a, b, tolerance)
    assert [getattr(turned, name) for name in MEASURES] == pytest.approx([getattr(still, name) for name in MEASURES])


@given(two_masks())
def test_a_wider_tolerance_never_lowers_a_ratio(masks: tuple[Mask, Mask]) -> None:
    narrow, wide = measure(*masks, 1.0), measure(*masks, 3.0)
    assert narrow.precision <= wide.precision
    assert narrow.recall <= wide.recall
    assert narrow.iou <= wide.iou
    assert narrow.chamfer == wide.chamfer


@given(arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=12)), tolerances)
def test_a_drawing_agrees_with_itself(mask: Mask, tolerance: float) -> None:
    assert measure(mask, mask.copy(), tolerance) == Measures(1.0, 1.0, 1.0, 1.0, 0.0)


EMPTY, DOT = np.zeros((3, 4), bool), np.eye(3, 4, dtype=bool)


def test_two_empty_drawings_agree() -> None:
    assert measure(EMPTY, EMPTY, 1.0) == Measures(1.0, 1.0, 1.0, 1.0, 0.0)


@pytest.mark.parametrize("pair", [(EMPTY, DOT), (DOT, EMPTY)], ids=["nothing drawn", "nothing to draw"])
def test_an_empty_drawing_earns_nothing_against_one_that_is_not(pair: tuple[Mask, Mask]) -> None:
    assert measure(*pair, 100.0) == Measures(0.0, 0.0, 0.0, 0.0, 5.0)


def test_one_pixel_pictures() -> None:
    on, off = np.ones((1, 1), bool), np.zeros((1, 1), bool)
    assert measure(on, on, 0.0) == Measures(1.0, 1.0, 1.0, 1.0, 0.0)
    assert measure(on, off, 0.0) == Measures(0.0, 0.0, 0.0, 0.0, math.sqrt(2))


def test_parallel_lines_are_near_exactly_at_their_distance() -> None:
    a, b = np.zeros((2, 40, 100), bool)
    a[5], b[12] = True, True
    assert measure(a, b, 6.999).f1 == 0.0
    assert measure(a, b, 7.0) == Measures(1.0, 1.0, 1.0, 1.0, 7.0)


def test_nearness_on_the_diagonal_is_exact_far_away_too() -> None:
    a, b = np.zeros((2, 900, 900), bool)
    a[0, 0], b[700, 701] = True, True
    assert measure(a, b, math.hypot(700, 701)).precision == 1.0
    assert measure(a, b, math.hypot(700, 701) - 1e-4).precision == 0.0


def test_zero_tolerance_counts_shared_pixels() -> None:
    a, b = np.zeros((2, 1, 10), bool)
    a[0, :6], b[0, 4:] = True, True
    found = measure(a, b, 0.0)
    assert (found.precision, found.recall, found.iou) == (2 / 6, 2 / 6, 4 / 12)


def test_a_huge_tolerance_makes_everything_near_and_leaves_chamfer_alone() -> None:
    a, b = np.zeros((2, 1, 10), bool)
    a[0, 0], b[0, 9] = True, True
    assert measure(a, b, 1e300) == Measures(1.0, 1.0, 1.0, 1.0, 9.0)


@pytest.mark.parametrize("tolerance", [-1.0, math.nan])
def test_a_tolerance_that_makes_no_sense_is_refused(tolerance: float) -> None:
    with pytest.raises(ValueError, match="expected 0 or more"):
        measure(DOT, DOT, tolerance)


def test_different_sizes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\(3, 4\) and \(4, 3\)"):
        measure(DOT, DOT.T.copy(), 1.0)


def test_inputs_are_left_as_they_were() -> None:
    a, b = DOT.copy(), ~DOT
    measure(a, b, 1.0)
    np.testing.assert_array_equal(a, DOT)
    np.testing.assert_array_equal(b, ~DOT)


def test_f1_of_the_mean_is_not_the_mean_of_f1() -> None:
    one, other = Measures(1.0, 0.2, 1 / 3, 0.5, 4.0), Measures(0.2, 1.0, 1 / 3, 0.7, 8.0)
    mean = mean_measures([one, other])
    assert [getattr(mean, name) for name in MEASURES] == pytest.approx([0.6, 0.6, 0.6, 0.6, 6.0])
    with pytest.raises(ValueError, match="no measures"):
        mean_measures([])


PAPER_ROWS = [
    # (precision, recall, F1) of the first published table, in per cent.
    (83.0, 22.0, 34.8),
    (52.5, 55.7, 54.1),
    (44.5, 63.5, 52.3),
    (43.9, 44.1, 44.0),
    (40.4, 75.1, 52.5),
    (38.6, 70.4, 49.9),
    (50.4, 55.8, 52.9),
    (69.6, 37.5, 48.7),
    (60.8, 60.5, 60.6),
]


@pytest.mark.parametrize(("precision", "recall", "f1"), PAPER_ROWS)
def test_f1_is_that_of_the_published_precision_and_recall(precision: float, recall: float, f1: float) -> None:
    assert f1_score(precision, recall) == pytest.approx(f1, abs=0.1)


def test_f1_of_nothing_is_zero() -> None:
    assert f1_score(0.0, 0.0) == 0.0


def test_chamfer_alone_is_the_same_number() -> None:
    rng = np.random.default_rng(1)
    a, b = rng.random((2, 50, 60)) < 0.02
    assert chamfer_distance(Lines.of(a), Lines.of(b)) == compare_lines(Lines.of(a), Lines.of(b), 2.0).chamfer


def test_a_page_turns_millimetres_into_pixels() -> None:
    assert tolerance_from_page(1.0, 0.25) == 4.0
    assert tolerance_from_page(0.0, 0.25) == 0.0
    for bad in [(-1.0, 0.2), (math.nan, 0.2), (math.inf, 0.2), (1.0, 0.0), (1.0, -0.2), (1.0, math.nan)]:
        with pytest.raises(UsageError, match="expected"):
            tolerance_from_page(*bad)
