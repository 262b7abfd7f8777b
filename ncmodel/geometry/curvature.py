"""Curvature and its derivative on a triangle mesh (docs/geometry.md 3, 4; Rusinkiewicz 2004).

In each face the shape operator II is the least-squares fit of II e_j = d_j to the changes d_j of the normal along the
sides e_j, and the derivative C the fit of C e_j = change of II. In the principal frame (t, b) of the sides' scatter
S = sum e_j e_j^T both normal equations are diagonal, so they are solved by division; and det S = 3 |e0 x e1|^2 keeps
the smaller eigenvalue exact in the thinnest face. The fits are turned into the planes of the corners' normals and
averaged there, weighted with the corners' areas.

What no proper face defines is 0, never NaN.
"""

import math

import numpy as np

from ncmodel.geometry.normals_areas import Indices, Sides, check_columns, corner_areas, sides_of
from ncmodel.jit import kernel
from ncmodel.types import Floats

Frame = tuple[float, ...]
"""Axes t, b, n of a face (9), its sides (u, v) along t and b (6), and sums of u^2 and of v^2 (2)."""

ROUNDING = 1e-14
"""Changes of a unit normal below this are rounding: a plane is flat however it lies."""

OPPOSITE = 1e-14
"""1 + cosine below which two normals count as opposite: there is no least rotation between them."""


@kernel
def curvature_tensor(vertices: Floats, faces: Indices, normals: Floats, areas: Floats) -> tuple[Floats, Floats]:
    """Principal curvatures (V, 2) and the first principal direction (V, 3); convex is positive, |k1| >= |k2|.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        normals: (V, 3) unit normals.
        areas: (V,) point areas.
    """
    check_columns(vertices, 3)
    check_columns(faces, 3)
    check_columns(normals, 3)
    tensor = np.zeros((len(vertices), 3))
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        sides, flat = sides_of(vertices, i, j, k)
        if flat:
            continue
        frame = _frame(sides)
        at_i, at_j, at_k = corner_areas(sides, flat)
        ai, ci = _along(frame, normals, i)
        aj, cj = _along(frame, normals, j)
        ak, ck = _along(frame, normals, k)
        e, m, g = _fit_operator(frame, ai, aj, ak, ci, cj, ck)
        _add_operator(tensor, i, at_i, frame, normals, e, m, g)
        _add_operator(tensor, j, at_j, frame, normals, e, m, g)
        _add_operator(tensor, k, at_k, frame, normals, e, m, g)
    curvatures = np.zeros((len(vertices), 2))
    dir1 = np.zeros((len(vertices), 3))
    for v in range(len(vertices)):
        _diagonalise(tensor, v, areas, normals, curvatures, dir1)
    return curvatures, dir1


@kernel
def curvature_derivative(
    vertices: Floats, faces: Indices, normals: Floats, areas: Floats, curvatures: Floats, dir1: Floats
) -> Floats:
    """Derivative of curvature (V, 4): the cubic form's C111, C112, C122, C222 along (dir1, dir2).

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        normals: (V, 3) unit normals.
        areas: (V,) point areas.
        curvatures: (V, 2) k1 and k2 from `curvature_tensor`.
        dir1: (V, 3) from `curvature_tensor`.
    """
    check_columns(vertices, 3)
    check_columns(faces, 3)
    check_columns(normals, 3)
    check_columns(curvatures, 2)
    check_columns(dir1, 3)
    derivative = np.zeros((len(vertices), 4))
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        sides, flat = sides_of(vertices, i, j, k)
        if flat:
            continue
        frame = _frame(sides)
        at_i, at_j, at_k = corner_areas(sides, flat)
        xi, yi, mi = _turned(frame, normals, i, dir1[i, 0], dir1[i, 1], dir1[i, 2])
        xj, yj, mj = _turned(frame, normals, j, dir1[j, 0], dir1[j, 1], dir1[j, 2])
        xk, yk, mk = _turned(frame, normals, k, dir1[k, 0], dir1[k, 1], dir1[k, 2])
        cubic = _fit_cubic(
            frame,
            _in_frame(curvatures[i, 0], curvatures[i, 1], xi, yi),
            _in_frame(curvatures[j, 0], curvatures[j, 1], xj, yj),
            _in_frame(curvatures[k, 0], curvatures[k, 1], xk, yk),
        )
        _add_cubic(derivative, i, at_i, cubic, xi, yi, mi)
        _add_cubic(derivative, j, at_j, cubic, xj, yj, mj)
        _add_cubic(derivative, k, at_k, cubic, xk, yk, mk)
    for v in range(len(derivative)):
        for c in range(4):
            derivative[v, c] = derivative[v, c] / areas[v] if areas[v] > 0.0 else 0.0
    return derivative


