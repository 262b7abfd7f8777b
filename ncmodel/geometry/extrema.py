"""Lines where a curvature is extremal along its own direction: ridges, valleys, apparent ridges (geometry-spec 8, 9).

Sources: Ohtake et al. 2004 (ridges and valleys on meshes), Judd et al. 2007 (apparent ridges).

All three are zero crossings of a derivative E of a curvature K along its direction T. The tangent vectors E T at a
face's corners don't depend on the sign of T; where two of them point apart, E changes sign on the edge between.
Three crossings make three segments that meet in the centroid.
"""

import numpy as np
from numba import njit

from ncmodel.types import Floats, Ints, LineFamily, LineSet


def ridges(
    vertices: Floats, faces: Ints, k1: Floats, dir1: Floats, derivative: Floats, feature_size: float, convex: bool
) -> LineSet:
    """Ridges (`convex`) or valleys from every side, back faces included.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        k1: (V,) curvature of largest absolute value, convex positive.
        dir1: (V, 3) its direction.
        derivative: (V,) of k1 along dir1.
        feature_size: Makes the strength dimensionless.
        convex: Ridges, else valleys.
    """
    sign = 1.0 if convex else -1.0
    index, points, strength = _ridge_segments(vertices, faces, k1, dir1, derivative, sign)
    family = LineFamily.RIDGES if convex else LineFamily.VALLEYS
    return LineSet(family, points, index, strength, np.ones_like(strength), feature_size)


def apparent_ridges(
    vertices: Floats, faces: Ints, q1: Floats, direction: Floats, derivative: Floats, feature_size: float
) -> LineSet:
    """Maxima of view-dependent curvature along its direction.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        q1: (V,) squared view-dependent curvature.
        direction: (V, 3) T1, its direction in space.
        derivative: (V,) of q1 along T1.
        feature_size: Makes the strength dimensionless.
    """
    index, points, strength = _apparent_segments(vertices, faces, q1, direction, derivative)
    return LineSet(LineFamily.APPARENT, points, index, strength, np.ones_like(strength), feature_size**2)


def facing_only(lines: LineSet, faces: Ints, n_dot_v: Floats) -> LineSet:
    """The segments on faces that have a corner turned to the eye."""
    return lines.take(np.asarray((n_dot_v[faces[lines.face]] > 0.0).any(axis=1)))


@njit(cache=True, nogil=True, error_model="numpy")
def _ridge_segments(
    vertices: Floats, faces: Ints, k1: Floats, dir1: Floats, derivative: Floats, sign: float
) -> tuple[Ints, Floats, Floats]:
    """Faces (S,), points (S, 2, 3) and |k1| (S, 2) of ridges (`sign` 1) or valleys (-1)."""
    slope = _slopes(dir1, sign * derivative)
    found = np.empty(len(faces), dtype=np.int64)
    size = 0
    for f in range(len(faces)):
        found[size] = f
        # Storing always and counting conditionally keeps the loop free of branches that can't be predicted.
        size += min(sign * k1[faces[f, 0]], sign * k1[faces[f, 1]], sign * k1[faces[f, 2]]) > 0.0
    kept = 0
    for n in range(size):
        f = found[n]
        found[kept] = f
        kept += _sides_crossed(vertices, faces, slope, f, True)[0] >= 2
    return _segments(vertices, faces, found[:kept], slope, derivative, k1, True)


@njit(cache=True, nogil=True, error_model="numpy")
def _apparent_segments(
    vertices: Floats, faces: Ints, q1: Floats, direction: Floats, derivative: Floats
) -> tuple[Ints, Floats, Floats]:
    """Faces (S,), points (S, 2, 3) and q1 (S, 2) of apparent ridges."""
    slope = _slopes(direction, derivative)
    found = np.empty(len(faces), dtype=np.int64)
    size = 0
    for f in range(len(faces)):
        found[size] = f
        size += _sides_crossed(vertices, faces, slope, f, False)[0] >= 2
    return _segments(vertices, faces, found[:size], slope, derivative, q1, False)


