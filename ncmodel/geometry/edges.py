"""Edges of a mesh: borders, creases, whether it is closed (geometry-spec 10).

A directed side 3 f + c of face f runs from its corner c + 1 to its corner c + 2, opposite corner c.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ncmodel.geometry.curvature import area_vector
from ncmodel.types import Floats, Ints, LineFamily, LineSet

Sides = NDArray[np.int32]

_HASH = np.uint64(0x9E3779B97F4A7C15)


@dataclass(frozen=True, eq=False)
class Edges:
    """Some edges of a mesh.

    Attributes:
        ends: (n, 2) vertex indices, in the direction of `face`.
        face: (n,) an adjacent face.
    """

    ends: Ints
    face: Ints

    def __len__(self) -> int:
        return len(self.ends)

    def lines(self, family: LineFamily, vertices: Floats) -> LineSet:
        """The edges as lines that no threshold filters."""
        ones = np.ones((len(self.ends), 2))
        return LineSet(family, vertices[self.ends], self.face, ones, ones)


def is_closed(faces: Ints) -> bool:
    """Whether the directed sides pair off with opposite ones: no border, no turned neighbour, no side too many.

    Sums a hash of every side forwards less backwards, so a mesh that isn't closed passes once in 2^64 cases.
    """
    return bool(_closed(faces))


def grouped_sides(faces: Ints, vertex_count: int) -> Sides:
    """(3 F,) directed sides, those on one edge together, in the order of the edges' ends."""
    by_high = _sorted_by_end(faces, vertex_count, np.arange(3 * len(faces), dtype=np.int32), True)
    return np.asarray(_sorted_by_end(faces, vertex_count, by_high, False))


def boundary_edges(faces: Ints, sides: Sides) -> Edges:
    """Directed sides without an oppositely directed twin, in face order."""
    return _edges_of(faces, np.sort(_unpaired(faces, sides)))


def unique_edges(faces: Ints, sides: Sides) -> Ints:
    """(E, 2) the ends of every edge, once, the smaller index first."""
    return np.asarray(_unique(faces, sides))


def creases(vertices: Floats, faces: Ints, sides: Sides, angle: float) -> Edges:
    """Edges between oppositely directed sides whose faces' normals differ by more than `angle` radians.

    Where more than two faces meet, the sharpest pair counts; degenerate faces don't.
    """
    return _edges_of(faces, np.sort(_sharp(vertices, faces, sides, math.cos(angle))))


def _edges_of(faces: Ints, sides: Sides) -> Edges:
    face, corner = np.divmod(sides.astype(np.int64), 3)
    return Edges(np.stack([faces[face, (corner + 1) % 3], faces[face, (corner + 2) % 3]], axis=1), face)


@njit(cache=True, nogil=True, error_model="numpy")
def _closed(faces: Ints) -> bool:
    total = np.uint64(0)
    for f in range(len(faces)):
        for c in range(3):
            i, j = np.uint64(faces[f, c]), np.uint64(faces[f, (c + 1) % 3])
            total += _mixed(i, j) - _mixed(j, i)
    return bool(total == np.uint64(0))


@njit(cache=True, nogil=True, error_model="numpy")
def _mixed(i: np.uint64, j: np.uint64) -> np.uint64:
    """A 64-bit hash of an ordered pair (rounds of Steele et al. 2014's SplitMix64)."""
    x = (i << np.uint64(32)) ^ j
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9) + _HASH
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@njit(cache=True, nogil=True, error_model="numpy")
def _ends(faces: Ints, side: int) -> tuple[int, int]:
    f, c = side // 3, side % 3
    return faces[f, (c + 1) % 3], faces[f, (c + 2) % 3]


@njit(cache=True, nogil=True, error_model="numpy")
def _sorted_by_end(faces: Ints, vertex_count: int, sides: Sides, high: bool) -> Sides:
    """Sides in the order of their higher or lower end, those with the same end in their old order."""
    position = np.zeros(vertex_count + 1, dtype=np.int64)
    for side in sides:
        i, j = _ends(faces, side)
        position[(max(i, j) if high else min(i, j)) + 1] += 1
    for v in range(vertex_count):
        position[v + 1] += position[v]
    ordered = np.empty_like(sides)
    for side in sides:
        i, j = _ends(faces, side)
        end = max(i, j) if high else min(i, j)
        ordered[position[end]] = side
        position[end] += 1
    return ordered


@njit(cache=True, nogil=True, error_model="numpy")
def _group_end(faces: Ints, sides: Sides, begin: int) -> int:
    """Where the group of sides on the same edge as `sides[begin]` ends."""
    i, j = _ends(faces, sides[begin])
    end = begin + 1
    while end < len(sides):
        a, b = _ends(faces, sides[end])
        if not ((a == i and b == j) or (a == j and b == i)):
            break
        end += 1
    return end


@njit(cache=True, nogil=True, error_model="numpy")
def _unpaired(faces: Ints, sides: Sides) -> Sides:
    found = np.empty(len(sides), dtype=np.int32)
    size = begin = 0
    while begin < len(sides):
        end = _group_end(faces, sides, begin)
        rising = 0
        for n in range(begin, end):
            i, j = _ends(faces, sides[n])
            rising += i < j
        if rising == 0 or rising == end - begin:
            for n in range(begin, end):
                found[size] = sides[n]
                size += 1
        begin = end
    return found[:size].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def _unique(faces: Ints, sides: Sides) -> Ints:
    ends = np.empty((len(sides), 2), dtype=np.int64)
    size = begin = 0
    while begin < len(sides):
        i, j = _ends(faces, sides[begin])
        ends[size, 0], ends[size, 1] = min(i, j), max(i, j)
        size += i != j
        begin = _group_end(faces, sides, begin)
    return ends[:size].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def _sharp(vertices: Floats, faces: Ints, sides: Sides, least_cosine: float) -> Sides:
    found = np.empty(len(sides) // 2, dtype=np.int32)
    size = begin = 0
    while begin < len(sides):
        end = _group_end(faces, sides, begin)
        cosine = 1.0
        for m in range(begin, end):
            for n in range(m + 1, end):
                cosine = min(cosine, _cosine_across(vertices, faces, sides[m], sides[n]))
        if cosine < least_cosine:
            found[size] = sides[begin]
            size += 1
        begin = end
    return found[:size].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def _cosine_across(vertices: Floats, faces: Ints, one: int, other: int) -> float:
    """Cosine of the angle between the normals of two sides' faces; 1 if the sides run the same way or one is flat."""
    if _ends(faces, one)[0] == _ends(faces, other)[0]:
        return 1.0
    f, g = faces[one // 3], faces[other // 3]
    ax, ay, az, _, _, _, flat_a = area_vector(vertices, f[0], f[1], f[2])
    bx, by, bz, _, _, _, flat_b = area_vector(vertices, g[0], g[1], g[2])
    if flat_a or flat_b:
        return 1.0
    lengths = (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz)
    return float((ax * bx + ay * by + az * bz) / math.sqrt(lengths))
