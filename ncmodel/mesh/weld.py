"""Welding: which points are one, exactly or up to rounding, and meshes with their vertices merged."""

import numpy as np
from numpy.typing import NDArray

from ncmodel.jit import kernel
from ncmodel.mesh.union_find import root
from ncmodel.types import Floats, Ints, Mesh

WELD = 2.0**-20
"""Points that share a grid cell of this size, relative to the points' extent, are one point."""


def weld_points(points: Floats) -> Ints:
    """(N,) a number for each of (N, D) points, D <= 3, equal for points that coincide up to rounding."""
    low = points.min(axis=0)
    cell = max(float((points.max(axis=0) - low).max()), 1e-300) * WELD
    aligned, shifted = (_cells((points - low) / cell + shift) for shift in (0.0, 0.5))
    # Two grids, half a cell apart: a pair that one of them parts, the other holds together.
    return linked(aligned, shifted)


def _cells(scaled: Floats) -> Ints:
    """(N,) dense numbers of the grid cells that the points fall in."""
    key = np.zeros(len(scaled), dtype=np.int64)
    for axis in range(scaled.shape[1]):
        key = (key << 21) + scaled[:, axis].astype(np.int64)
    number: Ints = np.unique(key, return_inverse=True)[1]
    return number


@kernel
def linked(first: Ints, second: Ints) -> Ints:
    """Numbers in which points are equal that share a number in either argument, or are linked by such points."""
    parent = np.arange(first.max() + 1)
    owner = np.full(second.max() + 1, -1)
    for i in range(len(first)):
        if owner[second[i]] < 0:
            owner[second[i]] = first[i]
        a, b = root(parent, first[i]), root(parent, owner[second[i]])
        parent[max(a, b)] = min(a, b)
    number = np.empty(len(first), np.int64)
    for i in range(len(first)):
        number[i] = root(parent, first[i])
    return number


def weld(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Merge vertices at exactly equal positions; the first of each group stays, in the old order."""
    key = _mixed(vertices)
    order = np.argsort(key)
    ordered = vertices[order]
    if ((key[order][1:] == key[order][:-1]) & (ordered[1:] != ordered[:-1]).any(axis=1)).any():
        order = np.lexsort(vertices.T)  # two positions share a key: sort by the positions themselves
        ordered = vertices[order]
    opens = np.ones(len(order), dtype=bool)
    opens[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    first = np.minimum.reduceat(order, np.flatnonzero(opens))
    same = np.empty(len(order), dtype=np.int64)
    same[order] = first[np.cumsum(opens) - 1]
    return merged(vertices, faces, same)


def merged(vertices: Floats, faces: Ints, same: Ints) -> tuple[Floats, Ints]:
    """Vertices merged with others; those that are left keep their order.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        same: (V,) for each vertex the first one of those that it is merged with, itself if it is that.
    """
    kept = same == np.arange(len(same))
    return vertices[kept], (np.cumsum(kept) - 1)[same][faces]


def without_cracks(mesh: Mesh, stored: int) -> Mesh:
    """Merge vertices within a millionth of the mesh's size: in single precision they differ by rounding alone.

    Args:
        mesh: Welded at exactly equal positions.
        stored: How many vertices its file holds.
    """
    _, first, group = np.unique(weld_points(mesh.vertices), return_index=True, return_inverse=True)
    vertices, faces = merged(mesh.vertices, mesh.faces, first[group])
    note = (f"welded {stored} vertices to {len(first)} at equal positions",) if len(first) < stored else ()
    return Mesh(vertices, faces, mesh.name, (*mesh.notes, *note))


def _mixed(vertices: Floats) -> NDArray[np.uint64]:
    """(V,) a key that is equal for equal positions and hardly ever for others."""
    bits = (vertices + 0.0).view(np.uint64)  # -0.0 equals 0.0
    key = np.zeros(len(bits), dtype=np.uint64)
    for column in bits.T:
        key = (key ^ column) * np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
    return key
