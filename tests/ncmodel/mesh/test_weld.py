"""Vertices at equal positions become one."""

from pathlib import Path

import numpy as np
import trimesh

from ncmodel.mesh.load import load_mesh
from ncmodel.mesh.weld import weld, weld_points
from tests.helpers import analytic


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
    number = weld_points(pair)
    np.testing.assert_array_equal(number[:2000], number[2000:])
    assert len(np.unique(number)) > 1990
