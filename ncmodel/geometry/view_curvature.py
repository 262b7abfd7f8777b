"""What a surface's curvature looks like from an eye: per-vertex quantities of one view (geometry-spec 6).

Sources: DeCarlo et al. 2003 (radial curvature and its derivative), Judd et al. 2007 (view-dependent curvature).

Undefined directions read as 0: the view direction of a vertex at the eye, and the tangential view direction w of a
vertex seen exactly along its normal. |n.v| is held at `GRAZING` or above where it divides, so that q1 and its
derivative stay finite on the contour.
"""

import math

import numpy as np
from numba import njit

from ncmodel.types import Floats, Ints

GRAZING = 1e-8
"""Least |n.v| that view-dependent curvature divides by."""


@njit(cache=True, nogil=True, error_model="numpy")
def facing(vertices: Floats, normals: Floats, eye: Floats) -> Floats:
    """n.v (V,): cosine of the angle between the normal and the direction to the eye."""
    n_dot_v = np.empty(len(vertices))
    for i in range(len(vertices)):
        x, y, z = eye[0] - vertices[i, 0], eye[1] - vertices[i, 1], eye[2] - vertices[i, 2]
        length = math.sqrt(x * x + y * y + z * z)
        dot = x * normals[i, 0] + y * normals[i, 1] + z * normals[i, 2]
        n_dot_v[i] = dot / length if length > 0.0 else 0.0
    return n_dot_v


@njit(cache=True, nogil=True, error_model="numpy")
def tangential_view(vertices: Floats, normals: Floats, dir1: Floats, eye: Floats) -> Floats:
    """(2, V) u and v: the unit direction to the eye along dir1 and dir2; u^2 + v^2 = sin^2(theta)."""
    uv = np.empty((2, len(vertices)))
    for i in range(len(vertices)):
        x, y, z = eye[0] - vertices[i, 0], eye[1] - vertices[i, 1], eye[2] - vertices[i, 2]
        length = math.sqrt(x * x + y * y + z * z)
        scale = 1.0 / length if length > 0.0 else 0.0
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        dx, dy, dz = dir1[i, 0], dir1[i, 1], dir1[i, 2]
        uv[0, i] = (x * dx + y * dy + z * dz) * scale
        uv[1, i] = (x * (ny * dz - nz * dy) + y * (nz * dx - nx * dz) + z * (nx * dy - ny * dx)) * scale
    return uv


@njit(cache=True, nogil=True, error_model="numpy")
def radial_curvature(curvatures: Floats, uv: Floats) -> Floats:
    """Radial curvature times sin^2(theta), kr (V,)."""
    kr = np.empty(len(curvatures))
    for i in range(len(kr)):
        kr[i] = curvatures[i, 0] * uv[0, i] ** 2 + curvatures[i, 1] * uv[1, i] ** 2
    return kr


@njit(cache=True, nogil=True, error_model="numpy")
def radial_derivative(curvatures: Floats, derivative: Floats, uv: Floats, n_dot_v: Floats) -> Floats:
    """sin(theta) DwKr (V,): the numerator of the suggestive-contour test, no threshold taken off."""
    numerator = np.empty(len(curvatures))
    for i in range(len(numerator)):
        u, v = uv[0, i], uv[1, i]
        s2 = u * u + v * v
        inverse = 1.0 / s2 if s2 > 0.0 else 0.0
        c0, c1, c2, c3 = derivative[i, 0], derivative[i, 1], derivative[i, 2], derivative[i, 3]
        along = u * (u * (c0 * u + 3.0 * c1 * v) + 3.0 * c2 * v * v) + c3 * v * v * v
        torsion = (curvatures[i, 1] - curvatures[i, 0]) * u * v * inverse
        numerator[i] = along * inverse - 2.0 * n_dot_v[i] * torsion * torsion
    return numerator


