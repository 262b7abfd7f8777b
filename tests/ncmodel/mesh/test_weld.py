"""Points that are one: exactly, within a tolerance, or within each one's own; and meshes welded there."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from ncmodel.mesh.load import load_mesh
from ncmodel.mesh.weld import coincident, rounding, weld
from ncmodel.types import Floats, Ints
from tests.helpers import analytic


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


def test_weld_keeps_first_occurrences_in_order() -> None:
    vertices = np.array([[1.0, 0, 0], [0, 0, 0], [1, 0, 0], [-0.0, 0, 0], [2, 0, 0]])
    welded, faces = weld(vertices, np.array([[0, 1, 4], [2, 3, 4]]))
    np.testing.assert_array_equal(welded, [[1, 0, 0], [0, 0, 0], [2, 0, 0]])
    np.testing.assert_array_equal(faces, [[0, 1, 2], [0, 1, 2]])


def test_loose_triangles_are_welded_in_any_format(tmp_path: Path) -> None:
    vertices, faces = analytic.icosphere(1)
    rows = [f"v {x} {y} {z}" for x, y, z in vertices[faces].reshape(-1, 3).tolist()]
    rows += [f"f {3 * n + 1} {3 * n + 2} {3 * n + 3}" for n in range(len(faces))]
    (tmp_path / "loose.obj").write_text("\n".join(rows), encoding="utf-8")
    mesh = load_mesh(tmp_path / "loose.obj")
    assert len(mesh.vertices) == len(vertices)
    assert mesh.notes == (f"welded {3 * len(faces)} vertices to {len(vertices)} at equal positions",)


def test_rounding_leaves_no_cracks(tmp_path: Path) -> None:
    vertices, faces = analytic.icosphere(2)
    rng = np.random.default_rng(0)
    corners = vertices[faces].astype(np.float32)
    nudged = np.where(rng.random(corners.shape) < 0.1, np.nextafter(corners, np.float32(2.0)), corners)
    trimesh.Trimesh(nudged.reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3), process=False).export(
        tmp_path / "ball.stl"
    )
    assert len(load_mesh(tmp_path / "ball.stl").vertices) == len(vertices)


def test_points_on_grid_lines_are_matched_all_the_same() -> None:
    rng = np.random.default_rng(1)
    # Multiples of the cell size, where rounding to a grid falls either way.
    exact = rng.integers(0, 2**20, (2000, 3)) * 2.0**-20
    exact[:2] = [[0, 0, 0], [1, 1, 1]]
    pair = np.concatenate([exact, np.clip(exact + rng.uniform(-1e-12, 1e-12, exact.shape), 0, 1)])
    number = coincident(pair, rounding(pair))
    np.testing.assert_array_equal(number[:2000], number[2000:])
    assert len(np.unique(number)) > 1990
