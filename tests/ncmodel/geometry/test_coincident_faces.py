"""Faces that lie on each other: which are told apart, and that copies cost no more than the face itself."""

import numpy as np
import pytest

from ncmodel.geometry.coincident_faces import distinct_faces
from ncmodel.geometry.raycast import RayScene
from ncmodel.scene.surface import Surface
from ncmodel.types import Mesh
from tests.helpers.dirty import box

TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
EYE = np.array([0.2, 0.2, 3.0])


def test_corners_at_the_same_positions_in_any_order_are_the_same_face() -> None:
    vertices = np.concatenate([TRIANGLE, TRIANGLE, [[0.0, 0, 1]]])
    vertices[3, 2] = -0.0
    faces = np.array([[0, 1, 2], [3, 4, 5], [1, 3, 5], [2, 1, 0], [0, 1, 6], [6, 4, 3], [0, 0, 1]], np.uint32)
    distinct = distinct_faces(vertices, faces)
    assert distinct is not None
    assert distinct.tolist() == [0, 4, 6]


def test_nothing_is_copied_of_a_mesh_without_copies() -> None:
    vertices, faces = box()
    assert distinct_faces(vertices, faces.astype(np.uint32)) is None


def test_a_ray_meets_the_first_of_coincident_faces() -> None:
    faces = np.concatenate([[[0, 1, 3]], np.tile([[0, 1, 2], [2, 1, 0]], (500, 1)), [[1, 3, 2]]])
    scene = RayScene(Mesh(np.concatenate([TRIANGLE, [[0.0, 0, -1]]]), faces))
    distance, face = scene.first_hit(EYE, np.array([[0.0, 0, -1], [1, 1, 0], [0.0, -0.05, -1]]))
    assert face.tolist() == [1, -1, 1]
    assert distance[0] == pytest.approx(3.0)
    assert scene.hits(EYE, np.array([[0.0, 0, -1]])).point[0] == pytest.approx([0.2, 0.2, 0])


def test_copies_of_faces_that_cross_have_one_line() -> None:
    vertices = np.concatenate([TRIANGLE, TRIANGLE[:, [2, 0, 1]] + [0.2, 0.2, -0.5]])
    once = np.array([[0, 1, 2], [3, 4, 5]])
    mesh, crowd = Mesh(vertices, once), Mesh(vertices, np.tile(once, (300, 1)))
    alone, among = Surface(mesh).intersections, Surface(crowd).intersections
    assert len(alone) == 1
    assert np.array_equal(alone.points, among.points)