@kernel
def _frame(sides: Sides) -> Frame:
    """The principal frame of a proper face's sides: sum u v = 0, sum u^2 >= sum v^2."""
    ax, ay, az, bx, by, bz, _, _, _, nx, ny, nz, li, lj, lk = sides
    square = nx * nx + ny * ny + nz * nz
    length, side = math.sqrt(square), math.sqrt(li)
    nx, ny, nz = nx / length, ny / length, nz / length
    px, py, pz = ax / side, ay / side, az / side
    qx, qy, qz = ny * pz - nz * py, nz * px - nx * pz, nx * py - ny * px
    # In (p, q): e0 = (side, 0), e1 = (x, y), e2 = -(e0 + e1).
    x, y = bx * px + by * py + bz * pz, length / side
    difference = 0.5 * (li + x * x + (side + x) * (side + x)) - y * y
    mixed = (2.0 * x + side) * y
    radius = math.sqrt(difference * difference + mixed * mixed)
    uu = 0.5 * (li + lj + lk) + radius
    vv = 3.0 * square / uu
    c, s = _half_angle(difference, mixed, radius)
    tx, ty, tz = c * px + s * qx, c * py + s * qy, c * pz + s * qz
    bx, by, bz = c * qx - s * px, c * qy - s * py, c * qz - s * pz
    ui, vi = c * side, -s * side
    uj, vj = c * x + s * y, c * y - s * x
    return tx, ty, tz, bx, by, bz, nx, ny, nz, ui, vi, uj, vj, -ui - uj, -vi - vj, uu, vv


@kernel
def _half_angle(x: float, y: float, radius: float) -> tuple[float, float]:
    """Cosine and sine of half the angle of (x, y), whose length is `radius`."""
    if radius <= 0.0:
        return 1.0, 0.0
    if x >= 0.0:
        c = math.sqrt(0.5 * (1.0 + x / radius))
        return c, 0.5 * y / (radius * c)
    s = math.copysign(math.sqrt(0.5 * (1.0 - x / radius)), y)
    return 0.5 * y / (radius * s), s


@kernel
def _along(frame: Frame, vectors: Floats, v: int) -> tuple[float, float]:
    """Components of a vertex's vector along a face's t and b."""
    tx, ty, tz, bx, by, bz = frame[0], frame[1], frame[2], frame[3], frame[4], frame[5]
    x, y, z = vectors[v, 0], vectors[v, 1], vectors[v, 2]
    return x * tx + y * ty + z * tz, x * bx + y * by + z * bz


@kernel
def _fit_operator(
    frame: Frame, ai: float, aj: float, ak: float, ci: float, cj: float, ck: float
) -> tuple[float, float, float]:
    """The shape operator's uu, uv, vv in a face, from the (t, b) components (a, c) of the normals at its corners."""
    ui, vi, uj, vj, uk, vk = frame[9], frame[10], frame[11], frame[12], frame[13], frame[14]
    uu, vv = frame[15], frame[16]
    # Along side i, from corner j to corner k, the normal changes by k's minus j's.
    di, dj, dk = ak - aj, ai - ak, aj - ai
    gi, gj, gk = ck - cj, ci - ck, cj - ci
    if max(abs(di), abs(dj), abs(dk), abs(gi), abs(gj), abs(gk)) < ROUNDING:
        return 0.0, 0.0, 0.0
    mixed = di * vi + dj * vj + dk * vk + gi * ui + gj * uj + gk * uk
    return (di * ui + dj * uj + dk * uk) / uu, mixed / (uu + vv), (gi * vi + gj * vj + gk * vk) / vv


@kernel
def _fit_cubic(
    frame: Frame,
    at_i: tuple[float, float, float],
    at_j: tuple[float, float, float],
    at_k: tuple[float, float, float],
) -> tuple[float, float, float, float]:
    """The derivative's C_uuu, C_uuv, C_uvv, C_vvv in a face, from the tensors (p, q, r) at its corners."""
    ui, vi, uj, vj, uk, vk = frame[9], frame[10], frame[11], frame[12], frame[13], frame[14]
    uu, vv = frame[15], frame[16]
    pi, pj, pk = at_k[0] - at_j[0], at_i[0] - at_k[0], at_j[0] - at_i[0]
    qi, qj, qk = at_k[1] - at_j[1], at_i[1] - at_k[1], at_j[1] - at_i[1]
    ri, rj, rk = at_k[2] - at_j[2], at_i[2] - at_k[2], at_j[2] - at_i[2]
    # q occurs twice in the tensor, hence the weights 2.
    first = vi * pi + vj * pj + vk * pk + 2.0 * (ui * qi + uj * qj + uk * qk)
    second = ui * ri + uj * rj + uk * rk + 2.0 * (vi * qi + vj * qj + vk * qk)
    return (
        (ui * pi + uj * pj + uk * pk) / uu,
        first / (2.0 * uu + vv),
        second / (uu + 2.0 * vv),
        (vi * ri + vj * rj + vk * rk) / vv,
    )


