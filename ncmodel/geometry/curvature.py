"""Vertex normals, areas, curvature and its derivative on a triangle mesh (geometry-spec 1-4).

Sources: Max 1999 (normals), Meyer et al. 2003 (areas), Rusinkiewicz 2004 (curvature and its derivative).

In each face the shape operator II is the least-squares fit of II e_j = d_j to the changes d_j of the normal along the
edges e_j, and the derivative C the fit of C e_j = change of II. In the principal frame (t, b) of the edges' scatter
S = sum e_j e_j^T both normal equations are diagonal, so they are solved by division; and det S = 3 |e0 x e1|^2 keeps
the smaller eigenvalue exact in the thinnest face.

A face whose height is below `FLATNESS` of its longest side has no direction that rounding leaves meaningful: it takes
no part. Whatever no face defines is 0 (curvature, areas), never NaN.
"""

import math

import numpy as np
from numba import njit

from ncmodel.types import Floats, Ints

FLATNESS = 1e-10
"""Height of a face, relative to its longest side, below which it counts as degenerate."""

TINY_SQUARE = 1e-60
"""Squared longest side below which a face counts as a point: keeps powers of lengths off the denormal range."""

# The layout of what `_face` returns.
_Face = tuple[float, ...]


@njit(cache=True, nogil=True, error_model="numpy")
def vertex_normals(vertices: Floats, faces: Ints) -> Floats:
    """Unit vertex normals (V, 3), weighted per corner by sin(angle) / product of the two edges' lengths (Max 1999).

    Where the faces' normals cancel, the normal is that of the first face; where there is no face, it is +y.
    """
    normals = np.zeros_like(vertices)
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        nx, ny, nz, li, lj, lk, flat = area_vector(vertices, i, j, k)
        if flat:
            continue
        # The cross products at the three corners are one vector; only the lengths differ.
        share = 1.0 / (li * lj * lk)
        for corner, weight in ((i, li * share), (j, lj * share), (k, lk * share)):
            normals[corner, 0] += weight * nx
            normals[corner, 1] += weight * ny
            normals[corner, 2] += weight * nz
    undefined = 0
    for v in range(len(normals)):
        x, y, z = normals[v, 0], normals[v, 1], normals[v, 2]
        length = math.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            normals[v, 0], normals[v, 1], normals[v, 2] = x / length, y / length, z / length
        else:
            undefined += 1
    if undefined:
        _fill_undefined(vertices, faces, normals)
    return normals


@njit(cache=True, nogil=True, error_model="numpy")
def point_areas(vertices: Floats, faces: Ints) -> Floats:
    """Area that belongs to each vertex (V,): its Voronoi cell, clipped to each face."""
    areas = np.zeros(len(vertices))
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        ci, cj, ck = _corner_areas(vertices, i, j, k)
        areas[i] += ci
        areas[j] += cj
        areas[k] += ck
    return areas


@njit(cache=True, nogil=True, error_model="numpy")
def curvature_tensor(vertices: Floats, faces: Ints, normals: Floats, areas: Floats) -> tuple[Floats, Floats]:
    """Principal curvatures (V, 2) and the first principal direction (V, 3); convex is positive, |k1| >= |k2|.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        normals: (V, 3) from `vertex_normals`.
        areas: (V,) from `point_areas`.
    """
    tensor = np.zeros((len(vertices), 3))
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        face, flat = _face(vertices, i, j, k)
        if flat:
            continue
        tx, ty, tz, bx, by, bz, _, _, _, ui, vi, uj, vj, uk, vk, su, sv = face
        nix, niy, niz = normals[i, 0], normals[i, 1], normals[i, 2]
        njx, njy, njz = normals[j, 0], normals[j, 1], normals[j, 2]
        nkx, nky, nkz = normals[k, 0], normals[k, 1], normals[k, 2]
        # Components (a, c) of the corner normals; along edge i, from j to k, the normal changes by k's minus j's.
        ai, ci = nix * tx + niy * ty + niz * tz, nix * bx + niy * by + niz * bz
        aj, cj = njx * tx + njy * ty + njz * tz, njx * bx + njy * by + njz * bz
        ak, ck = nkx * tx + nky * ty + nkz * tz, nkx * bx + nky * by + nkz * bz
        di, dj, dk = ak - aj, ai - ak, aj - ai
        gi, gj, gk = ck - cj, ci - ck, cj - ci
        e = (di * ui + dj * uj + dk * uk) / su
        g = (gi * vi + gj * vj + gk * vk) / sv
        m = di * vi + dj * vj + dk * vk + gi * ui + gj * uj + gk * uk
        m /= su + sv
        wi, wj, wk = _corner_areas(vertices, i, j, k)
        for corner, weight in ((i, wi), (j, wj), (k, wk)):
            xx, xy, xz = _any_tangent(normals[corner, 0], normals[corner, 1], normals[corner, 2])
            a, b, mirror = _turned_into(face, normals, corner, xx, xy, xz)
            tensor[corner, 0] += weight * (e * a * a + 2.0 * m * a * b + g * b * b)
            tensor[corner, 1] += weight * mirror * (m * (a * a - b * b) + (g - e) * a * b)
            tensor[corner, 2] += weight * (e * b * b - 2.0 * m * a * b + g * a * a)
    return _principal(tensor, normals, areas)


