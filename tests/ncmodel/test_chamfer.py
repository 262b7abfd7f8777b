"""Distances to drawn pixels and Chamfer distances, of pairs and of unions, against brute force."""

from itertools import product

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy.spatial.distance import cdist

from ncmodel.chamfer import Lines, chamfer_distance, chamfer_matrix, chamfer_to_unions, distance_to
from ncmodel.types import Floats, Mask
from tests.helpers.oracles import pixel_distances

TOLERANCE = 1e-4  # pixels


def chamfer(a: Mask, b: Mask) -> float:
    return chamfer_distance(Lines.of(a), Lines.of(b))


def brute_force(a: Mask, b: Mask) -> float:
    pairs = cdist(np.argwhere(a), np.argwhere(b))
    return float(pairs.min(axis=1).mean() + pairs.min(axis=0).mean()) / 2


def random_layers(count: int, shape: tuple[int, int], seed: int = 0) -> Mask:
    """Random strokes: each layer a few straight runs of pixels, overlapping other layers."""
    rng = np.random.default_rng(seed)
    layers = np.zeros((count, *shape), dtype=bool)
    for layer in layers:
        for _ in range(3):
            (r0, r1), (c0, c1) = (np.sort(rng.integers(0, side, 2)) for side in shape)
            n = max(r1 - r0, c1 - c0) + 1
            layer[np.linspace(r0, r1, n).astype(int), np.linspace(c0, c1, n).astype(int)] = True
    return layers


def matrix_by_brute_force(layers: Mask, members: Mask) -> Floats:
    drawings = np.array([layers[m].any(axis=0) for m in members])
    return np.array([[brute_force(a, b) for a in drawings] for b in drawings])


@given(arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=16)))
def test_distances_equal_brute_force(mask: Mask) -> None:
    everywhere = np.ones_like(mask)
    expected = (
        pixel_distances(everywhere, mask).min(axis=1).reshape(mask.shape)
        if mask.any()
        else np.full(mask.shape, np.hypot(*mask.shape))
    )
    np.testing.assert_allclose(distance_to(mask), expected, rtol=1e-6)


def test_last_bits_do_not_depend_on_how_they_were_rounded(monkeypatch: pytest.MonkeyPatch) -> None:
    mask = np.zeros((500, 800), dtype=np.bool_)
    mask[3, 5] = True
    expected = distance_to(mask)
    rows, columns = np.indices(mask.shape)
    np.testing.assert_array_equal(expected, np.sqrt(((rows - 3) ** 2 + (columns - 5) ** 2).astype(np.float32)))
    transform = cv2.distanceTransform
    for toward in (np.float32(0), np.float32(np.inf)):
        monkeypatch.setattr(cv2, "distanceTransform", lambda *a, t=toward: np.nextafter(transform(*a), t))
        np.testing.assert_array_equal(distance_to(mask), expected)


def test_two_points_are_as_far_apart_as_they_are() -> None:
    a, b = np.zeros((2, 20, 30), dtype=bool)
    a[3, 4], b[6, 8] = True, True
    assert chamfer(a, b) == pytest.approx(5.0)


def test_the_two_directions_are_averaged() -> None:
    a, b = np.zeros((2, 5, 40), dtype=bool)
    a[2, 0] = True
    b[2, [0, 30]] = True
    assert chamfer(a, b) == pytest.approx((0.0 + 15.0) / 2)


@pytest.mark.parametrize("shape", [(64, 64), (50, 91), (1, 40)])
def test_a_pair_agrees_with_brute_force(shape: tuple[int, int]) -> None:
    a, b = random_layers(2, shape, seed=3)
    assert chamfer(a, b) == pytest.approx(brute_force(a, b), abs=TOLERANCE)


@pytest.mark.parametrize("seed", range(4))
def test_the_matrix_agrees_with_brute_force(seed: int) -> None:
    layers = random_layers(6, (60, 75), seed)
    rng = np.random.default_rng(seed)
    members = rng.random((25, 6)) < 0.5
    members[:, 0] = True
    assert chamfer_matrix(layers, members) == pytest.approx(matrix_by_brute_force(layers, members), abs=TOLERANCE)


