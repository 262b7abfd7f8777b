"""Thresholding, thinning and taking silhouettes away."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy import ndimage

from eval.measures.thinning import binarise, outline, read_ink, silhouette_band, thin, thin_lines
from ncmodel.errors import UsageError
from ncmodel.images import from_ink, write_png
from ncmodel.types import Mask

masks = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=16))


def test_ink_is_read_from_dark_lines_on_light_paper(tmp_path: Path) -> None:
    ink = np.array([[0.0, 0.2, 1.0]], np.float32)
    write_png(tmp_path / "x.png", from_ink(ink))
    np.testing.assert_allclose(read_ink(tmp_path / "x.png"), ink, atol=1e-6)


def test_half_ink_counts_before_and_after_a_file(tmp_path: Path) -> None:
    ink = np.array([[0.49, 0.5, 0.51]], np.float32)
    write_png(tmp_path / "x.png", from_ink(ink))
    for version in (ink, read_ink(tmp_path / "x.png")):
        np.testing.assert_array_equal(binarise(version), [[False, True, True]])


@pytest.mark.parametrize("threshold", [0.0, -0.1, 1.1, float("nan")])
def test_a_threshold_that_makes_no_sense_is_refused(threshold: float) -> None:
    with pytest.raises(UsageError, match="expected a number above 0"):
        binarise(np.zeros((2, 2), np.float32), threshold)


def parts(mask: Mask) -> int:
    return int(ndimage.label(mask, np.ones((3, 3)))[1])


@given(masks)
def test_thinning_stays_inside_keeps_every_part_and_is_done_once(mask: Mask) -> None:
    thinned = thin(mask)
    assert not (thinned & ~mask).any()
    assert parts(thinned) == parts(mask)
    np.testing.assert_array_equal(thin(thinned), thinned)


@pytest.mark.parametrize("width", [1, 2, 3, 5, 8])
def test_a_thick_line_thins_to_its_middle(width: int) -> None:
    ink = np.zeros((40, 120), np.float32)
    top = 16
    ink[top : top + width, 10:110] = 1.0
    rows, columns = np.nonzero(thin_lines(ink))
    middle = (columns > 10 + width) & (columns < 109 - width)
    assert np.bincount(columns[middle])[10 + width + 1 : 109 - width].tolist() == [1] * (98 - 2 * width)
    assert np.abs(rows[middle] - (top + (width - 1) / 2)).max() <= 0.5


def test_thinning_a_ring_leaves_a_circle_of_its_middle_radius() -> None:
    v, u = np.mgrid[:201, :201] - 100
    radius = np.hypot(u, v)
    thinned = thin(np.abs(radius - 80.0) <= 2.5)
    assert np.abs(radius[thinned] - 80.0).max() < 1.0
    assert ndimage.label(~thinned)[1] == 2


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (7, 1), (2, 2)])
@pytest.mark.parametrize("filled", [True, False])
def test_tiny_pictures_thin(shape: tuple[int, int], filled: bool) -> None:
    assert thin(np.full(shape, filled)).any() == filled


def test_a_filled_mask_and_its_drawn_outline_give_the_same_band() -> None:
    filled = np.zeros((120, 120), np.uint8)
    cv2.circle(filled, (60, 60), 40, 1, -1)
    drawn = np.zeros_like(filled)
    cv2.circle(drawn, (60, 60), 40, 1, 2)
    from_filled, from_drawn, from_paper = (silhouette_band(m, 4.0) for m in (filled > 0, drawn > 0, filled == 0))
    narrower, wider = silhouette_band(filled > 0, 3.0), silhouette_band(filled > 0, 6.0)
    for other in (from_drawn, from_paper):
        assert not (narrower & ~other).any()
        assert not (other & ~wider).any()
    assert not from_filled[60, 60]


def test_a_band_reaches_as_far_as_its_margin() -> None:
    shape = np.zeros((30, 40), bool)
    shape[10:20, 10:30] = True
    band = silhouette_band(shape, 3.0)
    assert band[10 - 3, 20]
    assert not band[10 - 4, 20]
    assert band[10 + 3, 20]
    assert not band[10 + 4, 20]
    np.testing.assert_array_equal(silhouette_band(shape, 0.0), outline(shape))


@given(st.floats(0.0, 10.0))
def test_without_an_outline_there_is_no_band(margin: float) -> None:
    assert not silhouette_band(np.zeros((4, 5), bool), margin).any()
    assert not silhouette_band(np.ones((4, 5), bool), margin).any()


def test_the_frame_is_no_outline() -> None:
    cut_off = np.zeros((10, 10), bool)
    cut_off[:, :5] = True
    np.testing.assert_array_equal(np.argwhere(outline(cut_off))[:, 1], np.full(10, 4))
