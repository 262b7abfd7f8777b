"""How faces hang together: which meet at each vertex, which are connected, and which agree about their fronts."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ncmodel.geometry.normals_areas import Indices, check_columns
from ncmodel.jit import kernel
from ncmodel.mesh.union_find import root
from ncmodel.types import Ints, Mask

Offsets = NDArray[np.int32]
"""Where the rows of each vertex start in a list."""


class Rings(NamedTuple):
    """The corners that meet at each vertex, in face order: those of vertex v are `starts[v] : starts[v + 1]`.

    Attributes:
        starts: (V + 1,).
        around: (3 F, 2) the next and the previous vertex of the corner's face.
        face: (3 F,) the corner's face.
    """

    starts: Offsets
    around: Indices
    face: Indices


def rings_of(faces: Indices, vertex_count: int) -> Rings:
    """Gather the corners of faces (F, 3) by vertex."""
    return Rings(*_gathered(faces, vertex_count))


def components(rows: Ints | Indices, count: int) -> Ints:
    """The connected components of a graph.

    Args:
        rows: (n, k) nodes, those of a row connected with each other: edges, or faces with their corners.
        count: Nodes of the graph.

    Returns:
        (count,) the component of each node, numbered by their lowest nodes.
    """
    return np.asarray(_components(rows, count))


def wound_alike(count: int, pairs: Ints, disagree: Mask) -> tuple[Ints, Mask]:
    """Connected faces, and how they come to agree about their fronts.

    Args:
        count: Faces.
        pairs: (P, 2) faces that share a side. One that would make its faces one-sided (a Moebius strip) is passed
            over, the last one first.
        disagree: (P,) True where they run along it in the same direction.

    Returns:
        (F,) a number for each face, equal for connected ones, by their lowest faces; (F,) True for the faces to be
        turned for all to agree with the lowest one.
    """
    label, turned = _wound_alike(count, pairs, disagree)
    return np.asarray(label), np.asarray(turned)


@kernel
def _gathered(faces: Indices, vertex_count: int) -> tuple[Offsets, Indices, Indices]:
    check_columns(faces, 3)
    starts = np.zeros(vertex_count + 1, dtype=np.int32)
    for f in range(len(faces)):
        for c in range(3):
            starts[faces[f, c] + 1] += 1
    for v in range(vertex_count):
        starts[v + 1] += starts[v]
    around = np.empty((3 * len(faces), 2), dtype=np.uint32)
    face = np.empty(3 * len(faces), dtype=np.uint32)
    place = starts[:-1].copy()
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        for v, following, previous in ((i, j, k), (j, k, i), (k, i, j)):
            n = place[v]
            around[n, 0], around[n, 1], face[n] = following, previous, f
            place[v] = n + 1
    return starts, around, face


@kernel
def _components(rows: Ints | Indices, count: int) -> Ints:
    parent = np.arange(count)
    for row in range(len(rows)):
        a = root(parent, rows[row, 0])
        for column in range(1, rows.shape[1]):
            b = root(parent, rows[row, column])
            parent[max(a, b)] = min(a, b)
            a = min(a, b)
    number, found = np.empty(count, np.int64), 0
    for node in range(count):
        # A set's lowest node is its root, so it is numbered before all others.
        lowest = root(parent, node)
        if lowest == node:
            number[node] = found
            found += 1
        else:
            number[node] = number[lowest]
    return number


@kernel
def _wound_alike(count: int, pairs: Ints, disagree: Mask) -> tuple[Ints, Mask]:
    parent, odd = np.arange(count), np.zeros(count, np.bool_)
    for p in range(len(pairs)):
        a, parity_a = _find(parent, odd, pairs[p, 0])
        b, parity_b = _find(parent, odd, pairs[p, 1])
        if a != b:
            # The lowest face of a set stays its root.
            high, low = max(a, b), min(a, b)
            parent[high] = low
            odd[high] = (parity_a != parity_b) != disagree[p]
    label, turned, found = np.empty(count, np.int64), np.empty(count, np.bool_), 0
    for f in range(count):
        lowest, turned[f] = _find(parent, odd, f)
        if lowest == f:
            label[f] = found
            found += 1
        else:
            label[f] = label[lowest]
    return label, turned


@kernel
def _find(parent: Ints, odd: Mask, i: int) -> tuple[int, bool]:
    """The representative of i's set, and whether i is to be turned for it to be as it is."""
    parity = False
    while parent[i] != i:
        odd[i] ^= odd[parent[i]]
        parent[i] = parent[parent[i]]
        parity ^= odd[i]
        i = parent[i]
    return i, parity
