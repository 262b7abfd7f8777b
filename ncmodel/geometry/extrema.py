"""Lines where a curvature is extremal along its own direction: ridges, valleys, apparent ridges (geometry-spec 8, 9).

Sources: Ohtake et al. 2004 (ridges and valleys on meshes), Judd et al. 2007 (apparent ridges).

All three are zero crossings of a derivative E of a curvature K along its direction T. The slopes E T at the corners of
a face, unlike E, don't depend on the sign of T; where two of them point apart, E is 0 on the side between. Two such
sides make one segment, three make three that meet in the centroid.
"""

import numpy as np
from numba import njit

from ncmodel.geometry.areas import Indices
from ncmodel.types import Floats, Ints, LineFamily, LineSet


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
    slope = dir1 * derivative[:, None]
    found = _bent_one_way(vertices, faces, slope, k1)
    face, points, level = _segments(vertices, faces, found, slope, derivative, k1, True)
    convex = k1[faces[face, 0]] > 0.0
    ones = np.ones_like(level)
    return (
        LineSet(LineFamily.RIDGES, points, face, level, ones, feature_size).take(convex),
        LineSet(LineFamily.VALLEYS, points, face, level, ones, feature_size).take(~convex),
    )


def apparent_ridges(
    vertices: Floats, faces: Indices, q1: Floats, slope: Floats, derivative: Floats, feature_size: float
) -> LineSet:
    """Maxima of view-dependent curvature along its direction.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        q1: (V,) squared view-dependent curvature.
        slope: (V, 3) derivative times direction.
        derivative: (V,) of q1 along its direction.
        feature_size: Makes the strength dimensionless.
    """
    found = _crossed_twice(vertices, faces, slope)
    face, points, level = _segments(vertices, faces, found, slope, derivative, q1, False)
    return LineSet(LineFamily.APPARENT, points, face, level, np.ones_like(level), feature_size**2)


def facing_only(lines: LineSet, faces: Indices, n_dot_v: Floats) -> LineSet:
    """The segments on faces that have a corner turned to the eye."""
    return lines.take(np.asarray((n_dot_v[faces[lines.face]] > 0.0).any(axis=1)))


@njit(cache=True, nogil=True, error_model="numpy")
def _bent_one_way(vertices: Floats, faces: Indices, slope: Floats, k1: Floats) -> Indices:
    """Faces with k1 of one sign and its maximum (ridge) or minimum (valley) on two sides or more."""
    found = np.empty(len(faces), dtype=np.int32)
    size = 0
    for f in range(len(faces)):
        a, b, c = k1[faces[f, 0]], k1[faces[f, 1]], k1[faces[f, 2]]
        sign = 1.0 if min(a, b, c) > 0.0 else (-1.0 if max(a, b, c) < 0.0 else 0.0)
        if sign != 0.0:
            found[size] = f
            # Storing always and counting conditionally spares a branch that can't be predicted.
            size += _sides_crossed(vertices, faces, slope, f, sign)[0] >= 2
    return found[:size].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def _crossed_twice(vertices: Floats, faces: Indices, slope: Floats) -> Indices:
    """Faces with an extremum on two sides or more."""
    found = np.empty(len(faces), dtype=np.int32)
    size = 0
    for f in range(len(faces)):
        found[size] = f
        size += _sides_crossed(vertices, faces, slope, f, 0.0)[0] >= 2
    return found[:size].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def _sides_crossed(vertices: Floats, faces: Indices, slope: Floats, f: int, sign: float) -> tuple[int, int]:
    """On how many sides of a face the derivative is 0, and a corner opposite a side where it isn't.

    With `sign` 1 (-1), only where a slope at an end of the side points along it inwards (outwards), which makes the
    zero a maximum (minimum): geometry-spec 8.4.
    """
    i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
    on_i = _crossed(vertices, slope, j, k, sign)
    on_j = _crossed(vertices, slope, k, i, sign)
    on_k = _crossed(vertices, slope, i, j, sign)
    return int(on_i) + int(on_j) + int(on_k), 0 if not on_i else (1 if not on_j else 2)


