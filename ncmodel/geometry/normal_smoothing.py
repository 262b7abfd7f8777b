"""Normals smoothed over neighbourhoods of growing size (docs/geometry.md 11; Jones et al. 2003)."""

import math

import numpy as np
from numpy.typing import NDArray

from ncmodel.geometry.adjacency import Offsets, Rings
from ncmodel.geometry.normals_areas import Indices, check_columns
from ncmodel.jit import kernel
from ncmodel.types import Floats

CUT = 6.25
"""Squared distance, in sigma^2, beyond which a neighbour has no weight."""

PATCH = 64
"""Vertices that are worked on together: as many as a mask has bits."""

MOST_NEIGHBOURS = 4096
"""Vertices that those of a patch are averaged with at most, the nearest in steps along sides first.

Regular meshes need some 1200 at sigma = 5 sides; meshes of very uneven density would otherwise take quadratic time.
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


@kernel
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


@kernel
def _patches(starts: Offsets, neighbours: Indices) -> tuple[Indices, Indices]:
    """All vertices, in patches of up to `PATCH` connected ones: patch p is `vertices[first[p] : first[p + 1]]`."""
    vertices = np.empty(len(starts) - 1, dtype=np.uint32)
    first = np.zeros(len(starts), dtype=np.uint32)
    taken = np.zeros(len(starts) - 1, dtype=np.bool_)
    patches, size = 0, 0
    for v in range(len(starts) - 1):
        if taken[v]:
            continue
        head, stop = size, size + PATCH
        vertices[size], taken[v] = v, True
        size += 1
        while head < size < stop:
            for n in range(starts[vertices[head]], starts[vertices[head] + 1]):
                q = neighbours[n]
                if not taken[q] and size < stop:
                    vertices[size], taken[q] = q, True
                    size += 1
            head += 1
        patches += 1
        first[patches] = size
    return vertices, first[: patches + 1].copy()


@kernel
def _diffused(rows: Floats, starts: Offsets, neighbours: Indices, reach: Floats) -> Floats:
    """Unit normals (levels, V, 3) averaged over neighbours within squared distances `reach`, ascending.

    The vertices of a patch are worked on side by side: one search in breadth serves them all, with a bit for each in a
    mask per vertex met, and sums run over a patch's vertices in vector instructions. `rows` (V, 8) hold position,
    normal, area.
    """
    check_columns(rows, 8)
    members, first = _patches(starts, neighbours)
    smooth = np.empty((len(reach), len(rows), 3))
    met_by = np.full(len(rows), -1, dtype=np.int32)
    masks = np.empty((len(rows), 3), dtype=np.uint64)
    met = np.empty(min(MOST_NEIGHBOURS + PATCH, len(rows)), dtype=np.uint32)
    queue = np.empty_like(met)
    own = np.zeros((8, PATCH))
    total = np.empty((len(reach), 3, PATCH))
    for p in range(len(first) - 1):
        patch = members[first[p] : first[p + 1]]
        for s in range(len(patch)):
            for axis in range(8):
                own[axis, s] = rows[patch[s], axis]
        size = _search(patch, own, rows, starts, neighbours, reach[-1], p, met_by, masks, met, queue)
        total[:] = 0.0
        _add_up(met[:size], len(patch), own, rows, masks, reach, total)
        for level in range(len(reach)):
            for s in range(len(patch)):
                x, y, z = total[level, 0, s], total[level, 1, s], total[level, 2, s]
                length = math.sqrt(x * x + y * y + z * z)
                for axis in range(3):
                    mean = total[level, axis, s] / length if length > 0.0 else own[3 + axis, s]
                    smooth[level, patch[s], axis] = mean
    return smooth


@kernel
def _search(
    patch: Indices,
    own: Floats,
    rows: Floats,
    starts: Offsets,
    neighbours: Indices,
    reach: float,
    number: int,
    met_by: Offsets,
    masks: NDArray[np.uint64],
    met: Indices,
    queue: Indices,
) -> int:
    """Fill `met` with the vertices connected to those of a patch; returns how many.

    `masks` (V, 3) hold a bit for each vertex of the patch: whose neighbour a vertex may be, whose it is, and of whom
    its own neighbours don't know yet.
    """
    size = 0
    for s in range(len(patch)):
        met_by[patch[s]] = number
        masks[patch[s], 0] = _near(own, rows, patch[s], reach)
        masks[patch[s], 1] = masks[patch[s], 2] = np.uint64(1) << np.uint64(s)
        met[size], queue[size] = patch[s], patch[s]
        size += 1
    head, waiting = 0, size
    while waiting > 0:
        here = queue[head]
        head, waiting = (head + 1) % len(queue), waiting - 1
        news = masks[here, 2]
        masks[here, 2] = 0
        for m in range(starts[here], starts[here + 1]):
            q = neighbours[m]
            if met_by[q] != number:
                if size == len(met):
                    continue
                met_by[q] = number
                masks[q, 0] = _near(own, rows, q, reach)
                masks[q, 1] = masks[q, 2] = 0
                met[size] = q
                size += 1
            fresh = news & masks[q, 0] & ~masks[q, 1]
            if fresh != 0:
                if masks[q, 2] == 0:
                    queue[(head + waiting) % len(queue)] = q
                    waiting += 1
                masks[q, 1] |= fresh
                masks[q, 2] |= fresh
    return size


@kernel
def _near(own: Floats, rows: Floats, q: int, reach: float) -> np.uint64:
    """A bit for each vertex of a patch: is q within `reach`, and turned the same way within 90 degrees?"""
    x, y, z, nx, ny, nz = rows[q, 0], rows[q, 1], rows[q, 2], rows[q, 3], rows[q, 4], rows[q, 5]
    check_columns(own, PATCH)
    mask = np.uint64(0)
    for s in range(PATCH):
        dx, dy, dz = x - own[0, s], y - own[1, s], z - own[2, s]
        near = dx * dx + dy * dy + dz * dz < reach
        turned = nx * own[3, s] + ny * own[4, s] + nz * own[5, s] > 0.0
        mask |= np.uint64(near & turned) << np.uint64(s)
    return mask


@kernel
def _add_up(
    met: Indices, count: int, own: Floats, rows: Floats, masks: NDArray[np.uint64], reach: Floats, total: Floats
) -> None:
    """Add the weighted normals of the vertices met to the sums `total` (levels, 3, PATCH) of a patch."""
    check_columns(own, PATCH)
    check_columns(rows, 8)
    weight, square = np.zeros(PATCH), np.zeros(PATCH)
    radius = 0.0
    for s in range(count):
        dx, dy, dz = own[0, s] - own[0, 0], own[1, s] - own[1, 0], own[2, s] - own[2, 0]
        radius = max(radius, (1.0 + 1e-9) * math.sqrt(dx * dx + dy * dy + dz * dz))
    for n in range(len(met)):
        q = met[n]
        mask = masks[q, 1]
        if mask == 0:
            continue
        x, y, z, nx, ny, nz = rows[q, 0], rows[q, 1], rows[q, 2], rows[q, 3], rows[q, 4], rows[q, 5]
        area = rows[q, 6]
        for s in range(PATCH):
            dx, dy, dz = x - own[0, s], y - own[1, s], z - own[2, s]
            square[s] = dx * dx + dy * dy + dz * dz
            cosine = nx * own[3, s] + ny * own[4, s] + nz * own[5, s]
            weight[s] = cosine * area if (mask >> np.uint64(s)) & np.uint64(1) else 0.0
        dx, dy, dz = x - own[0, 0], y - own[1, 0], z - own[2, 0]
        nearest = max(math.sqrt(dx * dx + dy * dy + dz * dz) - radius, 0.0) ** 2
        for level in range(len(reach) - 1, -1, -1):
            if nearest > reach[level]:
                break  # out of the reach of all
            inverse = 1.0 / max(reach[level], 1e-300)
            _add_weighted(square, weight, inverse, nx, ny, nz, total[level, 0], total[level, 1], total[level, 2])


@kernel
def _add_weighted(
    square: Floats, weight: Floats, inverse: float, x: float, y: float, z: float, xs: Floats, ys: Floats, zs: Floats
) -> None:
    """Add (1 - square * inverse)^2 * weight * (x, y, z), where that difference is positive, to (xs, ys, zs)."""
    for s in range(PATCH):
        share = max(1.0 - square[s] * inverse, 0.0)
        share *= share * weight[s]
        xs[s] += share * x
        ys[s] += share * y
        zs[s] += share * z
