"""Where a surface passes through another one or itself (docs/geometry.md 10).

Bodies that pierce each other share no edge where they meet. Each pair of faces that pass through each other has a
segment of that line: what both have of the line in which their planes cut. Faces that only touch have none: a box that
stands on a table, a wall that ends at a roof, layers that lie on each other. Corners nearer to a plane than files round
lie on it, and a face with one side on a plane goes through it only if the next face across that side goes on beyond.
"""

import math

import numpy as np

from ncmodel.geometry.adjacency import Offsets, Rings, components
from ncmodel.geometry.coincident_faces import distinct_faces
from ncmodel.geometry.crossing_faces import crossing_faces, extent, height, unit_normal
from ncmodel.geometry.normals_areas import Indices, check_columns
from ncmodel.jit import kernel
from ncmodel.lines.chaining import connected
from ncmodel.mesh.weld import ROUNDING
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mask

LEAST_ANGLE = math.radians(10.0)
"""Between the normals of faces that have a line where they meet."""
PARALLEL = 1e-3
"""Planes with a smaller sine between them are the same or the reverse: what they have in common is no line."""
STRONG_ANGLE = math.radians(20.0)
STRONG_SHARE = 0.25
"""At least this share of a line's length is between normals at more than `STRONG_ANGLE`: a line goes on where bodies
are nearly flush, and layers that nearly coincide, whose facets pass through each other everywhere, have none."""
ROUGH_SEGMENTS = 16
ROUGH_LENGTH = 0.05
"""Lines of fewer segments, and shorter than this share of the object, in which a connected surface passes through
itself are roughness, as where a scan is folded over."""


def intersections(vertices: Floats, faces: Indices, rings: Rings) -> LineSet:
    """The lines in which faces pass through each other, in the order of the faces.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        rings: The faces around each vertex.
    """
    _, size = extent(vertices, faces)
    touch = ROUNDING * size
    # Copies of faces would have all their lines again, with each copy of the other face.
    distinct = distinct_faces(vertices, faces)
    if distinct is None:
        pairs = crossing_faces(vertices, faces, touch, LEAST_ANGLE)
    else:
        pairs = distinct[crossing_faces(vertices, faces[distinct], touch, LEAST_ANGLE)]
    points, cosine, found = _segments(vertices, faces, rings.starts, rings.around, pairs, touch)
    pairs, points, cosine = pairs[found], points[found], cosine[found]
    if len(pairs):
        shell = components(faces, len(vertices))[faces[pairs, 0]]
        kept = _are_lines(points, cosine <= math.cos(STRONG_ANGLE), shell[:, 0] == shell[:, 1], ROUGH_LENGTH * size)
        pairs, points = pairs[kept], points[kept]
    # Of both faces the one farther along x, so that it doesn't depend on how faces are numbered.
    ahead = np.argmax(vertices[faces[pairs], 0].sum(axis=2), axis=1)
    face = pairs[np.arange(len(pairs)), ahead]
    order, ones = np.argsort(face, kind="stable"), np.ones((len(pairs), 2))
    return LineSet(LineFamily.INTERSECTIONS, points[order], face[order], ones, ones)


def _are_lines(points: Floats, strong: Mask, within: Mask, rough: float) -> Mask:
    """(S,) which segments are part of lines that are drawn.

    Args:
        points: (S, 2, 3).
        strong: (S,) whether the normals differ by more than `STRONG_ANGLE`.
        within: (S,) whether a connected surface passes through itself.
        rough: The length below which such lines of few segments are roughness.
    """
    run = connected(points)
    length = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    total, number = np.bincount(run, length), np.bincount(run)
    sharp = np.bincount(run, length * strong) >= STRONG_SHARE * total
    large = (number >= ROUGH_SEGMENTS) | (total >= rough) | (np.bincount(run, within) < number)
    return np.asarray((sharp & large)[run])