@njit(cache=True, nogil=True, error_model="numpy")
def view_dependent_curvature(curvatures: Floats, uv: Floats, n_dot_v: Floats) -> tuple[Floats, Floats]:
    """q1 (V,), the square of the largest view-dependent curvature, and its direction t1 (V, 2) in (dir1, dir2)."""
    q1 = np.empty(len(curvatures))
    t1 = np.empty((len(curvatures), 2))
    for i in range(len(q1)):
        u, v = uv[0, i], uv[1, i]
        s2 = u * u + v * v
        nv = max(abs(n_dot_v[i]), GRAZING)
        stretch = (1.0 - nv) / (nv * s2) if s2 > 0.0 else 0.0
        k1, k2 = curvatures[i, 0], curvatures[i, 1]
        # Q = diag(k1, k2) (I + sigma w w^T)
        q11, q12 = k1 * (1.0 + stretch * u * u), k1 * stretch * u * v
        q21, q22 = k2 * stretch * u * v, k2 * (1.0 + stretch * v * v)
        m1, m2, m12 = q11 * q11 + q21 * q21, q12 * q12 + q22 * q22, q11 * q12 + q21 * q22
        half = 0.5 * (m2 - m1)
        radius = math.sqrt(half * half + m12 * m12)
        q1[i] = 0.5 * (m1 + m2) + radius
        # Of the two equal forms of the eigenvector, the one without cancellation.
        x, y = (half - radius, -m12) if half <= 0.0 else (m12, half + radius)
        length = math.sqrt(x * x + y * y)
        t1[i, 0], t1[i, 1] = (x / length, y / length) if length > 0.0 else (0.0, 1.0)
    return q1, t1


@njit(cache=True, nogil=True, error_model="numpy")
def view_dependent_derivative(
    vertices: Floats, faces: Ints, normals: Floats, dir1: Floats, q1: Floats, t1: Floats, n_dot_v: Floats
) -> Floats:
    """Dt1q1 (V,): derivative of q1 along t1.

    From each vertex the line along t1 is followed both ways to where it leaves the ring of faces; q1 there is
    interpolated on the outer edge, and the two difference quotients are averaged.
    """
    count = np.zeros(len(vertices), dtype=np.uint8)
    total = np.zeros(len(vertices))
    # One row a vertex, 64 bytes: position, T2 = N x T1, q1, unused.
    row = np.empty((len(vertices), 8))
    for i in range(len(vertices)):
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        dx, dy, dz = dir1[i, 0], dir1[i, 1], dir1[i, 2]
        a, b = t1[i, 0], t1[i, 1]
        # N x T1 = a dir2 - b dir1
        row[i, 0], row[i, 1], row[i, 2] = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        row[i, 3] = a * (ny * dz - nz * dy) - b * dx
        row[i, 4] = a * (nz * dx - nx * dz) - b * dy
        row[i, 5] = a * (nx * dy - ny * dx) - b * dz
        row[i, 6] = q1[i]
    for f in range(len(faces)):
        for c in range(3):
            i, j, k = faces[f, c], faces[f, (c + 1) % 3], faces[f, (c + 2) % 3]
            px, py, pz, sx, sy, sz = row[i, 0], row[i, 1], row[i, 2], row[i, 3], row[i, 4], row[i, 5]
            jx, jy, jz = row[j, 0] - px, row[j, 1] - py, row[j, 2] - pz
            kx, ky, kz = row[k, 0] - px, row[k, 1] - py, row[k, 2] - pz
            at_j, at_k = jx * sx + jy * sy + jz * sz, kx * sx + ky * sy + kz * sz
            crosses = (at_k >= 0.0 and at_j < 0.0) or (at_k <= 0.0 and at_j > 0.0)
            if not crosses or count[i] == 2:
                continue
            w = at_k / (at_k - at_j)
            # T1 = T2 x N
            nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
            tx, ty, tz = sy * nz - sz * ny, sz * nx - sx * nz, sx * ny - sy * nx
            x, y, z = w * jx + (1.0 - w) * kx, w * jy + (1.0 - w) * ky, w * jz + (1.0 - w) * kz
            run = x * tx + y * ty + z * tz
            if run != 0.0:
                count[i] += 1
                total[i] += (w * row[j, 6] + (1.0 - w) * row[k, 6] - row[i, 6]) / run
    for i in range(len(total)):
        total[i] /= max(abs(n_dot_v[i]), GRAZING) * max(count[i], 1)
    return total
