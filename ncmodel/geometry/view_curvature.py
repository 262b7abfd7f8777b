"""What a surface's curvature looks like from a viewpoint: per-vertex quantities of one view (docs/geometry.md 6).

Sources: DeCarlo et al. 2003 (radial curvature and its derivative), Judd et al. 2007 (view-dependent curvature).

Undefined directions read as 0: the view direction of a vertex at the eye, and the tangential view direction w of a
vertex seen exactly along its normal. |n.v| is held at `GRAZING` or above where it divides, so that q1 and its
derivative stay finite on the contour.

NumPy makes the arrays that kernels fill, those of one kernel in one piece: it asks for huge pages for pieces of 4 MB,
numba doesn't. On a million faces half of the time would go into page faults.
"""

import math

import numpy as np

from ncmodel.geometry.adjacency import Offsets
from ncmodel.geometry.normals_areas import Indices, check_columns, sides_of
from ncmodel.geometry.view_vectors import toward
from ncmodel.jit import kernel
from ncmodel.types import Floats

GRAZING = 1e-8
"""Least |n.v| that view-dependent curvature divides by."""

TINY = 1e-150
"""Lengths below this count as 0: their squares underflow."""


def facing(vertices: Floats, normals: Floats, viewpoint: Floats) -> Floats:
    """n.v (V,): cosine of the angle between the normal and the direction to the eye."""
    n_dot_v = np.empty(len(vertices))
    _face(vertices, normals, viewpoint, n_dot_v)
    return n_dot_v


@kernel
def _face(vertices: Floats, normals: Floats, viewpoint: Floats, n_dot_v: Floats) -> None:
    check_columns(vertices, 3)
    check_columns(normals, 3)
    for i in range(len(vertices)):
        x, y, z = toward(viewpoint, vertices[i, 0], vertices[i, 1], vertices[i, 2])
        dot = x * normals[i, 0] + y * normals[i, 1] + z * normals[i, 2]
        length = math.sqrt(x * x + y * y + z * z)
        n_dot_v[i] = dot / length if length > TINY else 0.0


@kernel
def facing_slope(vertices: Floats, faces: Indices, n_dot_v: Floats, viewpoint: Floats) -> Floats:
    """Derivative of n.v towards the eye (V,), in the mean over the faces around.

    Where n.v = 0 it is the radial curvature, up to the error of both, but needs no curvature: it tells which side of a
    contour is nearer to the eye.
    """
    check_columns(vertices, 3)
    check_columns(faces, 3)
    slope = np.zeros(len(vertices))
    area = np.zeros(len(vertices))
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        sides, flat = sides_of(vertices, i, j, k)
        if flat:
            continue
        ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz, _, _, _ = sides
        # normal x (sum of side times value opposite) = |normal|^2 times the gradient of the linear interpolation
        p, q, r = n_dot_v[i], n_dot_v[j], n_dot_v[k]
        x, y, z = p * ax + q * bx + r * cx, p * ay + q * by + r * cy, p * az + q * bz + r * cz
        x, y, z = ny * z - nz * y, nz * x - nx * z, nx * y - ny * x
        weight = math.sqrt(nx * nx + ny * ny + nz * nz)
        to_x, to_y, to_z = toward(viewpoint, vertices[i, 0], vertices[i, 1], vertices[i, 2])
        along = x * to_x + y * to_y + z * to_z
        for v in (i, j, k):
            slope[v] += along / weight
            area[v] += weight
    for v in range(len(slope)):
        slope[v] = slope[v] / area[v] if area[v] > 0.0 else 0.0
    return slope


def radial_curvature(
    vertices: Floats, normals: Floats, curvatures: Floats, dir1: Floats, viewpoint: Floats
) -> tuple[Floats, Floats]:
    """Radial curvature times sin^2(theta), kr (V,), and the direction to the eye along dir1 and dir2 (2, V).

    The squares of the latter, u and v, add up to sin^2(theta).
    """
    found = np.empty((3, len(vertices)))
    _bend(vertices, normals, curvatures, dir1, viewpoint, found)
    return found[0], found[1:]


