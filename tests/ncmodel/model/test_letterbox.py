"""Fitting pictures into squares: against OpenCV's area averaging, and sparse against dense."""

import cv2
import numpy as np
import pytest

from ncmodel.model.letterbox import Square, overlap

SIZES = [(768, 768, 128), (96, 96, 40), (60, 97, 32), (97, 60, 32), (16, 16, 16), (10, 10, 24), (1, 7, 4), (5, 300, 20)]


@pytest.mark.parametrize(("inputs", "outputs"), [(6, 3), (7, 3), (3, 7), (1, 1), (768, 160)])
def test_overlap_averages(inputs: int, outputs: int) -> None:
    weights = overlap(inputs, outputs)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    np.testing.assert_allclose(weights.sum(axis=0), outputs / inputs)


@pytest.mark.parametrize(("side", "size"), [(96, 32), (96, 40), (100, 33)])
def test_shrinking_is_area_averaging(side: int, size: int) -> None:
    image = np.random.default_rng(0).random((side, side)).astype(np.float32)
    expected = cv2.resize(image, (size, size), interpolation=cv2.INTER_AREA)
    np.testing.assert_allclose(Square(side, side, size).fit(image, 1.0), expected, atol=2e-6)


@pytest.mark.parametrize(("height", "width", "size"), SIZES)
def test_sparse_and_dense_averaging_agree(height: int, width: int, size: int) -> None:
    rng = np.random.default_rng(1)
    square = Square(height, width, size)
    pixels = np.flatnonzero(rng.random(height * width) < 0.3)
    image = np.zeros(height * width, dtype=np.float32)
    image[pixels] = rng.random(len(pixels))
    source, cell, weight = square.spread(pixels)
    sparse = np.bincount(cell, weights=image[pixels][source] * weight, minlength=size * size)
    np.testing.assert_allclose(sparse.reshape(size, size), square.fit(image.reshape(height, width), 0.0), atol=1e-6)


@pytest.mark.parametrize(("height", "width", "size"), SIZES)
def test_pictures_are_centred_on_background(height: int, width: int, size: int) -> None:
    square = Square(height, width, size)
    fitted = square.fit(np.zeros((2, height, width), dtype=np.float32), background=1.0)
    rows, columns = np.nonzero(fitted[0] < 1e-6)
    assert fitted.shape == (2, size, size)
    assert (len(set(rows.tolist())), len(set(columns.tolist()))) == square.inner
    assert max(square.inner) == size
    assert abs(rows.min() - (size - 1 - rows.max())) <= 1
    assert abs(columns.min() - (size - 1 - columns.max())) <= 1


@pytest.mark.parametrize(("height", "width", "size"), SIZES)
def test_points_go_back_to_where_they_came_from(height: int, width: int, size: int) -> None:
    square = Square(height, width, size)
    (rows, columns), (top, left) = square.inner, square.corner
    corners = np.array([[left, top], [left + columns, top + rows]], dtype=np.float64)
    np.testing.assert_allclose(square.to_picture(corners), [[0, 0], [width, height]], atol=1e-9)


def test_the_amount_of_ink_survives() -> None:
    image = np.zeros((768, 768), dtype=np.float32)
    image[300:302, 100:600] = 1.0
    assert Square(768, 768, 96).fit(image, 0.0).mean() == pytest.approx(image.mean(), rel=1e-5)


def test_wrong_sizes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\(3, 4\), expected \(..., 4, 3\)"):
        Square(4, 3, 2).fit(np.zeros((3, 4), dtype=np.float32), 0.0)
    with pytest.raises(ValueError, match="positive"):
        Square(0, 3, 2)
