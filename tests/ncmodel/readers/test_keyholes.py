"""Polygons with holes that bridges join to their outline, and others that touch themselves: covered once."""

from pathlib import Path

import numpy as np
import pytest

from ncmodel.errors import MeshError
from ncmodel.mesh.load import read_geometry
from ncmodel.readers.triangulate import triangulate
from ncmodel.types import Floats

TILT = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]


def doubled_areas(points: Floats) -> Floats:
    """Of the triangles of one polygon (n, 2), signed by the polygon's own; the last is the polygon's."""
    tilted = np.pad(points, ((0, 0), (0, 1))) @ TILT
    a, b, c = points[triangulate(tilted, np.arange(len(points)), np.array([len(points)]))].transpose(1, 0, 2)
    u, v = b - a, c - a
    following = np.roll(points, -1, axis=0)
    whole = (points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]).sum()
    return np.append((u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) * np.sign(whole), abs(whole))


def chained(outline: Floats, holes: list[Floats]) -> Floats:
    """An outline whose last corner is joined to the first hole's first, a hole's middle corner to the next hole."""
    ring = np.zeros((0, 2))
    for hole in reversed(holes):
        middle = len(hole) // 2
        inner = np.concatenate([hole[: middle + 1], ring, hole[middle : middle + 1] if len(ring) else ring])
        ring = np.concatenate([inner, hole[middle + 1 :], hole[:1]])
    return np.concatenate([outline, ring, outline[-1:]])


def from_one_corner(outline: Floats, holes: list[Floats]) -> Floats:
    """An outline whose last corner is joined to every hole's first corner; the holes ordered round it."""
    spokes = [np.concatenate([hole, hole[:1], outline[-1:]]) for hole in holes]
    return np.concatenate([outline, *spokes])


def clockwise(count: int, middle: tuple[float, float], radius: float, start: float = np.pi) -> Floats:
    angle = start - 2 * np.pi * np.arange(count) / count
    return np.stack([middle[0] + radius * np.cos(angle), middle[1] + radius * np.sin(angle)], axis=1)


SQUARE = np.array([[10.0, 0], [10, 10], [0, 10], [0, 0]])
BOX = np.array([[0.0, 0], [0, 1], [1, 1], [1, 0]])
RINGS = {
    "one hole": chained(SQUARE, [BOX * 4 + 3]),
    "a bridge along sides": chained(SQUARE[[1, 2, 3, 0]] - [0, 4], [BOX[[3, 0, 1, 2]] * 2 + [4, -4]]),
    "holes in a row": chained(SQUARE, [BOX + [1, 1], BOX + [3, 1], BOX + [5, 1], BOX + [7, 2]]),
    "holes in line": chained(SQUARE - [0, 5], [BOX + [1, 0], BOX + [3, 0], BOX + [6, 0]]),
    "holes at one corner": from_one_corner(SQUARE, [BOX + [1, 6], BOX + [4, 4], BOX + [6, 1]]),
    "round holes": chained(SQUARE, [clockwise(24, (2.0 + 3 * n, 5), 1.2) for n in range(3)]),
    "a ring": chained(clockwise(60, (0, 0), 2)[::-1], [clockwise(60, (0, 0), 1.9, np.pi + 0.1)]),
    "a hole that touches a side": chained(SQUARE, [np.array([[2.0, 2], [5, 10], [8, 2]])]),
    "two squares at one corner": np.array([[0.0, 0], [1, 0], [1, 1], [2, 1], [2, 2], [1, 2], [1, 1], [0, 1]]),
    "a cut into a square": np.concatenate([SQUARE, [[5.0, 5]], SQUARE[-1:]]),
}


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("name", RINGS)
def test_a_polygon_that_touches_itself_is_covered_once(name: str, mirrored: bool) -> None:
    """From whichever corner it is told, and either way round."""
    ring = RINGS[name][::-1] if mirrored else RINGS[name]
    for first in range(len(ring)):
        *areas, whole = doubled_areas(np.roll(ring, -first, axis=0))
        assert min(areas) >= -1e-9 * whole, (first, areas)
        assert sum(areas) == pytest.approx(whole, rel=1e-9)


@pytest.mark.parametrize("seed", range(40))
def test_holes_anywhere(seed: int) -> None:
    rng = np.random.default_rng(seed)
    outline = SQUARE * [1, 0.6] * rng.integers(1, 4) + [-1, 0]
    holes = []
    for n in range(rng.integers(1, 6)):
        count, radius = int(rng.integers(3, 9)), rng.uniform(0.2, 0.7)
        middle = (1.5 * n + 0.8, 1 + rng.uniform(0, 3))
        hole = clockwise(count, middle, radius, rng.uniform(0, 2 * np.pi))
        holes.append(np.roll(hole, -int(hole[:, 0].argmin()), axis=0))
    # The middle corner of a hole sees the next one's first only if it is the farthest to the right.
    holes = [hole for hole in holes if hole[:, 0].argmax() == len(hole) // 2] or holes[:1]
    *areas, whole = doubled_areas(chained(outline, holes))
    assert min(areas) >= -1e-9 * whole
    assert sum(areas) == pytest.approx(whole, rel=1e-9)


def test_the_diagonal_of_an_arrowhead_lies_inside() -> None:
    """The shorter one would not; a folded quad keeps it."""
    arrow = np.array([[0.0, 0], [10, 1], [9, 0], [10, -1]])
    for first in range(4):
        *areas, whole = doubled_areas(np.roll(arrow, -first, axis=0))
        assert min(areas) > 0
        assert sum(areas) == pytest.approx(whole)


def test_faces_of_two_corners_are_no_points(tmp_path: Path) -> None:
    path = tmp_path / "edges.off"
    path.write_text("OFF 3 2\n0 0 0\n1 0 0\n1 1 0\n2 0 1\n2 1 2\n")
    with pytest.raises(MeshError, match=r"edges.off: 2 faces of fewer than three corners: lines or points; expected"):
        read_geometry(path)