@njit(cache=True, nogil=True, error_model="numpy")
def curvature_derivative(
    vertices: Floats, faces: Ints, normals: Floats, areas: Floats, curvatures: Floats, dir1: Floats
) -> Floats:
    """Derivative of curvature (V, 4): the cubic form's C111, C112, C122, C222 along (dir1, dir2).

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        normals: (V, 3) from `vertex_normals`.
        areas: (V,) from `point_areas`.
        curvatures: (V, 2) k1 and k2 from `curvature_tensor`.
        dir1: (V, 3) from `curvature_tensor`.
    """
    derivative = np.zeros((len(vertices), 4))
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        face, flat = _face(vertices, i, j, k)
        if flat:
            continue
        _, _, _, _, _, _, _, _, _, ui, vi, uj, vj, uk, vk, su, sv = face
        xi, yi, mi = _turned_into(face, normals, i, dir1[i, 0], dir1[i, 1], dir1[i, 2])
        xj, yj, mj = _turned_into(face, normals, j, dir1[j, 0], dir1[j, 1], dir1[j, 2])
        xk, yk, mk = _turned_into(face, normals, k, dir1[k, 0], dir1[k, 1], dir1[k, 2])
        pi, qi, ri = _in_face(curvatures[i, 0], curvatures[i, 1], xi, yi)
        pj, qj, rj = _in_face(curvatures[j, 0], curvatures[j, 1], xj, yj)
        pk, qk, rk = _in_face(curvatures[k, 0], curvatures[k, 1], xk, yk)
        dpi, dpj, dpk = pk - pj, pi - pk, pj - pi
        dqi, dqj, dqk = qk - qj, qi - qk, qj - qi
        dri, drj, drk = rk - rj, ri - rk, rj - ri
        # q occurs twice in the tensor, hence the weights 2.
        c0 = (ui * dpi + uj * dpj + uk * dpk) / su
        c1 = vi * dpi + vj * dpj + vk * dpk + 2.0 * (ui * dqi + uj * dqj + uk * dqk)
        c2 = ui * dri + uj * drj + uk * drk + 2.0 * (vi * dqi + vj * dqj + vk * dqk)
        c3 = (vi * dri + vj * drj + vk * drk) / sv
        c1 /= 2.0 * su + sv
        c2 /= su + 2.0 * sv
        wi, wj, wk = _corner_areas(vertices, i, j, k)
        for corner, weight, a, b, mirror in ((i, wi, xi, yi, mi), (j, wj, xj, yj, mj), (k, wk, xk, yk, mk)):
            aa, ab, bb = a * a, a * b, b * b
            derivative[corner, 0] += weight * (c0 * a * aa + 3.0 * (c1 * a * ab + c2 * a * bb) + c3 * b * bb)
            derivative[corner, 1] += (
                weight * mirror * (a * (c1 * aa + (2.0 * c2 - c0) * ab + (c3 - 2.0 * c1) * bb) - c2 * b * bb)
            )
            derivative[corner, 2] += weight * (
                c2 * a * aa + (c3 - 2.0 * c1) * a * ab + (c0 - 2.0 * c2) * a * bb + c1 * b * bb
            )
            derivative[corner, 3] += weight * mirror * (c3 * a * aa - 3.0 * (c2 * a * ab - c1 * a * bb) - c0 * b * bb)
    for v in range(len(derivative)):
        for c in range(4):
            derivative[v, c] = derivative[v, c] / areas[v] if areas[v] > 0.0 else 0.0
    return derivative