@kernel
def _bend(
    vertices: Floats, normals: Floats, curvatures: Floats, dir1: Floats, viewpoint: Floats, found: Floats
) -> None:
    check_columns(vertices, 3)
    check_columns(normals, 3)
    check_columns(curvatures, 2)
    check_columns(dir1, 3)
    for i in range(len(vertices)):
        x, y, z = toward(viewpoint, vertices[i, 0], vertices[i, 1], vertices[i, 2])
        length = math.sqrt(x * x + y * y + z * z)
        scale = 1.0 / length if length > TINY else 0.0
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        dx, dy, dz = dir1[i, 0], dir1[i, 1], dir1[i, 2]
        u = (x * dx + y * dy + z * dz) * scale
        v = (x * (ny * dz - nz * dy) + y * (nz * dx - nx * dz) + z * (nx * dy - ny * dx)) * scale
        found[0, i] = curvatures[i, 0] * u * u + curvatures[i, 1] * v * v
        found[1, i], found[2, i] = u, v


def radial_derivative(curvatures: Floats, derivative: Floats, uv: Floats, n_dot_v: Floats) -> Floats:
    """sin(theta) DwKr (V,): the numerator of the suggestive-contour test, no threshold taken off."""
    numerator = np.empty(len(curvatures))
    _derive_radial(curvatures, derivative, uv, n_dot_v, numerator)
    return numerator


@kernel
def _derive_radial(curvatures: Floats, derivative: Floats, uv: Floats, n_dot_v: Floats, numerator: Floats) -> None:
    check_columns(curvatures, 2)
    check_columns(derivative, 4)
    for i in range(len(numerator)):
        u, v = uv[0, i], uv[1, i]
        s2 = u * u + v * v
        inverse = 1.0 / s2 if s2 > TINY else 0.0
        c0, c1, c2, c3 = derivative[i, 0], derivative[i, 1], derivative[i, 2], derivative[i, 3]
        along = u * (u * (c0 * u + 3.0 * c1 * v) + 3.0 * c2 * v * v) + c3 * v * v * v
        torsion = (curvatures[i, 1] - curvatures[i, 0]) * (u * v * inverse)
        numerator[i] = along * inverse - 2.0 * n_dot_v[i] * torsion * torsion


def view_dependent_curvature(curvatures: Floats, uv: Floats, n_dot_v: Floats) -> tuple[Floats, Floats]:
    """q1 (V,), the square of the largest view-dependent curvature, and its direction t1 (2, V) along dir1 and dir2."""
    found = np.empty((3, len(curvatures)))
    _bend_in_view(curvatures, uv, n_dot_v, found)
    return found[0], found[1:]


@kernel
def _bend_in_view(curvatures: Floats, uv: Floats, n_dot_v: Floats, found: Floats) -> None:
    check_columns(curvatures, 2)
    for i in range(len(curvatures)):
        u, v = uv[0, i], uv[1, i]
        nv = max(abs(n_dot_v[i]), GRAZING)
        s2 = u * u + v * v
        stretch = (1.0 - nv) / (nv * s2) if s2 > TINY else 0.0
        uu, mixed, vv = stretch * u * u, stretch * u * v, stretch * v * v
        # Q = diag(k1, k2) (I + sigma w w^T), M = Q^T Q
        k1, k2 = curvatures[i, 0], curvatures[i, 1]
        q11, q12, q21, q22 = k1 * (1.0 + uu), k1 * mixed, k2 * mixed, k2 * (1.0 + vv)
        m1, m2, m12 = q11 * q11 + q21 * q21, q12 * q12 + q22 * q22, q11 * q12 + q21 * q22
        half = 0.5 * (m2 - m1)
        radius = math.sqrt(half * half + m12 * m12)
        found[0, i] = 0.5 * (m1 + m2) + radius
        # Of two equal forms of the eigenvector, the one without cancellation; (0, 1) where every direction is one.
        x = half - radius if half < 0.0 else m12
        y = -m12 if half < 0.0 else half + radius
        length = math.sqrt(x * x + y * y)
        found[1, i] = x / length if length > TINY else 0.0
        found[2, i] = y / length if length > TINY else 1.0


