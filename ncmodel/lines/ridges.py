"""Lines where a curvature is extremal along its direction: ridges, valleys, apparent ridges (docs/geometry.md 8, 9).

Sources: Ohtake et al. 2004 (ridges and valleys on meshes), Judd et al. 2007 (apparent ridges).

All three are zero crossings of a derivative E of a curvature K along its direction T. The slopes E T at the corners of
a face, unlike E, don't depend on the sign of T; where two of them point apart, E is 0 on the side between. Two such
sides make one segment, three make three that meet in the centroid. Slopes are never stored: writing them would take
longer than all that is made from them.
"""

import numpy as np

from ncmodel.geometry.normals_areas import Indices, check_columns
from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, LineFamily, LineSet

_Point = tuple[float, float, float, float]
"""A position and the absolute value of the curvature there."""


def ridges_and_valleys(
    vertices: Floats, faces: Indices, k1: Floats, dir1: Floats, derivative: Floats, feature_size: float
) -> tuple[LineSet, LineSet]:
    """Ridges and valleys from every side, back faces included.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        k1: (V,) curvature of largest absolute value, convex positive.
        dir1: (V, 3) its direction.
        derivative: (V,) of k1 along dir1.
        feature_size: Makes the strength dimensionless.
    """
    found = _crossed_faces(faces, dir1, derivative)
    face, points, level = _segments(vertices, faces, found, dir1, derivative, k1, False)
    convex = k1[faces[face, 0]] > 0.0
    ones = np.ones_like(level)
    return (
        LineSet(LineFamily.RIDGES, points, face, level, ones, feature_size).take(convex),
        LineSet(LineFamily.VALLEYS, points, face, level, ones, feature_size).take(~convex),
    )


def apparent_ridges(
    vertices: Floats, faces: Indices, q1: Floats, direction: Floats, derivative: Floats, feature_size: float
) -> LineSet:
    """Maxima of view-dependent curvature along its direction.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        q1: (V,) squared view-dependent curvature.
        direction: (V, 3) its direction.
        derivative: (V,) of q1 along it.
        feature_size: Makes the strength dimensionless.
    """
    found = _crossed_faces(faces, direction, derivative)
    face, points, level = _segments(vertices, faces, found, direction, derivative, q1, True)
    return LineSet(LineFamily.APPARENT, points, face, level, np.ones_like(level), feature_size**2)


def facing_only(lines: LineSet, faces: Indices, n_dot_v: Floats) -> LineSet:
    """The segments on faces that have a corner turned to the eye."""
    facing = n_dot_v.take(faces.take(lines.face, axis=0)) > 0.0
    return lines.take(facing[:, 0] | facing[:, 1] | facing[:, 2])


def resolved_in_view(lines: LineSet, faces: Indices, n_dot_v: Floats) -> LineSet:
    """The segments on faces that are small enough to tell the view-dependent curvature there, which grows as 1 / n.v.

    Where n.v changes by more from corner to corner of a face than it is at the least of them, as on the few facets of a
    hole's wall that turn away, q1 jumps from row to row of faces: its maxima are the tessellation's.

    Args:
        lines: Apparent ridges.
        faces: (F, 3).
        n_dot_v: (V,).
    """
    corners = n_dot_v.take(faces.take(lines.face, axis=0))
    return lines.take(np.abs(corners).min(axis=1) >= np.ptp(corners, axis=1))


@kernel
def _crossed_faces(faces: Indices, direction: Floats, derivative: Floats) -> Indices:
    """Faces with slopes that point apart on two sides or more."""
    check_columns(faces, 3)
    check_columns(direction, 3)
    found = np.empty(len(faces), dtype=np.uint32)
    size = 0
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        on_i = _apart(direction, derivative, j, k)
        on_j = _apart(direction, derivative, k, i)
        # One branch, hardly ever taken.
        if on_i | on_j:
            found[size] = f
            size += (on_i & on_j) | _apart(direction, derivative, i, j)
    return found[:size].copy()


@kernel
def _apart(direction: Floats, derivative: Floats, i: int, j: int) -> bool:
    """Whether the slopes at two corners point apart."""
    along = direction[i, 0] * direction[j, 0] + direction[i, 1] * direction[j, 1] + direction[i, 2] * direction[j, 2]
    return bool(derivative[i] * derivative[j] * along <= 0.0)