@njit(cache=True, nogil=True, error_model="numpy")
def area_vector(vertices: Floats, i: int, j: int, k: int) -> tuple[float, float, float, float, float, float, bool]:
    """e0 x e1 of a face, its squared side lengths, and whether it is degenerate."""
    ax, ay, az = vertices[k, 0] - vertices[j, 0], vertices[k, 1] - vertices[j, 1], vertices[k, 2] - vertices[j, 2]
    bx, by, bz = vertices[i, 0] - vertices[k, 0], vertices[i, 1] - vertices[k, 1], vertices[i, 2] - vertices[k, 2]
    cx, cy, cz = vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1], vertices[j, 2] - vertices[i, 2]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    li, lj, lk = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz, cx * cx + cy * cy + cz * cz
    longest = max(li, lj, lk)
    flat = longest < TINY_SQUARE or nx * nx + ny * ny + nz * nz <= (FLATNESS * longest) ** 2
    return nx, ny, nz, li, lj, lk, flat


@njit(cache=True, nogil=True, error_model="numpy")
def _corner_areas(vertices: Floats, i: int, j: int, k: int) -> tuple[float, float, float]:
    """Areas of a face that belong to its corners (geometry-spec 2)."""
    nx, ny, nz, li, lj, lk, flat = area_vector(vertices, i, j, k)
    area = 0.5 * math.sqrt(nx * nx + ny * ny + nz * nz)
    bi, bj, bk = li * (lj + lk - li), lj * (lk + li - lj), lk * (li + lj - lk)
    if flat:
        return area / 3.0, area / 3.0, area / 3.0
    if bi > 0.0 and bj > 0.0 and bk > 0.0:
        scale = 0.5 * area / (bi + bj + bk)
        return scale * (bj + bk), scale * (bk + bi), scale * (bi + bj)
    if bi <= 0.0:
        at_j, at_k = _beside_obtuse(li, lj, lk, area)
        return area - at_j - at_k, at_j, at_k
    if bj <= 0.0:
        at_k, at_i = _beside_obtuse(lj, lk, li, area)
        return at_i, area - at_k - at_i, at_k
    at_i, at_j = _beside_obtuse(lk, li, lj, area)
    return at_i, at_j, area - at_i - at_j


