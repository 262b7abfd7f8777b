"""Drilled plates as CSG leaves them, with vertices on other faces' edges: closed, and their holes circles."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from ncmodel.drawing.draw import draw
from ncmodel.mesh.load import load_mesh
from ncmodel.scene.seams import sew_seams
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats
from tests.helpers.mesh_files import as_obj

THICKNESS, RADIUS, SIZE = 0.3, 0.3, 400


def circle(centre: float, sides: int) -> Floats:
    """(sides, 2) points around a hole."""
    angle = 2 * np.pi * np.arange(sides) / sides
    return np.stack([centre + RADIUS * np.cos(angle), 0.5 + RADIUS * np.sin(angle)], axis=1)


def cap(centre: float, sides: int) -> Floats:
    """(T, 3, 2) triangles between a hole and the square around it, of twice as many points on the hole as it has sides.

    The square has a vertex in the middle of one side only: its others are on the edges of the next square, or of walls.
    """
    ring = circle(centre, sides)
    ring = np.stack([ring, (ring + np.roll(ring, -1, axis=0)) / 2], axis=1).reshape(-1, 2)
    corners = centre + np.array([0.5, 0.5, -0.5, -0.5, 0.5, 0.5]), np.array([0.5, 1.0, 1.0, 0.0, 0.0, 0.5])
    square = np.stack(corners, axis=1)
    angle, count = np.radians([0.0, 45.0, 135.0, 225.0, 315.0, 360.0]), len(ring)
    triangles, at = [], 0
    for k in range(count):
        while at < 4 and 2 * np.pi * (k + 0.5) / count > (angle[at] + angle[at + 1]) / 2:
            triangles.append((ring[k], square[at], square[at + 1]))
            at += 1
        triangles.append((ring[k], square[at], ring[(k + 1) % count]))
    triangles.append((ring[0], square[4], square[5]))
    return np.array(triangles)


def plate(holes: int, sides: int) -> Floats:
    """(T, 3, 3) triangles of a plate, y up."""
    parts = []
    for hole in range(holes):
        flat = cap(hole + 0.5, sides)
        for height in (0.0, THICKNESS):
            triangles = np.insert(flat, 1, height, axis=2)
            parts.append(triangles if height == 0.0 else triangles[:, ::-1])
        ring = circle(hole + 0.5, sides)
        parts.append(walls(ring[::-1]))
    outline = np.array([(0.0, 0.0), (holes, 0.0), (holes, 1.0), (0.0, 1.0)])
    return np.concatenate([*parts, walls(outline)])


def walls(ring: Floats) -> Floats:
    """Two triangles over each side of a polygon."""
    low, high = (np.insert(ring, 1, height, axis=1) for height in (0.0, THICKNESS))
    low_next, high_next = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    first, second = np.stack([low, high_next, low_next], axis=1), np.stack([low, high, high_next], axis=1)
    return np.concatenate([first, second])


def edges(holes: int, sides: int) -> Floats:
    """(N, 3) points on the edges that such a plate should show, hidden ones included."""
    outline = np.array([(0.0, 0.0), (holes, 0.0), (holes, 1.0), (0.0, 1.0)])
    rings = np.concatenate([along(ring) for ring in (outline, *(circle(hole + 0.5, sides) for hole in range(holes)))])
    lines = [np.insert(rings, 1, height, axis=1) for height in (0.0, THICKNESS)]
    for x, z in outline:
        lines.append(np.column_stack([np.full(400, x), np.linspace(0, THICKNESS, 400), np.full(400, z)]))
    return np.concatenate(lines)


def along(ring: Floats) -> Floats:
    """(N, 2) points on the sides of a polygon."""
    share = np.linspace(0, 1, 400)[:, None, None]
    return (ring + share * (np.roll(ring, -1, axis=0) - ring)).reshape(-1, 2)


def write(folder: Path, triangles: Floats, suffix: str) -> Path:
    path = folder / f"plate.{suffix}"
    if suffix == "obj":
        vertices, place = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
        path.write_bytes(as_obj(vertices, place.reshape(-1, 3)))
        return path
    record = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    record["corners"] = triangles
    path.write_bytes(bytes(80) + np.uint32(len(record)).tobytes() + record.tobytes())
    return path


@pytest.mark.parametrize("suffix", ["stl", "obj"])
@pytest.mark.parametrize(
    ("holes", "sides", "azimuth", "elevation"),
    [(1, 48, 310, 65), (2, 24, 30, 35), (4, 24, 75, 50), (1, 12, 310, 65), (2, 12, 75, 50)],
)
def test_a_drilled_plate_is_drawn_as_its_edges(
    tmp_path: Path, suffix: str, holes: int, sides: int, azimuth: float, elevation: float
) -> None:
    mesh = load_mesh(write(tmp_path, plate(holes, sides), suffix))
    assert len(Surface(mesh).boundary_edges) > 20
    assert sew_seams(Surface(mesh)).is_closed
    drawing = draw(mesh, azimuth=azimuth, elevation=elevation, size=SIZE)
    assert "boundaries" not in {stroke.family for stroke in drawing.strokes}
    # Object space is the file's, moved and scaled.
    points = edges(holes, sides)
    scale = np.ptp(mesh.vertices[:, 1]) / THICKNESS
    points = (points - [holes / 2, THICKNESS / 2, 0.5]) * scale
    u, v = drawing.camera.project(points)[:, :2].T
    expected = np.ones((SIZE, SIZE), np.uint8)
    expected[v.astype(int), u.astype(int)] = 0
    ink = drawing.ink() > 0.25
    astray = cv2.distanceTransform(expected, cv2.DIST_L2, 5)[ink]
    assert astray.max() <= 3.0
    rims = (np.insert(along(circle(hole + 0.5, sides)), 1, THICKNESS, axis=1) for hole in range(holes))
    rim = drawing.camera.project((np.concatenate(list(rims)) - [holes / 2, THICKNESS / 2, 0.5]) * scale)[:, :2]
    away = cv2.distanceTransform((~ink).astype(np.uint8), cv2.DIST_L2, 5)
    assert away[rim[:, 1].astype(int), rim[:, 0].astype(int)].max() <= 2.0
