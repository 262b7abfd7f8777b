"""Sides of faces, vertex normals and vertex areas (docs/geometry.md 1, 2; Max 1999, Meyer et al. 2003).

A face whose height is below `FLATNESS` of its longest side has no direction that rounding leaves meaningful. It takes
no part in normals and curvature; of its area, which is rounding noise too, each corner gets a third.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncmodel.jit import kernel
from ncmodel.types import Floats

Indices = NDArray[np.uint32]
"""Vertex and face indices inside kernels: half the memory to read, and no index that may count from the end."""

FLATNESS = 1e-10
"""Height of a face, relative to its longest side, below which it counts as degenerate."""

TINY_SQUARE = 1e-60
"""Squared longest side below which a face counts as a point: keeps powers of lengths off the denormal range."""

CANCELLED = 1e-10
"""A sum of normals shorter than this, relative to the sum of their lengths, is what rounding leaves of 0."""

Sides = tuple[float, ...]
"""Vectors of the sides e0, e1, e2 (9), e0 x e1 (3), squared lengths of the sides (3): what `sides_of` returns."""


@kernel
def check_columns(rows: NDArray[Any], columns: int) -> None:
    """Hold a kernel's (n, columns) array to its width.

    Past this line the compiler knows the distance between rows. Without it, it guesses 1, for which alone it makes
    vector instructions: loops over vertices are then four times slower.

    Raises:
        ValueError: The array has another width.
    """
    if rows.shape[1] != columns:
        raise ValueError("a kernel's array has another number of columns than it reads")


@kernel
def sides_of(vertices: Floats, i: int, j: int, k: int) -> tuple[Sides, bool]:
    """The sides of face (i, j, k), side 0 opposite corner i running from j to k, and whether the face is degenerate."""
    ax, ay, az = vertices[k, 0] - vertices[j, 0], vertices[k, 1] - vertices[j, 1], vertices[k, 2] - vertices[j, 2]
    bx, by, bz = vertices[i, 0] - vertices[k, 0], vertices[i, 1] - vertices[k, 1], vertices[i, 2] - vertices[k, 2]
    cx, cy, cz = vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1], vertices[j, 2] - vertices[i, 2]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    li, lj, lk = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz, cx * cx + cy * cy + cz * cz
    longest = max(li, lj, lk)
    flat = longest < TINY_SQUARE or nx * nx + ny * ny + nz * nz <= (FLATNESS * longest) ** 2
    return (ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz, li, lj, lk), flat


@kernel
def corner_areas(sides: Sides, flat: bool) -> tuple[float, float, float]:
    """Areas of a face that belong to its corners: the Voronoi cells of the corners, clipped to the face."""
    ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz, li, lj, lk = sides
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    if flat:
        third = length / 6.0
        return third, third, third
    # |e0 x e1| cot(angle) at each corner: positive where it is acute.
    di = -(bx * cx + by * cy + bz * cz)
    dj = -(cx * ax + cy * ay + cz * az)
    dk = -(ax * bx + ay * by + az * bz)
    least = min(di, dj, dk)
    if least > 0.0:
        scale = 0.125 / length
        si, sj, sk = scale * li * di, scale * lj * dj, scale * lk * dk
        return sj + sk, sk + si, si + sj
    scale = 0.125 * length
    if least == di:
        at_j, at_k = scale * lk / dj, scale * lj / dk
        return 0.5 * length - at_j - at_k, at_j, at_k
    if least == dj:
        at_k, at_i = scale * li / dk, scale * lk / di
        return at_i, 0.5 * length - at_k - at_i, at_k
    at_i, at_j = scale * lj / di, scale * li / dj
    return at_i, at_j, 0.5 * length - at_i - at_j


@kernel
def point_areas(vertices: Floats, faces: Indices) -> Floats:
    """Area that belongs to each vertex (V,)."""
    check_columns(vertices, 3)
    check_columns(faces, 3)
    areas = np.zeros(len(vertices))
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        sides, flat = sides_of(vertices, i, j, k)
        at_i, at_j, at_k = corner_areas(sides, flat)
        areas[i] += at_i
        areas[j] += at_j
        areas[k] += at_k
    return areas


@kernel
def vertex_normals(vertices: Floats, faces: Indices) -> Floats:
    """Unit vertex normals (V, 3), weighted per corner by sin(angle) / product of the two sides' lengths.

    Where the faces' normals cancel, the normal is that of the first face; where there is no face, it is +y.
    """
    check_columns(vertices, 3)
    check_columns(faces, 3)
    normals = np.zeros((len(vertices), 3))
    lengths = np.zeros(len(vertices))
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        sides, flat = sides_of(vertices, i, j, k)
        if flat:
            continue
        nx, ny, nz, li, lj, lk = sides[9], sides[10], sides[11], sides[12], sides[13], sides[14]
        # The cross products at the three corners are one vector; only the lengths differ.
        share = 1.0 / (li * lj * lk)
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        for v, weight in ((i, li * share), (j, lj * share), (k, lk * share)):
            normals[v, 0] += weight * nx
            normals[v, 1] += weight * ny
            normals[v, 2] += weight * nz
            lengths[v] += weight * length
    undefined = False
    for v in range(len(normals)):
        undefined |= not _normalise(normals, v, CANCELLED * lengths[v])
    if undefined:
        _fill_undefined(vertices, faces, normals)
    return normals


@kernel
def _normalise(vectors: Floats, v: int, least: float) -> bool:
    """Scale one vector to length 1; where it isn't longer than `least`, to 0, which returns False."""
    x, y, z = vectors[v, 0], vectors[v, 1], vectors[v, 2]
    length = math.sqrt(x * x + y * y + z * z)
    scale = 1.0 / length if length > least else 0.0
    vectors[v, 0], vectors[v, 1], vectors[v, 2] = x * scale, y * scale, z * scale
    return scale > 0.0


@kernel
def _fill_undefined(vertices: Floats, faces: Indices, normals: Floats) -> None:
    """Give vertices whose normals cancelled that of their first face, and those without a proper face +y."""
    undefined = np.empty(len(normals), dtype=np.bool_)
    for v in range(len(normals)):
        undefined[v] = normals[v, 0] == 0.0 and normals[v, 1] == 0.0 and normals[v, 2] == 0.0
    for f in range(len(faces)):
        sides, flat = sides_of(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
        for v in faces[f]:
            if undefined[v] and not flat:
                normals[v, 0], normals[v, 1], normals[v, 2] = sides[9], sides[10], sides[11]
                undefined[v] = not _normalise(normals, v, 0.0)
    for v in range(len(normals)):
        if undefined[v]:
            normals[v, 1] = 1.0
