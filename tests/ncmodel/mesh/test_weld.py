"""Points that are one: exactly, within a tolerance, or within each one's own."""

import numpy as np
import pytest

from ncmodel.mesh.weld import coincident, rounding, weld
from ncmodel.types import Floats, Ints


def first_within_reach(points: Floats, reach: Floats) -> Ints:
    """The definition, by looking at every pair."""
    same = np.arange(len(points))
    for i in range(len(points)):
        if same[i] == i:
            near = np.linalg.norm(points - points[i], axis=1) <= np.minimum(reach, reach[i])
            same[near & (same == np.arange(len(points))) & (np.arange(len(points)) > i)] = i
    return same


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("tolerance", [0.0, 1e-9, 0.01, 0.1, 3.0])
def test_a_point_is_one_with_the_first_that_has_it_within_reach(dimensions: int, tolerance: float) -> None:
    rng = np.random.default_rng(dimensions)
    points = rng.random((300, dimensions))
    points = np.concatenate([points, points[:50], points[50:100] + 1e-3])
    expected = first_within_reach(points, np.full(len(points), tolerance))
    np.testing.assert_array_equal(coincident(points, tolerance), expected)


def test_of_two_tolerances_the_smaller_counts() -> None:
    rng = np.random.default_rng(1)
    points, reach = rng.random((400, 3)), rng.uniform(0, 0.2, 400)
    np.testing.assert_array_equal(coincident(points, reach), first_within_reach(points, reach))


def test_rows_of_near_points_do_not_creep_together() -> None:
    row = np.arange(6)[:, None] * np.array([[0.6, 0.0, 0.0]])
    assert coincident(row, 1.0).tolist() == [0, 0, 2, 2, 4, 4]


def test_only_the_points_named_are_merged() -> None:
    points = np.zeros((5, 3))
    assert coincident(points, among=np.array([1, 3, 4])).tolist() == [0, 1, 2, 1, 1]
    assert coincident(points, 0.1, np.array([1, 3])).tolist() == [0, 1, 2, 1, 4]
    assert coincident(points, among=np.zeros(0, dtype=np.int64)).tolist() == [0, 1, 2, 3, 4]


def test_rounding_never_parts_points_wherever_they_lie() -> None:
    """On a grid, some lie on a side of a cell along one axis and others along another."""
    rng = np.random.default_rng(3)
    points = rng.random((20000, 3))
    moved = points + rng.uniform(-4e-8, 4e-8, points.shape)
    same = coincident(np.concatenate([points, moved]), rounding(points))
    np.testing.assert_array_equal(same[20000:], same[:20000])


def test_the_first_of_a_group_stays() -> None:
    vertices, faces = weld(np.array([[1.0, 0, 0], [0, 0, 0], [1.001, 0, 0], [2, 0, 0]]), np.array([[2, 1, 3]]), 0.01)
    assert vertices[:, 0].tolist() == [1, 0, 2]
    assert faces.tolist() == [[0, 1, 2]]
