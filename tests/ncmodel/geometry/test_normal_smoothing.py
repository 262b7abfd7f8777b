"""Diffused normals: against all pairs of vertices, and where they can't change."""

import numpy as np
import pytest

from ncmodel.geometry.adjacency import rings_of
from ncmodel.geometry.normal_smoothing import CUT, median_side
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Mesh
from tests.helpers import analytic


def brute_force(surface: Surface, sigma: float) -> Floats:
    """The weighted mean over all pairs within reach, whether connected or not."""
    p, n, a = surface.mesh.vertices, surface.normals, surface.point_areas
    x = ((p[:, None] - p[None]) ** 2).sum(axis=-1) / sigma**2
    cosine = n @ n.T
    weight = np.where((x < CUT) & (cosine > 0), (1 - x / CUT) ** 2 * cosine * a[None], 0.0)
    np.fill_diagonal(weight, a)
    mean = weight @ n
    return np.asarray(mean / np.linalg.norm(mean, axis=1, keepdims=True))


def connected(surface: Surface, v: int, reach: float) -> list[int]:
    """The vertices connected with v by ones within `reach` of it whose normals are within 90 degrees of its own."""
    p, n, rings = surface.mesh.vertices, surface.normals, surface.rings
    allowed = (((p - p[v]) ** 2).sum(axis=1) < reach**2) & (n @ n[v] > 0)
    found, queue = {v}, [v]
    while queue:
        here = queue.pop()
        around = rings.around[rings.starts[here] : rings.starts[here + 1]].ravel()
        fresh = {int(q) for q in around if allowed[q]} - found
        found |= fresh
        queue += fresh
    return sorted(found)


def test_only_connected_vertices_count() -> None:
    """A sheet rolled up so tightly that each layer is within reach of the next."""
    vertices, faces = analytic.plane(30)
    along, y, _ = 7 * vertices.T
    radius = 1.0 + 0.04 * (along - along.min())
    surface = Surface(Mesh(np.stack([radius * np.sin(2 * along), y, radius * np.cos(2 * along)], axis=1), faces))
    p, n, level = surface.mesh.vertices, surface.normals, 2
    sigma, left_out = level * median_side(p, surface.rings), 0
    for v in range(0, len(p), 7):
        near = connected(surface, v, np.sqrt(CUT) * sigma)
        x = ((p - p[v]) ** 2).sum(axis=1) / sigma**2
        left_out += ((x < CUT) & (n @ n[v] > 0)).sum() - len(near)
        mean = ((1 - x[near] / CUT) ** 2 * (n[near] @ n[v]) * surface.point_areas[near]) @ n[near]
        np.testing.assert_allclose(surface.smoothed_normals[level, v], mean / np.linalg.norm(mean), atol=1e-12)
    assert left_out > 100


@pytest.mark.parametrize("level", [1, 2, 3])
def test_all_pairs(level: int) -> None:
    """On a mesh whose reaches are connected the search finds every pair, at every level."""
    vertices, faces = analytic.torus(40, 20)
    vertices = vertices * (1 + 0.1 * np.sin(15 * vertices[:, :1]))
    surface = Surface(Mesh(vertices, faces))
    sigma = level * median_side(vertices, surface.rings)
    np.testing.assert_allclose(surface.smoothed_normals[level], brute_force(surface, sigma), atol=1e-12)


def test_level_0_is_not_smoothed() -> None:
    surface = Surface(Mesh(*analytic.torus()))
    np.testing.assert_array_equal(surface.smoothed_normals[0], surface.normals)


def test_a_plane_stays() -> None:
    surface = Surface(Mesh(*analytic.plane(12)))
    np.testing.assert_allclose(surface.smoothed_normals, np.tile([0.0, 0, 1], (6, 169, 1)), atol=1e-15)


def test_levels_smooth_more_and_more() -> None:
    """Noise on a sphere's normals shrinks, until what is left is the uneven spacing of its vertices."""
    vertices, faces = analytic.icosphere(4)
    rough = vertices * (1 + np.random.default_rng(0).normal(scale=3e-3, size=(len(vertices), 1)))
    surface = Surface(Mesh(rough, faces))
    error = np.linalg.norm(surface.smoothed_normals - vertices[None], axis=2).mean(axis=1)
    assert (np.diff(error[:4]) < 0).all()
    assert error[3] < error[0] / 10
    assert error[5] < error[0] / 5


def test_parts_apart_dont_mix() -> None:
    """Two sheets a hair apart, facing the same way, are not neighbours."""
    vertices, faces = analytic.plane(10)
    tilted = vertices @ np.array([[1, 0, 0], [0, np.cos(0.5), np.sin(0.5)], [0, -np.sin(0.5), np.cos(0.5)]])
    both = Surface(Mesh(np.concatenate([vertices, tilted + [0, 0, 1e-3]]), np.concatenate([faces, faces + 121])))
    np.testing.assert_allclose(both.smoothed_normals[:, :121], np.tile([0.0, 0, 1], (6, 121, 1)), atol=1e-15)


def test_uneven_meshes_take_bounded_time() -> None:
    """A dense patch inside one reach of the median side: neighbours are cut off, and nothing else happens."""
    fine, fine_faces = analytic.plane(100, 1e-3)
    coarse, coarse_faces = analytic.plane(150, 100.0)
    vertices = np.concatenate([fine, coarse + [0, 0, 1]])
    surface = Surface(Mesh(vertices, np.concatenate([fine_faces, coarse_faces + len(fine)])))
    np.testing.assert_allclose(surface.smoothed_normals[..., 2], 1, atol=1e-12)


def test_rings_list_every_corner_once_in_face_order() -> None:
    vertices, faces = analytic.torus(12, 8)
    rings = rings_of(faces.astype(np.int32), len(vertices))
    seen = []
    for v in range(len(vertices)):
        part = slice(rings.starts[v], rings.starts[v + 1])
        assert (np.diff(rings.face[part]) >= 0).all()
        seen += [(int(f), v, int(j), int(k)) for f, (j, k) in zip(rings.face[part], rings.around[part], strict=True)]
    expected = [(n, int(f[c]), int(f[(c + 1) % 3]), int(f[(c + 2) % 3])) for n, f in enumerate(faces) for c in range(3)]
    assert sorted(seen) == sorted(expected)