@njit(cache=True, nogil=True, error_model="numpy")
def _beside_obtuse(obtuse: float, following: float, previous: float, area: float) -> tuple[float, float]:
    """Areas at the next and the previous corner of a face with an obtuse or right corner.

    Args:
        obtuse: Squared length of the side opposite the obtuse corner.
        following: Of the side opposite the next corner.
        previous: Of the side opposite the previous corner.
        area: The face's area.
    """
    # -2 e_obtuse . e_previous and -2 e_obtuse . e_following by the law of cosines: sums of positive terms here, since
    # obtuse >= following + previous.
    return (
        0.5 * previous * area / (previous + (obtuse - following)),
        0.5 * following * area / (following + (obtuse - previous)),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _face(vertices: Floats, i: int, j: int, k: int) -> tuple[_Face, bool]:
    """A face's frame (t, b, n), edges (u, v) in it, their scatter (su, sv), and whether the face is degenerate.

    (t, b) are the principal axes of the scatter of the edges e0, e1, e2: sum u v = 0, sum u^2 = su, sum v^2 = sv.
    """
    nx, ny, nz, li, lj, lk, flat = area_vector(vertices, i, j, k)
    if flat:
        return (0.0,) * 17, True
    square = nx * nx + ny * ny + nz * nz
    length, side = math.sqrt(square), math.sqrt(li)
    nx, ny, nz = nx / length, ny / length, nz / length
    px, py, pz = vertices[k, 0] - vertices[j, 0], vertices[k, 1] - vertices[j, 1], vertices[k, 2] - vertices[j, 2]
    px, py, pz = px / side, py / side, pz / side
    qx, qy, qz = ny * pz - nz * py, nz * px - nx * pz, nx * py - ny * px
    # In (p, q): e0 = (side, 0), e1 = (x, y), e2 = -(e0 + e1).
    x = (
        (vertices[i, 0] - vertices[k, 0]) * px
        + (vertices[i, 1] - vertices[k, 1]) * py
        + (vertices[i, 2] - vertices[k, 2]) * pz
    )
    y = length / side
    half_trace = 0.5 * (li + lj + lk)
    difference = 0.5 * (li + x * x + (side + x) * (side + x)) - y * y
    mixed = (2.0 * x + side) * y
    radius = math.sqrt(difference * difference + mixed * mixed)
    su = half_trace + radius
    sv = 3.0 * square / su
    c, s = _half_angle(difference, mixed, radius)
    tx, ty, tz = c * px + s * qx, c * py + s * qy, c * pz + s * qz
    bx, by, bz = c * qx - s * px, c * qy - s * py, c * qz - s * pz
    ui, vi = c * side, -s * side
    uj, vj = c * x + s * y, c * y - s * x
    return (tx, ty, tz, bx, by, bz, nx, ny, nz, ui, vi, uj, vj, -ui - uj, -vi - vj, su, sv), False


@njit(cache=True, nogil=True, error_model="numpy")
def _half_angle(x: float, y: float, radius: float) -> tuple[float, float]:
    """Cosine and sine of half the angle of (x, y), whose length is `radius`."""
    if radius <= 0.0:
        return 1.0, 0.0
    if x >= 0.0:
        c = math.sqrt(0.5 * (1.0 + x / radius))
        return c, 0.5 * y / (radius * c)
    s = math.copysign(math.sqrt(0.5 * (1.0 - x / radius)), y)
    return 0.5 * y / (radius * s), s


@njit(cache=True, nogil=True, error_model="numpy")
def _any_tangent(x: float, y: float, z: float) -> tuple[float, float, float]:
    """A unit vector across the unit vector (x, y, z), continuous but at z = 0 (Duff et al. 2017)."""
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    return 1.0 + sign * x * x * a, sign * x * y * a, -sign * x


@njit(cache=True, nogil=True, error_model="numpy")
def _turned_into(face: _Face, normals: Floats, corner: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The (t, b) components of a vertex's tangent vector turned by the least rotation into the plane of a face.

    The vertex's other axis, normal x (x, y, z), turns into mirror * (-b, a), mirror being the third value: 1, but -1
    where the normals are opposite, and the rotation, being undefined, is replaced by negation.
    """
    tx, ty, tz, bx, by, bz, nx, ny, nz = face[0], face[1], face[2], face[3], face[4], face[5], face[6], face[7], face[8]
    ox, oy, oz = normals[corner, 0], normals[corner, 1], normals[corner, 2]
    towards = 1.0 + (ox * nx + oy * ny + oz * nz)
    a, b = x * tx + y * ty + z * tz, x * bx + y * by + z * bz
    if towards <= 1e-14:
        return -a, -b, -1.0
    across = (x * nx + y * ny + z * nz) / towards
    return a - (ox * tx + oy * ty + oz * tz) * across, b - (ox * bx + oy * by + oz * bz) * across, 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _in_face(k1: float, k2: float, a: float, b: float) -> tuple[float, float, float]:
    """The tensor diag(k1, k2) of axes (a, b), (-b, a), as uu, uv, vv."""
    return k1 * a * a + k2 * b * b, (k1 - k2) * a * b, k1 * b * b + k2 * a * a


@njit(cache=True, nogil=True, error_model="numpy")
def _principal(tensor: Floats, normals: Floats, areas: Floats) -> tuple[Floats, Floats]:
    """Principal curvatures (V, 2) and first directions (V, 3) of area-weighted sums (V, 3) in `_any_tangent` frames."""
    curvatures = np.zeros((len(tensor), 2))
    dir1 = np.zeros((len(tensor), 3))
    for v in range(len(tensor)):
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
    return curvatures, dir1


@njit(cache=True, nogil=True, error_model="numpy")
def _fill_undefined(vertices: Floats, faces: Ints, normals: Floats) -> None:
    """Give vertices whose normals cancelled that of their first face, and those without a proper face +y."""
    for f in range(len(faces)):
        nx, ny, nz, _, _, _, flat = area_vector(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        for corner in faces[f]:
            zero = normals[corner, 0] == 0.0 and normals[corner, 1] == 0.0 and normals[corner, 2] == 0.0
            if zero and not flat:
                normals[corner, 0], normals[corner, 1], normals[corner, 2] = nx / length, ny / length, nz / length
    for v in range(len(normals)):
        if normals[v, 0] == 0.0 and normals[v, 1] == 0.0 and normals[v, 2] == 0.0:
            normals[v, 1] = 1.0
