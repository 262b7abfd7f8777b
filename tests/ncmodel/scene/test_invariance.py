"""Drawings don't depend on how a shape is numbered, turned, moved or scaled."""

from itertools import pairwise

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.mesh.load import make_mesh
from ncmodel.types import Floats, Image, LineFamily, Mesh, Thresholds
from tests.helpers import analytic

THRESHOLDS = Thresholds(suggestive=0.001, ridges=0.02, valleys=0.02, apparent=0.02)
"""Low enough that every family has lines on this surface."""

SMOOTH = (LineFamily.CONTOURS, LineFamily.SUGGESTIVE, LineFamily.RIDGES, LineFamily.VALLEYS, LineFamily.APPARENT)


def lumpy() -> Mesh:
    """A torus with bumps, slightly rough, so that no two vertices are alike."""
    vertices, faces = analytic.torus(120, 60)
    bumps = 1 + 0.1 * np.sin(14 * vertices[:, :1]) * np.cos(12 * vertices[:, 2:])
    return make_mesh(vertices * bumps * (1 + np.random.default_rng(0).normal(scale=1e-5, size=vertices.shape)), faces)


def renumbered(mesh: Mesh, seed: int) -> Mesh:
    """The same mesh with its vertices, its faces and the first corners of faces in another order."""
    rng = np.random.default_rng(seed)
    old_from_new = rng.permutation(len(mesh.vertices))
    faces = np.argsort(old_from_new)[mesh.faces][rng.permutation(len(mesh.faces))]
    turned = (np.arange(3) + rng.integers(3, size=(len(faces), 1))) % 3
    return Mesh(np.ascontiguousarray(mesh.vertices[old_from_new]), np.take_along_axis(faces, turned, axis=1))


def ink(mesh: Mesh, camera: Camera, family: LineFamily) -> Image:
    # Simplified, a closed line would stray by up to the tolerance, from wherever it starts.
    return draw(mesh, camera, [family], THRESHOLDS, tolerance=0.0).ink(1.5)


def differing(one: Image, other: Image) -> float:
    """Share of the ink that isn't in both pictures."""
    return float(np.abs(one - other).sum() / (one.sum() + other.sum()))


@pytest.mark.parametrize("family", SMOOTH)
def test_order_of_vertices_and_faces(family: LineFamily) -> None:
    mesh = lumpy()
    camera = Camera.orbit(mesh.vertices, 30.0, 40.0)
    pictures = [ink(mesh, camera, family), *(ink(renumbered(mesh, seed), camera, family) for seed in range(3))]
    assert pictures[0].sum() > 100
    assert max(differing(*pair) for pair in pairwise(pictures)) < 0.01


@pytest.mark.parametrize("family", SMOOTH)
def test_place_turn_and_scale(family: LineFamily) -> None:
    """Shape and camera moved together: the picture stays, whatever the axes are."""
    mesh = lumpy()
    camera = Camera.orbit(mesh.vertices, 30.0, 40.0)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    shift = np.array([0.3, -2.0, 1.1])

    def placed(points: Floats) -> Floats:
        return np.asarray(2.5 * points @ turn.T + shift)

    def point(p: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = placed(np.asarray(p)).tolist()
        return x, y, z

    x, y, z = (turn @ np.asarray(camera.up)).tolist()
    moved = Camera(point(camera.eye), point(camera.target), (x, y, z), camera.width, camera.height, camera.focal_pixels)
    before, after = ink(mesh, camera, family), ink(Mesh(placed(mesh.vertices), mesh.faces), moved, family)
    assert before.sum() > 100
    assert differing(before, after) < 0.01
