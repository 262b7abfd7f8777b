"""Rays and view buffers against closed forms and a brute-force tracer."""

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.geometry.raycast import RayScene
from ncmodel.types import Mesh
from tests.helpers import analytic
from tests.helpers.oracles import traced


@pytest.fixture(scope="module")
def torus() -> Mesh:
    return Mesh(*analytic.torus(32, 16))


def test_first_hits_agree_with_brute_force(torus: Mesh) -> None:
    rng = np.random.default_rng(0)
    origins, targets = rng.normal(size=(300, 3)), 0.4 * rng.normal(size=(300, 3))
    distance, face = RayScene(torus).first_hit(origins, 3.0 * (targets - origins))
    for i in range(300):
        direction = (targets[i] - origins[i]) / np.linalg.norm(targets[i] - origins[i])
        expected, nearest = traced(torus.vertices, torus.faces, origins[i], direction)
        assert distance[i] == pytest.approx(expected, abs=2e-6)
        assert (face[i] < 0) == (nearest < 0)
    assert 50 < (face >= 0).sum() < 290


def test_hits_lie_on_their_faces(torus: Mesh) -> None:
    rng = np.random.default_rng(1)
    hits = RayScene(torus).hits(np.array([0.0, 0.0, 2.0]), rng.normal([0, 0, -2], 0.2, (500, 3)))
    met = hits.face >= 0
    assert met.any()
    np.testing.assert_allclose(hits.barycentric[met].sum(axis=1), 1.0)
    assert (hits.barycentric >= 0).all()
    corners = torus.vertices[torus.faces[hits.face[met]]]
    np.testing.assert_allclose(np.einsum("ij,ijk->ik", hits.barycentric[met], corners), hits.point[met])
    assert (hits.barycentric[~met] == 0).all()
    assert np.isinf(hits.distance[~met]).all()


@pytest.mark.parametrize("distance", [3.0, 1e4, 1e7])
def test_far_eyes_lose_no_precision(torus: Mesh, distance: float) -> None:
    scene, rng = RayScene(torus), np.random.default_rng(2)
    eye, targets = np.array([0.0, 0.3 * distance, distance]), 0.2 * rng.normal(size=(200, 3))
    found, face = scene.first_hit(eye, targets - eye)
    near = eye / np.linalg.norm(eye) * 2.0
    # The same rays, started closer to the object.
    directions = (targets - eye) / np.linalg.norm(targets - eye, axis=1, keepdims=True)
    starts = targets - directions * np.linalg.norm(near)
    closer, same = scene.first_hit(starts, directions)
    assert (face == same).mean() > 0.99
    met = (face >= 0) & (face == same)
    travelled = np.linalg.norm(starts - eye, axis=1)
    np.testing.assert_allclose((found - travelled)[met], closer[met], atol=3e-6 + 1e-15 * distance)


def test_sphere_depth_is_linear_along_the_axis() -> None:
    vertices, faces = analytic.icosphere(5, 0.5)
    camera = Camera((0.0, 0.0, 3.0), width=65, height=65, focal_pixels=150.0)
    buffers = RayScene(Mesh(vertices, faces)).render(camera)
    # Near and far planes touch the sphere at z = 0.5 and -0.5.
    assert buffers.depth[32, 32] == pytest.approx(0.0, abs=1e-3)
    assert (buffers.depth[~buffers.hit] == 1.0).all()
    assert buffers.depth[buffers.hit].max() <= 0.5
    z = np.einsum("hwc,hwc->hw", buffers.barycentric, vertices[faces[buffers.face], 2])
    np.testing.assert_allclose(buffers.depth[buffers.hit], (0.5 - z)[buffers.hit], atol=2e-3)


def test_pixels_see_what_the_camera_projects() -> None:
    mesh = Mesh(*analytic.torus(48, 24))
    camera = Camera.orbit(mesh.vertices, azimuth=200.0, elevation=50.0, size=(81, 60))
    buffers = RayScene(mesh).render(camera)
    rows, columns = np.nonzero(buffers.hit)
    points = np.einsum(
        "nc,nck->nk", buffers.barycentric[rows, columns], mesh.vertices[mesh.faces[buffers.face[rows, columns]]]
    )
    np.testing.assert_allclose(camera.project(points)[:, :2], np.stack([columns, rows], axis=1) + 0.5, atol=1e-3)


def test_both_sides_are_met() -> None:
    scene = RayScene(Mesh(*analytic.plane(2)))
    up = np.array([[0.1, 0.2, 1.0], [0.1, 0.2, -1.0]])
    distance, face = scene.first_hit(up, -up * [0, 0, 1])
    np.testing.assert_allclose(distance, 1.0, atol=1e-6)
    assert (face >= 0).all()


def test_no_ray_slips_between_faces() -> None:
    mesh = Mesh(*analytic.icosphere(3))
    middles = mesh.vertices[mesh.faces[:, [[0, 1], [1, 2], [2, 0]]]].mean(axis=2).reshape(-1, 3)
    targets = np.concatenate([mesh.vertices, middles])
    _, face = RayScene(mesh).first_hit(np.zeros(3), targets)
    assert (face >= 0).all()


def test_picture_in_chunks_is_the_same(torus: Mesh, monkeypatch: pytest.MonkeyPatch) -> None:
    camera = Camera.orbit(torus.vertices, size=(50, 40))
    whole = RayScene(torus).render(camera)
    monkeypatch.setattr("ncmodel.geometry.raycast.CHUNK", 7)
    parts = RayScene(torus).render(camera)
    np.testing.assert_array_equal(whole.face, parts.face)
    np.testing.assert_array_equal(whole.depth, parts.depth)


@pytest.mark.parametrize("eye", [(0.0, 0.0, 0.01), (0.355, 0.0, 0.0), (0.355 + 0.145, 0.0, 0.0)])
def test_eye_inside_or_on_the_mesh(torus: Mesh, eye: tuple[float, float, float]) -> None:
    buffers = RayScene(torus).render(Camera(eye, (0.3, 0.2, -0.5), width=40, height=40, focal_pixels=20.0))
    assert np.isfinite(buffers.depth).all()
    assert ((buffers.depth >= 0) & (buffers.depth <= 1)).all()
    assert buffers.hit.any()


def test_smallest_picture(torus: Mesh) -> None:
    buffers = RayScene(torus).render(Camera((0.0, 3.0, 0.0), width=1, height=1, focal_pixels=1.0))
    assert buffers.depth.shape == (1, 1)
    assert buffers.face[0, 0] == -1  # through the hole


def test_nothing_to_hit() -> None:
    empty = RayScene(Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)))
    distance, face = empty.first_hit(np.zeros(3), np.ones((4, 3)))
    assert np.isinf(distance).all()
    assert (face == -1).all()
    assert len(RayScene(Mesh(*analytic.cube())).hits(np.zeros(3), np.zeros((0, 3))).face) == 0
    buffers = empty.render(Camera((0.0, 0.0, 3.0), width=5, height=4))
    assert (buffers.depth == 1).all()


def test_object_of_one_point_or_far_from_the_origin() -> None:
    flat = RayScene(Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]])))
    assert flat.first_hit(np.array([0.0, 0, 1]), np.array([[0.0, 0, -1]]))[1][0] in (-1, 0)
    vertices, faces = analytic.cube()
    away = RayScene(Mesh(vertices + 1e7, faces))
    distance, _ = away.first_hit(np.full(3, 1e7) + [0, 0, 3.0], np.array([[1e-3, 1e-3, -1.0]]))
    assert distance[0] == pytest.approx(2.5 * np.sqrt(1 + 2e-6), abs=1e-6)