def test_distances_across_a_whole_picture_are_exact() -> None:
    layers = np.zeros((2, 768, 768), dtype=bool)
    layers[0, 0, 0] = layers[1, 767, 700] = True
    expected = np.hypot(767, 700)
    assert chamfer_matrix(layers, np.eye(2, dtype=bool))[0, 1] == pytest.approx(expected, abs=TOLERANCE)


def test_empty_drawings_are_a_diagonal_away_from_all_others() -> None:
    layers = np.zeros((2, 30, 40), dtype=bool)
    layers[0, 10, 10:20] = True
    # Empty because its layer is, because it has no layer, and not empty.
    members = np.array([[False, True], [False, False], [True, False], [True, True]])
    expected = 50.0 * np.array([[0, 0, 1, 1], [0, 0, 1, 1], [1, 1, 0, 0], [1, 1, 0, 0]])
    assert chamfer_matrix(layers, members) == pytest.approx(expected)
    assert chamfer(layers[1], layers[1]) == 0.0
    assert chamfer(layers[0], layers[1]) == chamfer(layers[1], layers[0]) == pytest.approx(50.0)


def test_nothing_drawn_at_all() -> None:
    layers = np.zeros((3, 8, 8), dtype=bool)
    assert not chamfer_matrix(layers, np.ones((4, 3), dtype=bool)).any()


def test_the_matrix_is_symmetric_and_zero_exactly_for_identical_drawings() -> None:
    layers = random_layers(3, (40, 40), seed=9)
    layers[2] = layers[0]
    members = np.array([[1, 0, 0], [0, 0, 1], [1, 0, 1], [0, 1, 0]], dtype=bool)
    distances = chamfer_matrix(layers, members)
    assert (distances == distances.T).all()
    assert (distances == 0.0).tolist() == [
        [True, True, True, False],
        [True, True, True, False],
        [True, True, True, False],
        [False, False, False, True],
    ]


def test_more_layers_than_fit_are_refused() -> None:
    with pytest.raises(ValueError, match="63 layers"):
        chamfer_matrix(np.zeros((63, 4, 4), dtype=bool), np.ones((2, 63), dtype=bool))


@st.composite
def two_masks(draw: st.DrawFn) -> Mask:
    height, width = draw(array_shapes(min_dims=2, max_dims=2, max_side=12))
    return draw(arrays(np.bool_, (2, height, width)))


@given(two_masks())
def test_the_matrix_holds_the_distance_of_a_pair(masks: Mask) -> None:
    matrix = chamfer_matrix(masks, np.eye(2, dtype=bool))
    assert matrix[0, 1] == pytest.approx(chamfer(*masks), abs=TOLERANCE)


def test_different_sizes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\(3, 4\) and \(4, 3\)"):
        chamfer(np.eye(3, 4, dtype=bool), np.eye(4, 3, dtype=bool))


def test_the_distance_to_an_empty_drawing_is_the_diagonal() -> None:
    assert distance_to(np.zeros((3, 4), dtype=bool)).tolist() == [[5.0] * 4] * 3


def random_lines(rng: np.random.Generator, share: float) -> Lines:
    return Lines.of(rng.random((18, 23)) < share)


@pytest.mark.parametrize("shares", [(0.01, 0.03, 0.03), (0.0, 0.03, 0.03), (0.02, 0.0, 0.03), (0.0, 0.0, 0.0)])
def test_distances_to_unions_equal_those_to_the_drawn_unions(shares: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(3)
    always, reference = random_lines(rng, shares[0]), random_lines(rng, shares[1])
    empty = random_lines(rng, 0.0)
    layers = [[*(random_lines(rng, shares[2]) for _ in range(count)), empty] for count in (2, 3, 1)]
    costs = chamfer_to_unions(always, layers, reference)
    assert costs.shape == (3, 4, 2)
    for index in product(*(range(len(group)) for group in layers)):
        union = np.logical_or.reduce([always.mask, *(layers[axis][place].mask for axis, place in enumerate(index))])
        assert costs[index] == pytest.approx(chamfer_distance(Lines.of(union), reference), rel=1e-5)