@kernel
def _segments(
    vertices: Floats,
    faces: Indices,
    found: Indices,
    direction: Floats,
    derivative: Floats,
    curvature: Floats,
    apparent: bool,
) -> tuple[Ints, Floats, Floats]:
    """The segments on faces `found`, without those of no curvature: faces (S,), points (S, 2, 3), |curvature| (S, 2).

    Only extrema of the right kind count. Ridges and valleys (maxima where the curvature is positive at all corners,
    minima where it is negative) are tested by side, apparent ridges (maxima) by segment.
    """
    check_columns(vertices, 3)
    check_columns(faces, 3)
    check_columns(direction, 3)
    face = np.empty(3 * len(found), dtype=np.int64)
    points = np.empty((3 * len(found), 2, 3))
    level = np.empty((3 * len(found), 2))
    size = 0
    for f in found:
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        low, high = min(curvature[i], curvature[j], curvature[k]), max(curvature[i], curvature[j], curvature[k])
        if not apparent and low <= 0.0 and high >= 0.0:
            continue
        sign = 0.0 if apparent else (1.0 if low > 0.0 else -1.0)
        on_i = _crossed(vertices, direction, derivative, j, k, sign)
        on_j = _crossed(vertices, direction, derivative, k, i, sign)
        on_k = _crossed(vertices, direction, derivative, i, j, sign)
        if int(on_i) + int(on_j) + int(on_k) < 2:
            continue
        # Sides ab and bc are joined; or, where all three are crossed, each ab in turn and the centroid.
        joined = not (on_i and on_j and on_k)
        a, b, c = (k, i, j) if not on_i else ((i, j, k) if not on_j else (j, k, i))
        for _ in range(1 if joined else 3):
            start = _side_point(vertices, derivative, curvature, a, b)
            end = (
                _side_point(vertices, derivative, curvature, b, c)
                if joined
                else _centroid(vertices, curvature, a, b, c)
            )
            some = start[3] > 0.0 or end[3] > 0.0
            if some and (not apparent or _run_towards(vertices, direction, derivative, a, b, c, start, end)):
                face[size] = f
                for axis in range(3):
                    points[size, 0, axis], points[size, 1, axis] = start[axis], end[axis]
                level[size, 0], level[size, 1] = start[3], end[3]
                size += 1
            a, b, c = b, c, a
    return face[:size], points[:size], level[:size]


@kernel
def _crossed(vertices: Floats, direction: Floats, derivative: Floats, i: int, j: int, sign: float) -> bool:
    """Whether the slopes at the ends of a side point apart: there is an extremum between.

    With `sign` 1 (-1), one of them must also point along the side inwards (outwards), which makes it a maximum
    (minimum): docs/geometry.md 8.
    """
    if sign == 0.0 or not _apart(direction, derivative, i, j):
        return _apart(direction, derivative, i, j)
    x, y, z = vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1], vertices[j, 2] - vertices[i, 2]
    at_i = sign * _steepness(direction, derivative, i, x, y, z)
    at_j = sign * _steepness(direction, derivative, j, x, y, z)
    return bool(at_i >= 0.0 or at_j <= 0.0)


@kernel
def _side_point(vertices: Floats, derivative: Floats, curvature: Floats, a: int, b: int) -> _Point:
    """Where the derivative is 0 on the side from a to b."""
    at_a, at_b = abs(derivative[a]), abs(derivative[b])
    w = at_a / (at_a + at_b) if at_a + at_b > 0.0 else 0.5
    return (
        vertices[a, 0] + w * (vertices[b, 0] - vertices[a, 0]),
        vertices[a, 1] + w * (vertices[b, 1] - vertices[a, 1]),
        vertices[a, 2] + w * (vertices[b, 2] - vertices[a, 2]),
        abs(curvature[a] + w * (curvature[b] - curvature[a])),
    )


@kernel
def _centroid(vertices: Floats, curvature: Floats, a: int, b: int, c: int) -> _Point:
    """The middle of a face."""
    return (
        (vertices[a, 0] + vertices[b, 0] + vertices[c, 0]) / 3.0,
        (vertices[a, 1] + vertices[b, 1] + vertices[c, 1]) / 3.0,
        (vertices[a, 2] + vertices[b, 2] + vertices[c, 2]) / 3.0,
        abs(curvature[a] + curvature[b] + curvature[c]) / 3.0,
    )


@kernel
def _run_towards(
    vertices: Floats, direction: Floats, derivative: Floats, a: int, b: int, c: int, start: _Point, end: _Point
) -> bool:
    """Whether the slopes at a and c, on one side of a segment, and at b, on the other, point towards it."""
    ex, ey, ez = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
    fx, fy, fz = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1], vertices[c, 2] - vertices[a, 2]
    nx, ny, nz = ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx
    x, y, z = start[0] - end[0], start[1] - end[1], start[2] - end[2]
    px, py, pz = ny * z - nz * y, nz * x - nx * z, nx * y - ny * x
    at_a = _steepness(direction, derivative, a, px, py, pz)
    at_b = _steepness(direction, derivative, b, px, py, pz)
    at_c = _steepness(direction, derivative, c, px, py, pz)
    return bool(at_a > 0.0 and at_b < 0.0 and at_c > 0.0)


@kernel
def _steepness(direction: Floats, derivative: Floats, v: int, x: float, y: float, z: float) -> float:
    """The slope at a vertex along (x, y, z)."""
    return float(derivative[v] * (direction[v, 0] * x + direction[v, 1] * y + direction[v, 2] * z))
