"""Welding: which points are one, exactly or within a tolerance, and meshes with their vertices merged."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, Mesh

ROUNDING = 2.0**-20
"""Points closer than this, relative to the extent of all, differ by the rounding of single precision alone."""

CELL = 16.0
"""Tolerances that a grid cell is wide: few points are near its sides, and few others in it."""

MOST_CELLS = 2.0**20
"""Along each axis, so that the numbers of three axes fit into one of 64 bits."""


def coincident(points: Floats, tolerance: float | Floats = 0.0, among: Ints | None = None) -> Ints:
    """Which points are one.

    A point is one with the first that has it within the tolerance and is one with no earlier point: so a row of near
    points doesn't creep together, and none moves farther than the tolerance.

    Args:
        points: (N, D), D <= 3.
        tolerance: The largest distance of points that are one, or (N,) each one's, of which the smaller counts; at 0
            they are where their coordinates are equal.
        among: (n,) ascending indices of the points that may be one with others; all by default.

    Returns:
        (N,) for each point the first of those that it is one with, itself if it is that.
    """
    some = points if among is None else points[among]
    if len(some) == 0:
        return np.arange(len(points))
    if np.isscalar(tolerance) and tolerance == 0:
        first = _equal(some)
    else:
        reach = np.broadcast_to(np.asarray(tolerance, dtype=np.float64), len(points))
        first = _near(some, np.ascontiguousarray(reach if among is None else reach[among]))
    if among is None:
        return first
    same = np.arange(len(points))
    same[among] = among[first]
    return same


def rounding(points: Floats) -> float:
    """The distance below which (N, D) points differ by rounding alone."""
    return ROUNDING * max(float(np.ptp(points, axis=0).max()), 1e-300)


def merged(vertices: Floats, faces: Ints, same: Ints) -> tuple[Floats, Ints]:
    """Vertices merged with others; those that are left keep their order.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        same: (V,) for each vertex the first one of those that it is merged with, itself if it is that.
    """
    kept = same == np.arange(len(same))
    return vertices[kept], (np.cumsum(kept) - 1)[same][faces]


def weld(vertices: Floats, faces: Ints, tolerance: float = 0.0) -> tuple[Floats, Ints]:
    """Merge vertices within a tolerance, see `coincident`; the first of each group stays, in the old order."""
    return merged(vertices, faces, coincident(vertices, tolerance))


def without_cracks(mesh: Mesh, stored: int) -> Mesh:
    """Merge vertices within a millionth of the mesh's size: in single precision they differ by rounding alone.

    Args:
        mesh: Welded at exactly equal positions.
        stored: How many vertices its file holds.
    """
    vertices, faces = weld(mesh.vertices, mesh.faces, rounding(mesh.vertices))
    count = len(vertices)
    note = (f"welded {stored} vertices to {count} at equal positions",) if count < stored else ()
    return replace(mesh, vertices=vertices, faces=faces, notes=(*mesh.notes, *note))


def _equal(points: Floats) -> Ints:
    """(N,) for each point the first one at exactly its position."""
    key = _mixed(points)
    order = np.argsort(key)
    ordered = points[order]
    if ((key[order][1:] == key[order][:-1]) & (ordered[1:] != ordered[:-1]).any(axis=1)).any():
        order = np.lexsort(points.T)  # two positions share a key: sort by the positions themselves
        ordered = points[order]
    opens = np.ones(len(order), dtype=bool)
    opens[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    first = np.minimum.reduceat(order, np.flatnonzero(opens))
    same = np.empty(len(order), dtype=np.int64)
    same[order] = first[np.cumsum(opens) - 1]
    return same


def _mixed(points: Floats) -> NDArray[np.uint64]:
    """(N,) a key that is equal for equal positions and hardly ever for others."""
    bits = (points + 0.0).view(np.uint64)  # -0.0 equals 0.0
    key = np.zeros(len(bits), dtype=np.uint64)
    for column in bits.T:
        key = (key ^ column) * np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
    return key


def _near(points: Floats, reach: Floats) -> Ints:
    """(N,) for each point the first one that has it within reach, by way of a grid."""
    low = points.min(axis=0)
    extent = float((points.max(axis=0) - low).max())
    cell = max(CELL * float(reach.max()), extent / MOST_CELLS, 1e-300)
    scaled, key = placed(points, low, cell)
    order = np.argsort(key)
    return np.asarray(_claimed(scaled, reach / cell, order, key[order]))


@kernel
def placed(points: Floats, low: Floats, cell: float) -> tuple[Floats, Ints]:
    """Points (N, D) on a grid that starts at `low`.

    Returns:
        (N, 3) in units of cells, the first of fewer axes left at 0; (N,) one number for the cell that each lies in.
    """
    scaled, key = np.zeros((len(points), 3)), np.empty(len(points), np.int64)
    missing = 3 - points.shape[1]
    for i in range(len(points)):
        for axis in range(points.shape[1]):
            scaled[i, missing + axis] = (points[i, axis] - low[axis]) / cell
        key[i] = cell_number(int(scaled[i, 0]), int(scaled[i, 1]), int(scaled[i, 2]))
    return scaled, key


@kernel
def cell_number(x: int, y: int, z: int) -> int:
    """One number for the three of a cell; those of cells in a row along z follow each other."""
    return (((x << 21) + y) << 21) + z


@kernel
def _claimed(points: Floats, reach: Floats, order: Ints, keys: Ints) -> Ints:
    """(N,) for each point the first one that has it within reach.

    Args:
        points: (N, 3) in units of grid cells, none negative.
        reach: (N,) in the same.
        order: (N,) the points by cell.
        keys: (N,) their cells' numbers in that order.
    """
    same = np.arange(len(points))
    place = np.empty(len(points), np.int64)
    place[order] = np.arange(len(points))
    for i in range(len(points)):
        if same[i] != i:
            continue
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        lowest, highest = int(max(z - reach[i], 0.0)), int(z + reach[i])
        for column in range(int(max(x - reach[i], 0.0)), int(x + reach[i]) + 1):
            for row in range(int(max(y - reach[i], 0.0)), int(y + reach[i]) + 1):
                first, last = cell_number(column, row, lowest), cell_number(column, row, highest)
                if column == int(x) and row == int(y):
                    n = place[i]
                    while n > 0 and keys[n - 1] >= first:
                        n -= 1
                else:
                    n = np.searchsorted(keys, first)
                while n < len(keys) and keys[n] <= last:
                    j = order[n]
                    n += 1
                    if j > i and same[j] == j:
                        dx, dy, dz = points[j, 0] - x, points[j, 1] - y, points[j, 2] - z
                        limit = min(reach[i], reach[j])
                        if dx * dx + dy * dy + dz * dz <= limit * limit:
                            same[j] = i
    return same
