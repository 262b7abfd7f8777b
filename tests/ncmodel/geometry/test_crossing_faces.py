"""Pairs of faces that may pass through each other, against all pairs of a mesh."""

import itertools
import math

import numpy as np
import pytest

from ncmodel.geometry.crossing_faces import crossing_faces
from ncmodel.types import Floats, Ints
from tests.helpers import analytic

TOUCH = 1e-6
LEAST = math.radians(10.0)


def one_by_one(vertices: Floats, faces: Ints, touch: float, least_angle: float) -> list[tuple[int, int]]:
    """The pairs whose boxes meet and whose planes both cut the other face, by trying all."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    low, high = corners.min(axis=1), corners.max(axis=1)

    def reaches(face: int, plane: int) -> bool:
        off = (corners[face] - corners[plane, 0]) @ normals[plane]
        return bool(off.min() <= touch and off.max() >= -touch)

    return [
        (f, g)
        for f, g in itertools.combinations(range(len(faces)), 2)
        if not set(faces[f]) & set(faces[g])
        and (low[f] <= high[g] + touch).all()
        and (low[g] <= high[f] + touch).all()
        and normals[f] @ normals[g] <= math.cos(least_angle)
        and reaches(f, g)
        and reaches(g, f)
    ]


def soup(count: int, size: float) -> tuple[Floats, Ints]:
    rng = np.random.default_rng(3)
    corners = rng.uniform(-0.5, 0.5, (count, 1, 3)) + rng.normal(scale=size, size=(count, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def two_tori() -> tuple[Floats, Ints]:
    vertices, faces = analytic.torus(24, 12)
    return np.concatenate([vertices, vertices[:, [1, 2, 0]] + 0.3]), np.concatenate([faces, faces + len(vertices)])


@pytest.mark.parametrize("mesh", [soup(300, 0.1), soup(5, 0.5), two_tori(), analytic.cube()])
def test_pairs_are_those_found_by_trying_all(mesh: tuple[Floats, Ints]) -> None:
    vertices, faces = mesh
    expected = one_by_one(vertices, faces, TOUCH, LEAST)
    found = crossing_faces(vertices, faces.astype(np.uint32), TOUCH, LEAST)
    assert list(map(tuple, found.tolist())) == expected
    assert len(expected) > 10 or len(faces) <= 12


def test_faces_without_area_and_no_faces_have_no_pairs() -> None:
    vertices, faces = soup(40, 0.2)
    before = crossing_faces(vertices, faces.astype(np.uint32), TOUCH, LEAST)
    needles = np.stack([faces[:, 0], faces[:, 1], faces[:, 0]], axis=1)
    both = np.concatenate([faces, needles]).astype(np.uint32)
    assert np.array_equal(crossing_faces(vertices, both, TOUCH, LEAST), before)
    assert crossing_faces(vertices, np.empty((0, 3), np.uint32), TOUCH, LEAST).shape == (0, 2)