@njit(cache=True, nogil=True, error_model="numpy")
def _crossed(vertices: Floats, slope: Floats, i: int, j: int, sign: float) -> bool:
    ax, ay, az = slope[i, 0], slope[i, 1], slope[i, 2]
    bx, by, bz = slope[j, 0], slope[j, 1], slope[j, 2]
    apart = ax * bx + ay * by + az * bz <= 0.0
    if sign == 0.0 or not apart:
        return bool(apart)
    x, y, z = vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1], vertices[j, 2] - vertices[i, 2]
    return bool(sign * (ax * x + ay * y + az * z) >= 0.0 or sign * (bx * x + by * y + bz * z) <= 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _segments(
    vertices: Floats,
    faces: Indices,
    found: Indices,
    slope: Floats,
    derivative: Floats,
    curvature: Floats,
    tested: bool,
) -> tuple[Ints, Floats, Floats]:
    """The segments on faces `found`, without those of no curvature.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        found: Faces with two or three crossed sides.
        slope: (V, 3) derivative times direction.
        derivative: (V,).
        curvature: (V,).
        tested: Whether the crossed sides were tested for maxima; else each segment is, by the slopes around it.

    Returns:
        Faces (S,), points (S, 2, 3) and |curvature| (S, 2).
    """
    index = np.empty(3 * len(found), dtype=np.int64)
    points = np.empty((3 * len(found), 2, 3))
    level = np.empty((3 * len(found), 2))
    size = 0
    for f in found:
        sign = (1.0 if curvature[faces[f, 0]] > 0.0 else -1.0) if tested else 0.0
        crossed, free = _sides_crossed(vertices, faces, slope, f, sign)
        for n in range(1 if crossed == 2 else 3):
            # Sides ab and bc are joined, or side ab and the centroid.
            first = free + 2 if crossed == 2 else n + 1
            a, b, c = faces[f, first % 3], faces[f, (first + 1) % 3], faces[f, (first + 2) % 3]
            level[size, 0] = _side_point(vertices, derivative, curvature, a, b, points[size, 0])
            if crossed == 2:
                level[size, 1] = _side_point(vertices, derivative, curvature, b, c, points[size, 1])
            else:
                level[size, 1] = abs(curvature[a] + curvature[b] + curvature[c]) / 3.0
                for axis in range(3):
                    points[size, 1, axis] = (vertices[a, axis] + vertices[b, axis] + vertices[c, axis]) / 3.0
            index[size] = f
            some = level[size, 0] > 0.0 or level[size, 1] > 0.0
            size += some and (tested or _run_towards(vertices, slope, a, b, c, points[size]))
    return index[:size].copy(), points[:size].copy(), level[:size].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def _side_point(vertices: Floats, derivative: Floats, curvature: Floats, a: int, b: int, point: Floats) -> float:
    """Put the zero of the derivative from a to b in `point`; returns the curvature's absolute value there."""
    at_a, at_b = abs(derivative[a]), abs(derivative[b])
    w = at_a / (at_a + at_b) if at_a + at_b > 0.0 else 0.5
    for axis in range(3):
        point[axis] = vertices[a, axis] + w * (vertices[b, axis] - vertices[a, axis])
    return float(abs(curvature[a] + w * (curvature[b] - curvature[a])))


@njit(cache=True, nogil=True, error_model="numpy")
def _run_towards(vertices: Floats, slope: Floats, a: int, b: int, c: int, segment: Floats) -> bool:
    """Whether the slopes at a and c, on one side of a segment, and at b, on the other, point towards it."""
    ex, ey, ez = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
    fx, fy, fz = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1], vertices[c, 2] - vertices[a, 2]
    nx, ny, nz = ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx
    x, y, z = segment[0, 0] - segment[1, 0], segment[0, 1] - segment[1, 1], segment[0, 2] - segment[1, 2]
    px, py, pz = ny * z - nz * y, nz * x - nx * z, nx * y - ny * x
    at_a = slope[a, 0] * px + slope[a, 1] * py + slope[a, 2] * pz
    at_b = slope[b, 0] * px + slope[b, 1] * py + slope[b, 2] * pz
    at_c = slope[c, 0] * px + slope[c, 1] * py + slope[c, 2] * pz
    return bool(at_a > 0.0 and at_b < 0.0 and at_c > 0.0)
