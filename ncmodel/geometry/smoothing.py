"""Normals smoothed over neighbourhoods of growing size (docs/geometry.md 11; Jones et al. 2003)."""

import math

import numpy as np
from numba import njit

from ncmodel.geometry.areas import Indices
from ncmodel.geometry.rings import Offsets, Rings
from ncmodel.types import Floats

CUT = 6.25
"""Squared distance, in sigma^2, beyond which a neighbour has no weight."""

MOST_NEIGHBOURS = 4096
"""Vertices that one vertex is averaged with at most, the nearest in steps along sides first.

Regular meshes need some 570 at sigma = 5 sides; meshes of very uneven density would otherwise take quadratic time.
"""


def smoothed_normals(vertices: Floats, normals: Floats, areas: Floats, rings: Rings, levels: int = 5) -> Floats:
    """Unit normals (levels + 1, V, 3) diffused at sigma = 0, 1, .., `levels` median side lengths.

    Neighbours of a vertex are those connected with it inside the largest radius, by vertices whose normals are within
    90 degrees of its own.

    Args:
        vertices: (V, 3).
        normals: (V, 3).
        areas: (V,) point areas.
        rings: The vertices' neighbours.
        levels: Number of smoothed fields.
    """
    length = median_side(vertices, rings)
    reach = CUT * np.square(length * np.arange(1, levels + 1))
    starts, neighbours = _neighbours(rings.starts, rings.around)
    # One row a vertex, 64 bytes: a neighbour costs one cache line.
    rows = np.concatenate([vertices, normals, areas[:, None], np.zeros((len(areas), 1))], axis=1)
    return np.concatenate([normals[None], _diffused(rows, starts, neighbours, reach)])


def median_side(vertices: Floats, rings: Rings) -> float:
    """Median length of the faces' sides."""
    start = np.repeat(np.arange(len(vertices)), np.diff(rings.starts))
    return float(np.median(np.linalg.norm(vertices[rings.around[:, 0]] - vertices[start], axis=1)))


@njit(cache=True, nogil=True, error_model="numpy")
def _neighbours(starts: Offsets, around: Indices) -> tuple[Offsets, Indices]:
    """Neighbours of vertex v, each once: `neighbours[first[v] : first[v + 1]]`."""
    first = np.zeros(len(starts), dtype=np.int32)
    neighbours = np.empty(2 * len(around), dtype=np.uint32)
    met_by = np.full(len(starts), -1, dtype=np.int32)
    size = 0
    for v in range(len(starts) - 1):
        for n in range(starts[v], starts[v + 1]):
            for q in around[n]:
                if met_by[q] != v:
                    met_by[q] = v
                    neighbours[size] = q
                    size += 1
        first[v + 1] = size
    return first, neighbours[:size].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def _diffused(rows: Floats, starts: Offsets, neighbours: Indices, reach: Floats) -> Floats:
    """Unit normals (levels, V, 3) averaged over neighbours within squared distances `reach`, ascending.

    One search a vertex, in breadth, serves all levels. `rows` (V, 8) hold position, normal, area.
    """
    levels = len(reach)
    inverse = 1.0 / np.maximum(reach, 1e-300)
    smooth = np.empty((levels, len(rows), 3))
    met_by = np.full(len(rows), -1, dtype=np.int32)
    queue = np.empty(min(MOST_NEIGHBOURS, len(rows)), dtype=np.uint32)
    total = np.empty((levels, 3))
    for v in range(len(rows)):
        px, py, pz, vx, vy, vz = rows[v, 0], rows[v, 1], rows[v, 2], rows[v, 3], rows[v, 4], rows[v, 5]
        for level in range(levels):
            for axis in range(3):
                total[level, axis] = rows[v, 6] * rows[v, 3 + axis]
        queue[0], met_by[v] = v, v
        size, head = 1, 0
        while head < size:
            here = queue[head]
            head += 1
            for n in range(starts[here], starts[here + 1]):
                q = neighbours[n]
                if met_by[q] == v or size == len(queue):
                    continue
                met_by[q] = v
                x, y, z, nx, ny, nz = (
                    rows[q, 0] - px,
                    rows[q, 1] - py,
                    rows[q, 2] - pz,
                    rows[q, 3],
                    rows[q, 4],
                    rows[q, 5],
                )
                square, cosine = x * x + y * y + z * z, nx * vx + ny * vy + nz * vz
                if square >= reach[levels - 1] or cosine <= 0.0:
                    continue
                queue[size] = q
                size += 1
                for level in range(levels - 1, -1, -1):
                    if square >= reach[level]:
                        break
                    share = 1.0 - square * inverse[level]
                    weight = share * share * cosine * rows[q, 6]
                    total[level, 0] += weight * nx
                    total[level, 1] += weight * ny
                    total[level, 2] += weight * nz
        for level in range(levels):
            x, y, z = total[level, 0], total[level, 1], total[level, 2]
            length = math.sqrt(x * x + y * y + z * z)
            for axis in range(3):
                smooth[level, v, axis] = total[level, axis] / length if length > 0.0 else rows[v, 3 + axis]
    return smooth
