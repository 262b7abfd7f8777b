"""Normals smoothed over neighbourhoods of growing size (geometry-spec 11; Jones et al. 2003)."""

import math

import numpy as np
from numba import njit

from ncmodel.types import Floats, Ints

CUT = 6.25
"""Squared distance, in sigma^2, beyond which a neighbour has no weight."""

MOST_NEIGHBOURS = 4096
"""Vertices that one vertex is averaged with at most, the nearest in steps along edges first.

Regular meshes need some 570 at sigma = 5 edges; meshes of very uneven density would otherwise take quadratic time.
"""


def smoothed_normals(vertices: Floats, normals: Floats, areas: Floats, edges: Ints, levels: int = 5) -> Floats:
    """Unit normals (levels + 1, V, 3) diffused at sigma = 0, 1, .., `levels` median edge lengths.

    Neighbours of a vertex are those connected with it inside the largest radius, by vertices whose normals are within
    90 degrees of its own.

    Args:
        vertices: (V, 3).
        normals: (V, 3).
        areas: (V,) from `point_areas`.
        edges: (E, 2) every edge once.
        levels: Number of smoothed fields.
    """
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    edge = float(np.median(lengths)) if len(lengths) else 0.0
    starts, neighbours = _adjacency(edges, len(vertices))
    squares = np.square(edge * np.arange(1, levels + 1))
    smooth = _diffused(vertices, normals, areas, starts, neighbours, CUT * squares)
    return np.concatenate([normals[None], smooth])


@njit(cache=True, nogil=True, error_model="numpy")
def _adjacency(edges: Ints, vertex_count: int) -> tuple[Ints, Ints]:
    """Neighbours of vertex v are `neighbours[starts[v] : starts[v + 1]]`."""
    starts = np.zeros(vertex_count + 1, dtype=np.int64)
    for e in range(len(edges)):
        starts[edges[e, 0] + 1] += 1
        starts[edges[e, 1] + 1] += 1
    for v in range(vertex_count):
        starts[v + 1] += starts[v]
    position = starts[:-1].copy()
    neighbours = np.empty(2 * len(edges), dtype=np.int64)
    for e in range(len(edges)):
        for side in range(2):
            v = edges[e, side]
            neighbours[position[v]] = edges[e, 1 - side]
            position[v] += 1
    return starts, neighbours


@njit(cache=True, nogil=True, error_model="numpy")
def _diffused(
    vertices: Floats, normals: Floats, areas: Floats, starts: Ints, neighbours: Ints, reach: Floats
) -> Floats:
    """Unit normals (levels, V, 3) averaged over neighbours within squared distances `reach`, ascending.

    One search a vertex, in breadth, serves all levels.
    """
    levels = len(reach)
    smooth = np.empty((levels, len(vertices), 3))
    met_by = np.full(len(vertices), -1, dtype=np.int64)
    queue = np.empty(min(MOST_NEIGHBOURS, len(vertices)), dtype=np.int64)
    total = np.empty((levels, 3))
    for v in range(len(vertices)):
        for level in range(levels):
            for axis in range(3):
                total[level, axis] = areas[v] * normals[v, axis]
        queue[0] = v
        met_by[v] = v
        size, head = 1, 0
        while head < size:
            for n in range(starts[queue[head]], starts[queue[head] + 1]):
                q = neighbours[n]
                if met_by[q] == v or size == len(queue):
                    continue
                met_by[q] = v
                x, y, z = (
                    vertices[q, 0] - vertices[v, 0],
                    vertices[q, 1] - vertices[v, 1],
                    vertices[q, 2] - vertices[v, 2],
                )
                nx, ny, nz = normals[q, 0], normals[q, 1], normals[q, 2]
                square = x * x + y * y + z * z
                cosine = nx * normals[v, 0] + ny * normals[v, 1] + nz * normals[v, 2]
                if square >= reach[levels - 1] or cosine <= 0.0:
                    continue
                queue[size] = q
                size += 1
                for level in range(levels - 1, -1, -1):
                    if square >= reach[level]:
                        break
                    weight = (1.0 - square / reach[level]) ** 2 * cosine * areas[q]
                    total[level, 0] += weight * nx
                    total[level, 1] += weight * ny
                    total[level, 2] += weight * nz
            head += 1
        for level in range(levels):
            x, y, z = total[level, 0], total[level, 1], total[level, 2]
            length = math.sqrt(x * x + y * y + z * z)
            for axis in range(3):
                smooth[level, v, axis] = total[level, axis] / length if length > 0.0 else normals[v, axis]
    return smooth