@kernel
def _any_tangent(x: float, y: float, z: float) -> tuple[float, float, float]:
    """A unit vector across the unit vector (x, y, z), continuous but at z = 0 (Duff et al. 2017)."""
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    return 1.0 + sign * x * x * a, sign * x * y * a, -sign * x


@kernel
def _turned(frame: Frame, normals: Floats, v: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """(t, b) components (a, b) of a vertex's tangent vector, turned by the least rotation into the plane of a face.

    The vertex's other axis, normal x (x, y, z), turns into mirror * (-b, a), mirror being the third value: 1, but -1
    where the normals are opposite, and the rotation, being undefined, is replaced by negation.
    """
    tx, ty, tz, bx, by, bz = frame[0], frame[1], frame[2], frame[3], frame[4], frame[5]
    nx, ny, nz = frame[6], frame[7], frame[8]
    ox, oy, oz = normals[v, 0], normals[v, 1], normals[v, 2]
    towards = 1.0 + (ox * nx + oy * ny + oz * nz)
    a, b = x * tx + y * ty + z * tz, x * bx + y * by + z * bz
    if towards <= OPPOSITE:
        return -a, -b, -1.0
    across = (x * nx + y * ny + z * nz) / towards
    return a - (ox * tx + oy * ty + oz * tz) * across, b - (ox * bx + oy * by + oz * bz) * across, 1.0


@kernel
def _in_frame(k1: float, k2: float, a: float, b: float) -> tuple[float, float, float]:
    """The tensor diag(k1, k2) of axes (a, b), (-b, a), as uu, uv, vv."""
    return k1 * a * a + k2 * b * b, (k1 - k2) * a * b, k1 * b * b + k2 * a * a


@kernel
def _add_operator(
    tensor: Floats, v: int, weight: float, frame: Frame, normals: Floats, e: float, m: float, g: float
) -> None:
    """Add a face's shape operator to a vertex's sum, in the vertex's `_any_tangent` axes."""
    x, y, z = _any_tangent(normals[v, 0], normals[v, 1], normals[v, 2])
    a, b, mirror = _turned(frame, normals, v, x, y, z)
    tensor[v, 0] += weight * (e * a * a + 2.0 * m * a * b + g * b * b)
    tensor[v, 1] += weight * mirror * (m * (a * a - b * b) + (g - e) * a * b)
    tensor[v, 2] += weight * (e * b * b - 2.0 * m * a * b + g * a * a)


@kernel
def _add_cubic(
    derivative: Floats,
    v: int,
    weight: float,
    cubic: tuple[float, float, float, float],
    a: float,
    b: float,
    mirror: float,
) -> None:
    """Add a face's cubic form to a vertex's sum: its values on the vertex's axes (a, b) and mirror * (-b, a)."""
    c0, c1, c2, c3 = cubic
    aaa, aab, abb, bbb = a * a * a, a * a * b, a * b * b, b * b * b
    derivative[v, 0] += weight * (c0 * aaa + 3.0 * (c1 * aab + c2 * abb) + c3 * bbb)
    derivative[v, 1] += weight * mirror * (c1 * aaa + (2.0 * c2 - c0) * aab + (c3 - 2.0 * c1) * abb - c2 * bbb)
    derivative[v, 2] += weight * (c2 * aaa + (c3 - 2.0 * c1) * aab + (c0 - 2.0 * c2) * abb + c1 * bbb)
    derivative[v, 3] += weight * mirror * (c3 * aaa - 3.0 * (c2 * aab - c1 * abb) - c0 * bbb)


@kernel
def _diagonalise(tensor: Floats, v: int, areas: Floats, normals: Floats, curvatures: Floats, dir1: Floats) -> None:
    """Principal curvatures and first direction of a vertex from its sum, by one Jacobi rotation."""
    weight = 1.0 / areas[v] if areas[v] > 0.0 else 0.0
    uu, uv, vv = tensor[v, 0] * weight, tensor[v, 1] * weight, tensor[v, 2] * weight
    c, s, tangent = 1.0, 0.0, 0.0
    if uv != 0.0:
        h = 0.5 * (vv - uu) / uv
        tangent = 1.0 / (h + math.copysign(math.sqrt(1.0 + h * h), h))
        c = 1.0 / math.sqrt(1.0 + tangent * tangent)
        s = tangent * c
    k1, k2 = uu - tangent * uv, vv + tangent * uv
    if abs(k1) < abs(k2):
        k1, k2, c, s = k2, k1, s, -c
    nx, ny, nz = normals[v, 0], normals[v, 1], normals[v, 2]
    xx, xy, xz = _any_tangent(nx, ny, nz)
    yx, yy, yz = ny * xz - nz * xy, nz * xx - nx * xz, nx * xy - ny * xx
    curvatures[v, 0], curvatures[v, 1] = k1, k2
    dir1[v, 0], dir1[v, 1], dir1[v, 2] = c * xx - s * yx, c * xy - s * yy, c * xz - s * yz
