"""Faces cut into pieces for rays."""

import numpy as np
import pytest

from ncmodel.geometry.raycast import RayScene
from ncmodel.mesh.early_split import CROWDED, early_split
from ncmodel.types import Floats, Ints, Mesh
from tests.helpers import analytic
from tests.helpers.extreme_meshes import book
from tests.helpers.oracles import traced

PAGES = 500


@pytest.fixture(scope="module")
def pages() -> tuple[Floats, Ints]:
    return book(PAGES)


def boxes(corners: Floats) -> float:
    """The mean number of boxes that a point of the scene lies in."""
    room = np.ptp(corners.reshape(-1, 3), axis=0).prod()
    return float(np.ptp(corners, axis=1).prod(axis=1).sum() / room)


def test_pieces_of_a_book_lie_in_few_of_each_others_boxes(pages: tuple[Floats, Ints]) -> None:
    vertices, faces = pages
    pieces = early_split(vertices.astype(np.float32), faces.astype(np.uint32))
    assert pieces is not None
    assert boxes(vertices[faces]) > CROWDED
    assert boxes(pieces.corners.astype(np.float64)) < CROWDED / 5


def test_pieces_cover_their_faces(pages: tuple[Floats, Ints]) -> None:
    vertices, faces = pages
    pieces = early_split(vertices.astype(np.float32), faces.astype(np.uint32))
    assert pieces is not None
    placed = np.einsum("pij,pjk->pik", pieces.weights, vertices[faces[pieces.face]])
    np.testing.assert_allclose(placed, pieces.corners, atol=1e-6)
    sides = pieces.weights[:, 1:] - pieces.weights[:, :1]
    share = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / np.sqrt(3.0)
    np.testing.assert_allclose(np.bincount(pieces.face, share), 1.0, atol=1e-6)


def test_rays_meet_a_cut_face_where_they_meet_the_whole(pages: tuple[Floats, Ints]) -> None:
    rng, scene = np.random.default_rng(0), RayScene(Mesh(*pages))
    vertices, faces = pages
    origins, targets = rng.normal([0, 1, 3], 1.0, (40, 3)), rng.uniform([-1, 0, 0], [1, 1, 1], (40, 3))
    hits = scene.hits(origins, targets - origins)
    for i in range(40):
        direction = (targets[i] - origins[i]) / np.linalg.norm(targets[i] - origins[i])
        expected, _ = traced(vertices, faces, origins[i], direction)
        assert hits.distance[i] == pytest.approx(expected, abs=5e-6)
    met = hits.face >= 0
    assert met.sum() > 20
    corners = vertices[faces[hits.face[met]]]
    np.testing.assert_allclose(np.einsum("ij,ijk->ik", hits.barycentric[met], corners), hits.point[met])


def test_ordinary_shapes_stay_whole() -> None:
    for vertices, faces in (analytic.icosphere(3), analytic.torus(48, 24), analytic.cube(), analytic.plane(4)):
        assert early_split(vertices.astype(np.float32), faces.astype(np.uint32)) is None
