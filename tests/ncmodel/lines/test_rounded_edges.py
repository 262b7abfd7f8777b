"""Rounded edges of few rows of faces: found whole, one line along each; real curved surfaces aren't."""

import math

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.creases import CreaseLines, crease_lines, split_at_creases
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats
from tests.helpers.dirty import Geometry


def bar(corners: int, rows: int, radius: float = 0.008, lengths: int = 1, seed: int | None = None) -> Geometry:
    """A prism with rounded edges along z, from -0.5 to 0.5, and flat ends.

    Args:
        corners: Of the prism.
        rows: Of faces on each of its edges.
        radius: Of the rounding.
        lengths: Pieces along z.
        seed: Turns the diagonals of faces at random.
    """
    turns = np.linspace(-0.5, 0.5, rows + 1) * 2 * math.pi / corners
    middle = 2 * math.pi * (np.arange(corners) + 0.5) / corners
    angle = (middle[:, None] + turns).ravel()
    centre = np.repeat((0.35 - radius / math.cos(math.pi / corners)) * np.exp(1j * middle), rows + 1)
    ring = centre + radius * np.exp(1j * angle)
    count = len(ring)
    z = np.linspace(-0.5, 0.5, lengths + 1)
    around = np.concatenate([np.column_stack([ring.real, ring.imag, np.full(count, height)]) for height in z])
    vertices = np.concatenate([around, [(0.0, 0.0, -0.5), (0.0, 0.0, 0.5)]])
    random = np.random.default_rng(seed)
    faces = []
    for low in range(lengths):
        for n in range(count):
            a, b = low * count + n, low * count + (n + 1) % count
            c, d = b + count, a + count
            turned = seed is not None and random.random() < 0.5
            faces += [(a, b, d), (b, c, d)] if turned else [(a, b, c), (a, c, d)]
    for n in range(count):
        top = lengths * count
        faces += [((n + 1) % count, n, len(vertices) - 2), (top + n, top + (n + 1) % count, len(vertices) - 1)]
    return vertices, np.array(faces)


def lines_of(part: Geometry) -> tuple[Surface, CreaseLines]:
    surface = Surface(make_mesh(*part))
    return surface, crease_lines(surface, 40.0)


def lengths_by_angle(surface: Surface, lines: CreaseLines) -> dict[int, float]:
    """Where round the bar the lines along it lie, to 10 degrees -> their length there."""
    points: Floats = surface.mesh.vertices[lines.rounded.ends]
    angle = np.degrees(np.arctan2(*points.mean(axis=1)[:, [1, 0]].T)) % 360.0
    found: dict[int, float] = {}
    for place, length in zip(np.round(angle, -1), np.linalg.norm(points[:, 1] - points[:, 0], axis=1), strict=True):
        found[int(place)] = found.get(int(place), 0.0) + float(length)
    return found


@pytest.mark.parametrize("lengths", [1, 7])
@pytest.mark.parametrize("seed", [None, 3])
@pytest.mark.parametrize(("corners", "rows"), [(6, 1), (6, 2), (4, 3), (8, 1), (8, 2)])
def test_a_rounded_edge_is_one_line_of_its_whole_length(
    corners: int, rows: int, lengths: int, seed: int | None
) -> None:
    surface, lines = lines_of(bar(corners, rows, lengths=lengths, seed=seed))
    found = lengths_by_angle(surface, lines)
    assert len(found) == corners
    np.testing.assert_allclose(list(found.values()), 1.0, rtol=1e-9)
    assert len(lines.strips) == corners * (rows + 1) * lengths
    # Of an odd number of edges, the one in the middle; of an even one, one beside it.
    rounding = 2 * math.pi / corners / (2 if rows % 2 else 1000)
    middle = 2 * math.pi * (np.arange(corners) + 0.5) / corners
    place = np.arctan2(*surface.mesh.vertices[lines.rounded.ends].mean(axis=1)[:, [1, 0]].T)
    off = np.abs(np.exp(1j * place)[:, None] - np.exp(1j * middle)).min(axis=1)
    assert off.max() < rounding


@pytest.mark.parametrize(
    "part",
    [
        bar(4, 9),  # many rows: a curved surface
        bar(12, 0),  # a pipe of a few sides
        bar(4, 3, radius=0.2),  # too wide
        bar(16, 1),  # bends by less than a crease
    ],
)
def test_curved_surfaces_and_flat_ones_have_none(part: Geometry) -> None:
    _, lines = lines_of(part)
    assert len(lines.rounded) == len(lines.strips) == 0


def test_sharp_edges_are_creases_as_they_were() -> None:
    _, lines = lines_of(bar(4, 0))
    assert len(lines.sharp) == 12
    assert len(lines.rounded) == 0


def test_no_line_of_curvature_remains_along_a_rounded_edge() -> None:
    drawing = draw(make_mesh(*bar(4, 3, lengths=5, seed=1)), azimuth=70, elevation=25)
    assert {stroke.family for stroke in drawing.strokes} <= {"creases", "contours"}


def test_at_the_outline_the_outline_is_drawn_and_not_the_middle_of_the_edge() -> None:
    """From the front, all four edges are on the outline: one line each."""
    surface = split_at_creases(Surface(make_mesh(*bar(4, 3))), 40.0)
    lines = crease_lines(surface, 40.0)
    whole = surface.whole
    side = Camera.orbit(whole.mesh.vertices, azimuth=90, elevation=0)
    seen = lines.seen_from(side.viewpoint, whole.mesh.vertices, whole.faces)
    assert len(seen) - len(lines.sharp) < len(lines.rounded) == 4
    drawing = draw(surface, side)
    upright = [s for s in drawing.strokes if np.ptp(s.points[:, 1]) > 5 * np.ptp(s.points[:, 0])]
    assert len(drawing.strokes) < 8
    assert {s.family for s in upright} <= {"contours", "creases"}