@njit(cache=True, nogil=True, error_model="numpy")
def _slopes(direction: Floats, derivative: Floats) -> Floats:
    """(V, 3) direction times derivative: points uphill, whatever the direction's sign."""
    slope = np.empty(direction.shape)
    for v in range(len(slope)):
        for axis in range(3):
            slope[v, axis] = derivative[v] * direction[v, axis]
    return slope


@njit(cache=True, nogil=True, error_model="numpy")
def _sides_crossed(vertices: Floats, faces: Ints, slope: Floats, f: int, maxima: bool) -> tuple[int, int]:
    """On how many sides of a face the derivative changes sign, and a corner opposite a side where it doesn't.

    With `maxima`, sides count only where a slope at one of their ends points inwards (geometry-spec 8.4).
    """
    i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
    on_i = _crossed(vertices, slope, j, k, maxima)
    on_j = _crossed(vertices, slope, k, i, maxima)
    on_k = _crossed(vertices, slope, i, j, maxima)
    return int(on_i) + int(on_j) + int(on_k), 0 if not on_i else (1 if not on_j else 2)


@njit(cache=True, nogil=True, error_model="numpy")
def _crossed(vertices: Floats, slope: Floats, i: int, j: int, maxima: bool) -> bool:
    """Whether the slopes at the ends of a side point apart and, with `maxima`, one of them along the side inwards."""
    ax, ay, az = slope[i, 0], slope[i, 1], slope[i, 2]
    bx, by, bz = slope[j, 0], slope[j, 1], slope[j, 2]
    if ax * bx + ay * by + az * bz > 0.0:
        return False
    if not maxima:
        return True
    x, y, z = vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1], vertices[j, 2] - vertices[i, 2]
    return bool(ax * x + ay * y + az * z >= 0.0 or bx * x + by * y + bz * z <= 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _segments(
    vertices: Floats, faces: Ints, found: Ints, slope: Floats, derivative: Floats, curvature: Floats, maxima: bool
) -> tuple[Ints, Floats, Floats]:
    """The segments of faces with two or three crossed sides.

    Only maxima are kept: with `maxima` each side was tested for it, without each segment is.
    """
    index = np.empty(3 * len(found), dtype=np.int64)
    points = np.empty((3 * len(found), 2, 3))
    levels = np.empty((3 * len(found), 2))
    size = 0
    for f in found:
        crossed, free = _sides_crossed(vertices, faces, slope, f, maxima)
        for n in range(1 if crossed == 2 else 3):
            # Sides ab and bc are joined, or side ab and the centroid.
            first = free + 2 if crossed == 2 else n + 1
            a, b, c = faces[f, first % 3], faces[f, (first + 1) % 3], faces[f, (first + 2) % 3]
            levels[size, 0] = _side_point(vertices, derivative, curvature, a, b, points[size, 0])
            if crossed == 2:
                levels[size, 1] = _side_point(vertices, derivative, curvature, b, c, points[size, 1])
            else:
                levels[size, 1] = abs(curvature[a] + curvature[b] + curvature[c]) / 3.0
                for axis in range(3):
                    points[size, 1, axis] = (vertices[a, axis] + vertices[b, axis] + vertices[c, axis]) / 3.0
            if not maxima and not _runs_towards(vertices, slope, a, b, c, points[size]):
                continue
            index[size] = f
            size += levels[size, 0] > 0.0 or levels[size, 1] > 0.0
    return index[:size].copy(), points[:size].copy(), levels[:size].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def _side_point(vertices: Floats, derivative: Floats, curvature: Floats, a: int, b: int, point: Floats) -> float:
    """Put the zero of |derivative| from a to b in `point`; returns the curvature's absolute value there."""
    at_a, at_b = abs(derivative[a]), abs(derivative[b])
    w = at_a / (at_a + at_b) if at_a + at_b > 0.0 else 0.5
    for axis in range(3):
        point[axis] = vertices[a, axis] + w * (vertices[b, axis] - vertices[a, axis])
    return float(abs(curvature[a] + w * (curvature[b] - curvature[a])))


@njit(cache=True, nogil=True, error_model="numpy")
def _runs_towards(vertices: Floats, slope: Floats, a: int, b: int, c: int, segment: Floats) -> bool:
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