def view_dependent_derivative(
    vertices: Floats,
    normals: Floats,
    dir1: Floats,
    q1: Floats,
    t1: Floats,
    n_dot_v: Floats,
    starts: Offsets,
    around: Indices,
) -> tuple[Floats, Floats]:
    """Dt1q1 (V,), the derivative of q1 along t1, and T1 (V, 3), which is t1 in object space.

    From each vertex the line along t1 is followed both ways to where it leaves the ring of faces; q1 there is
    interpolated on the outer side, and the two difference quotients are averaged.

    Args:
        vertices: (V, 3).
        normals: (V, 3).
        dir1: (V, 3).
        q1: (V,).
        t1: (2, V).
        n_dot_v: (V,).
        starts: (V + 1,) of `Rings`.
        around: (3 F, 2) of `Rings`.
    """
    found = np.empty(4 * len(vertices))
    derivative, direction = found[: len(vertices)], found[len(vertices) :].reshape(-1, 3)
    _derive_in_view(vertices, normals, dir1, q1, t1, n_dot_v, starts, around, derivative, direction)
    return derivative, direction


@kernel
def _derive_in_view(
    vertices: Floats,
    normals: Floats,
    dir1: Floats,
    q1: Floats,
    t1: Floats,
    n_dot_v: Floats,
    starts: Offsets,
    around: Indices,
    derivative: Floats,
    direction: Floats,
) -> None:
    check_columns(vertices, 3)
    check_columns(normals, 3)
    check_columns(dir1, 3)
    check_columns(around, 2)
    check_columns(direction, 3)
    for i in range(len(vertices)):
        px, py, pz = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        dx, dy, dz = dir1[i, 0], dir1[i, 1], dir1[i, 2]
        a, b = t1[0, i], t1[1, i]
        # T1 = a dir1 + b dir2 and T2 = N x T1
        ex, ey, ez = ny * dz - nz * dy, nz * dx - nx * dz, nx * dy - ny * dx
        tx, ty, tz = a * dx + b * ex, a * dy + b * ey, a * dz + b * ez
        sx, sy, sz = a * ex - b * dx, a * ey - b * dy, a * ez - b * dz
        count, total = 0, 0.0
        for n in range(starts[i], starts[i + 1]):
            j, k = around[n, 0], around[n, 1]
            jx, jy, jz = vertices[j, 0] - px, vertices[j, 1] - py, vertices[j, 2] - pz
            kx, ky, kz = vertices[k, 0] - px, vertices[k, 1] - py, vertices[k, 2] - pz
            at_j, at_k = jx * sx + jy * sy + jz * sz, kx * sx + ky * sy + kz * sz
            # One branch that can be mispredicted instead of four.
            if not (((at_k >= 0.0) & (at_j < 0.0)) | ((at_k <= 0.0) & (at_j > 0.0))):
                continue
            w = at_k / (at_k - at_j)
            x, y, z = kx + w * (jx - kx), ky + w * (jy - ky), kz + w * (jz - kz)
            run = x * tx + y * ty + z * tz
            if run != 0.0:
                total += (q1[k] + w * (q1[j] - q1[k]) - q1[i]) / run
                count += 1
                if count == 2:
                    break
        derivative[i] = total / (max(abs(n_dot_v[i]), GRAZING) * max(count, 1))
        direction[i, 0], direction[i, 1], direction[i, 2] = tx, ty, tz
