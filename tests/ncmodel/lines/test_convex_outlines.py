"""Convex shapes of any tessellation: contours alone are their outline, whole, and nothing else.

The outline of a convex shape on a picture is the convex hull of its vertices there.
"""

from itertools import pairwise

import cv2
import numpy as np
import pytest
from scipy.spatial import cKDTree

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.mesh.load import make_mesh
from ncmodel.types import Floats, Ints, Mesh
from tests.helpers import analytic

EYES = ((30.0, 20.0), (110.0, -10.0), (0.0, 0.0))
"""Azimuth and elevation, degrees."""
SIZE = 512
NEAR = 2.0
"""Pixels within which lines and outline must lie."""
PROFILES = {
    "cone": [(0.0, 1.0), (0.5, 0.0)],
    "flat cone": [(0.0, 0.3), (0.5, 0.0)],
    "long cone": [(0.0, 4.0), (0.5, 0.0)],
    "cone of rows": [(0.0, 1.0), (0.1, 0.8), (0.3, 0.4), (0.5, 0.0)],
    "bipyramid": [(0.0, 1.0), (0.5, 0.0), (0.0, -1.0)],
    "prism": [(0.5, 1.0), (0.5, 0.0)],
    "flat prism": [(0.5, 0.2), (0.5, 0.0)],
    "frustum": [(0.2, 1.0), (0.4, 0.0)],
    "pencil": [(0.0, 1.5), (0.3, 1.0), (0.3, 0.0)],
    "spire": [(0.0, 4.5), (0.3, 4.0), (0.3, 0.0)],
}
"""(radius, height) from top to bottom, a convex polygon."""


def revolved(profile: list[tuple[float, float]], sides: int) -> tuple[Floats, Ints]:
    """A closed solid of revolution about y: fans around tips, and flat ends that are fans from a corner."""
    angle = 2 * np.pi * np.arange(sides) / sides
    vertices, rings = np.zeros((0, 3)), []
    for radius, height in profile:
        count = sides if radius else 1
        rings.append(len(vertices) + np.arange(sides) % count)
        around = np.stack([radius * np.sin(angle), np.full(sides, height), radius * np.cos(angle)], axis=1)
        vertices = np.concatenate([vertices, around[:count]])
    faces = []
    for upper, lower in pairwise(rings):
        next_upper, next_lower = np.roll(upper, -1), np.roll(lower, -1)
        faces += [np.stack([upper, lower, next_lower], axis=1), np.stack([upper, next_lower, next_upper], axis=1)]
    for end, turn in ((rings[0], slice(None)), (rings[-1], slice(None, None, -1))):
        fan = np.stack([np.full(sides - 2, end[0]), end[1:-1], end[2:]], axis=1)
        faces.append(fan[:, turn])
    triangles = np.concatenate(faces)
    proper = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return vertices, triangles[proper]


def dense(line: Floats) -> Floats:
    """Points half a pixel apart along a polyline."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, length[-1], int(2 * length[-1]) + 2)
    return np.stack([np.interp(at, length, column) for column in line.T], axis=1)


def to_nearest(points: Floats, others: Floats) -> Floats:
    return np.asarray(cKDTree(others).query(points)[0])


def camera_of(mesh: Mesh, azimuth: float, elevation: float) -> Camera:
    return Camera.orbit(mesh.used_vertices, azimuth, elevation, size=(SIZE, SIZE))


def check_outline(mesh: Mesh, lines: tuple[str, ...], whole: bool) -> None:
    for eye in EYES:
        camera = camera_of(mesh, *eye)
        pixels = camera.project(mesh.vertices)[:, :2].astype(np.float32)
        hull = cv2.convexHull(pixels)[:, 0].astype(np.float64)
        outline = dense(np.concatenate([hull, hull[:1]]))
        strokes = [s.points for s in draw(mesh, camera, lines).strokes if s.family == "contours"]
        drawn = np.concatenate([dense(points) for points in strokes] or [np.zeros((0, 2))])
        if len(drawn):
            assert to_nearest(drawn, outline).max() <= NEAR + 0.1, eye
        if whole:
            assert (to_nearest(outline, drawn) <= NEAR).mean() > 0.99, eye


@pytest.mark.parametrize("sides", [6, 32, 256])
@pytest.mark.parametrize("profile", PROFILES)
def test_contours_of_a_solid_of_revolution_are_its_outline(profile: str, sides: int) -> None:
    check_outline(make_mesh(*revolved(PROFILES[profile], sides)), ("contours",), whole=True)


@pytest.mark.parametrize("fineness", [0, 1, 3])
@pytest.mark.parametrize("axes", [(1.0, 1.0, 1.0), (1.0, 0.2, 0.7), (0.15, 1.0, 0.15)])
def test_contours_of_an_ellipsoid_are_its_outline(fineness: int, axes: tuple[float, float, float]) -> None:
    check_outline(make_mesh(*analytic.ellipsoid(fineness, axes)), ("contours",), whole=True)


@pytest.mark.parametrize("sides", [8, 64])
@pytest.mark.parametrize("profile", ["cone", "flat cone", "bipyramid", "pencil"])
def test_with_creases_no_contour_is_off_the_outline(profile: str, sides: int) -> None:
    """Where both are drawn, creases may stand for a part of the outline."""
    mesh = make_mesh(*revolved(PROFILES[profile], sides))
    check_outline(mesh, ("contours", "boundaries", "creases"), whole=False)