@kernel
def _segments(
    vertices: Floats, faces: Indices, starts: Offsets, around: Indices, pairs: Ints, touch: float
) -> tuple[Floats, Floats, Mask]:
    """What pairs of faces have in common.

    Returns:
        (P, 2, 3) end points; (P,) cosine of the angle between the normals; (P,) whether the faces pass
        through each other.
    """
    check_columns(vertices, 3)
    check_columns(faces, 3)
    points, cosine, found = np.zeros((len(pairs), 2, 3)), np.zeros(len(pairs)), np.zeros(len(pairs), np.bool_)
    ends, place = np.empty((4, 3)), np.empty(4)
    for p in range(len(pairs)):
        f, g = pairs[p, 0], pairs[p, 1]
        a, b = unit_normal(vertices, faces, f), unit_normal(vertices, faces, g)
        along = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        if along[0] ** 2 + along[1] ** 2 + along[2] ** 2 < PARALLEL**2:
            continue
        if not _cut(vertices, faces, starts, around, f, faces[g, 0], b, touch, ends[:2]):
            continue
        if not _cut(vertices, faces, starts, around, g, faces[f, 0], a, touch, ends[2:]):
            continue
        for n in range(4):
            place[n] = ends[n, 0] * along[0] + ends[n, 1] * along[1] + ends[n, 2] * along[2]
        # Each face's ends in the same order; the inner ones of the four are those of what both have.
        for n in (0, 2):
            if place[n] > place[n + 1]:
                place[n], place[n + 1] = place[n + 1], place[n]
                for axis in range(3):
                    ends[n, axis], ends[n + 1, axis] = ends[n + 1, axis], ends[n, axis]
        begin, stop = 0 if place[0] >= place[2] else 2, 1 if place[1] <= place[3] else 3
        if place[begin] < place[stop]:
            points[p, 0], points[p, 1] = ends[begin], ends[stop]
            cosine[p], found[p] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2], True
    return points, cosine, found


@kernel
def _cut(
    vertices: Floats,
    faces: Indices,
    starts: Offsets,
    around: Indices,
    f: int,
    origin: int,
    normal: tuple[float, float, float],
    touch: float,
    ends: Floats,
) -> bool:
    """Where a plane cuts face f, into `ends` (2, 3); False if it doesn't, or the surface only touches it there.

    Of the two faces at a side on the plane, the one below counts.
    """
    size, below, above = 0, False, False
    for c in range(3):
        i, j = faces[f, c], faces[f, (c + 1) % 3]
        at_i, at_j = _level(vertices, i, origin, normal, touch), _level(vertices, j, origin, normal, touch)
        below, above = below or at_i < 0.0, above or at_i > 0.0
        if at_i == 0.0:
            if size < 2:
                ends[size] = vertices[i]
            size += 1
        elif at_i * at_j < 0.0:
            # From the lower index, so that both faces at a side have the very same point.
            low, high, share = (i, j, at_i / (at_i - at_j)) if i < j else (j, i, at_j / (at_j - at_i))
            if size < 2:
                for axis in range(3):
                    ends[size, axis] = vertices[low, axis] + share * (vertices[high, axis] - vertices[low, axis])
            size += 1
    if size != 2 or not below:
        return False
    if above:
        return True
    return _goes_on(vertices, faces, starts, around, f, origin, normal, touch)


@kernel
def _goes_on(
    vertices: Floats,
    faces: Indices,
    starts: Offsets,
    around: Indices,
    f: int,
    origin: int,
    normal: tuple[float, float, float],
    touch: float,
) -> bool:
    """Whether another face across the side that face f has on a plane is above the plane."""
    for c in range(3):
        i, j = faces[f, c], faces[f, (c + 1) % 3]
        if _level(vertices, i, origin, normal, touch) != 0.0 or _level(vertices, j, origin, normal, touch) != 0.0:
            continue
        for n in range(starts[i], starts[i + 1]):
            following, previous = around[n, 0], around[n, 1]
            if following == j and _level(vertices, previous, origin, normal, touch) > 0.0:
                return True
            if previous == j and _level(vertices, following, origin, normal, touch) > 0.0:
                return True
    return False


@kernel
def _level(vertices: Floats, v: int, origin: int, normal: tuple[float, float, float], touch: float) -> float:
    """How far vertex v is above a plane, 0 if it touches it."""
    above = height(vertices, v, origin, normal)
    return 0.0 if abs(above) <= touch else above
