"""Which faces of a mesh may pass through each other, found by a tree of boxes.

Faces are put in the order of a space-filling curve and, a few at a time, into the leaves of a binary tree. A node knows
the box around its faces, and the box around their normals. Two nodes whose boxes are apart hold no faces that meet; nor
do two whose normals all point the same way, but for faces that hardly bend where they meet. So of a smooth surface,
however fine, only a few large nodes are compared.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ncmodel.geometry.normals_areas import Indices, check_columns, sides_of
from ncmodel.jit import kernel
from ncmodel.mesh.point_tree import BITS, spread
from ncmodel.types import Floats, Ints

LEAF = 8
"""Faces in a leaf."""

_Singles = NDArray[np.float32]


def crossing_faces(vertices: Floats, faces: Indices, touch: float, least_angle: float) -> Ints:
    """Pairs of faces that share no vertex and reach to both sides of each other's planes, or touch them.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        touch: A vertex nearer than this to a plane touches it; more than the rounding of single precision.
        least_angle: Pairs whose normals differ by less, in radians, are left out.

    Returns:
        (P, 2) face indices, the lower one first, in ascending order.
    """
    if len(faces) == 0:
        return np.empty((0, 2), np.int64)
    low, size = extent(vertices, faces)
    key = _curve(vertices, faces, low, (2**BITS - 1) / max(size, 1e-300))
    order = np.argsort(key, kind="stable").astype(np.uint32)
    first, second = _compared(vertices, faces, order, touch, 2.0 * math.sin(least_angle / 2))
    pairs = np.stack([np.minimum(first, second), np.maximum(first, second)], axis=1)
    return np.asarray(pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])


@kernel
def extent(vertices: Floats, faces: Indices) -> tuple[Floats, float]:
    """The lowest corner of the box around faces, (3,), and its longest side."""
    check_columns(vertices, 3)
    check_columns(faces, 3)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for f in range(len(faces)):
        for c in range(3):
            for axis in range(3):
                low[axis] = min(low[axis], vertices[faces[f, c], axis])
                high[axis] = max(high[axis], vertices[faces[f, c], axis])
    return low, max(high[0] - low[0], high[1] - low[1], high[2] - low[2])


@kernel
def _curve(vertices: Floats, faces: Indices, low: Floats, scale: float) -> Indices:
    """(F,) each face's place along Morton's curve, by its centroid."""
    check_columns(vertices, 3)
    check_columns(faces, 3)
    key = np.zeros(len(faces), np.uint32)
    for f in range(len(faces)):
        for axis in range(3):
            middle = (vertices[faces[f, 0], axis] + vertices[faces[f, 1], axis] + vertices[faces[f, 2], axis]) / 3.0
            cell = np.uint32((middle - low[axis]) * scale)
            key[f] |= spread(cell) << np.uint32(axis)
    return key


@kernel
def _tree(vertices: Floats, faces: Indices, order: Indices, leaves: int) -> tuple[_Singles, _Singles]:
    """Boxes, lowest coordinates first, around each face in `order` (F, 6), and those of a binary tree (2 leaves, 12).

    Node 1 is the root, 2 n and 2 n + 1 are the children of node n, and the last `leaves` nodes are the leaves. The last
    six columns are the box around the faces' unit normals. Degenerate faces have boxes that meet none.
    """
    check_columns(vertices, 3)
    check_columns(faces, 3)
    box = np.empty((len(faces), 6), np.float32)
    nodes = np.empty((2 * leaves, 12), np.float32)
    for n in range(len(nodes)):
        for column in range(12):
            nodes[n, column] = np.inf if column % 6 < 3 else -np.inf
    for m in range(len(order)):
        i, j, k = faces[order[m], 0], faces[order[m], 1], faces[order[m], 2]
        sides, flat = sides_of(vertices, i, j, k)
        length = math.sqrt(sides[9] ** 2 + sides[10] ** 2 + sides[11] ** 2)
        n = leaves + m // LEAF
        for axis, across in enumerate((sides[9], sides[10], sides[11])):
            a, b, c = vertices[i, axis], vertices[j, axis], vertices[k, axis]
            box[m, axis] = np.inf if flat else min(a, b, c)
            box[m, 3 + axis] = -np.inf if flat else max(a, b, c)
            nodes[n, axis] = min(nodes[n, axis], box[m, axis])
            nodes[n, 3 + axis] = max(nodes[n, 3 + axis], box[m, 3 + axis])
            if not flat:
                nodes[n, 6 + axis] = min(nodes[n, 6 + axis], across / length)
                nodes[n, 9 + axis] = max(nodes[n, 9 + axis], across / length)
    for n in range(leaves - 1, 0, -1):
        for axis in range(3):
            for low, high in ((axis, 3 + axis), (6 + axis, 9 + axis)):
                nodes[n, low] = min(nodes[2 * n, low], nodes[2 * n + 1, low])
                nodes[n, high] = max(nodes[2 * n, high], nodes[2 * n + 1, high])
    return box, nodes


@kernel
def _compared(vertices: Floats, faces: Indices, order: Indices, touch: float, least_chord: float) -> tuple[Ints, Ints]:
    """The pairs, found from the root down."""
    leaves = 1
    while leaves * LEAF < len(order):
        leaves *= 2
    box, nodes = _tree(vertices, faces, order, leaves)
    first, second = [np.int64(0) for _ in range(0)], [np.int64(0) for _ in range(0)]
    # Depth first: each of the few levels leaves three pairs waiting at most.
    stack, size = np.empty((256, 2), np.int64), 1
    stack[0] = 1
    while size:
        size -= 1
        a, b = stack[size, 0], stack[size, 1]
        if (a != b and _apart(nodes, a, nodes, b, touch)) or _alike(nodes, a, b, least_chord):
            continue
        if a < leaves:
            for c, d in ((2 * a, 2 * b), (2 * a + 1, 2 * b + 1), (2 * a, 2 * b + 1), (2 * a + 1, 2 * b)):
                if a != b or c <= d:
                    stack[size, 0], stack[size, 1] = c, d
                    size += 1
            continue
        for m in range((a - leaves) * LEAF, min((a - leaves + 1) * LEAF, len(order))):
            if a != b and _apart(box, m, nodes, b, touch):
                continue
            start = m + 1 if a == b else (b - leaves) * LEAF
            for n in range(start, min((b - leaves + 1) * LEAF, len(order))):
                if not _apart(box, m, box, n, touch) and _cross(
                    vertices, faces, order[m], order[n], touch, least_chord
                ):
                    first.append(np.int64(order[m]))
                    second.append(np.int64(order[n]))
    return np.array(first, dtype=np.int64), np.array(second, dtype=np.int64)


@kernel
def _apart(one: _Singles, a: int, other: _Singles, b: int, touch: float) -> bool:
    """Whether boxes a and b are farther from each other than `touch`."""
    for axis in range(3):
        if one[a, axis] > other[b, 3 + axis] + touch or other[b, axis] > one[a, 3 + axis] + touch:
            return True
    return False


@kernel
def _alike(nodes: _Singles, a: int, b: int, least_chord: float) -> bool:
    """Whether no two normals in two nodes are farther from each other, as points on the unit sphere, than a chord."""
    square = 0.0
    for axis in range(3):
        low, high = min(nodes[a, 6 + axis], nodes[b, 6 + axis]), max(nodes[a, 9 + axis], nodes[b, 9 + axis])
        square += (high - low) * (high - low)
    return square < least_chord * least_chord


@kernel
def _cross(vertices: Floats, faces: Indices, f: int, g: int, touch: float, least_chord: float) -> bool:
    """Whether two faces share no vertex, are turned differently, and neither is clearly on one side of the other."""
    for i in range(3):
        for j in range(3):
            if faces[f, i] == faces[g, j]:
                return False
    a, b = unit_normal(vertices, faces, f), unit_normal(vertices, faces, g)
    if (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2 < least_chord * least_chord:
        return False
    return _reaches(vertices, faces, f, faces[g, 0], b, touch) and _reaches(vertices, faces, g, faces[f, 0], a, touch)


@kernel
def unit_normal(vertices: Floats, faces: Indices, f: int) -> tuple[float, float, float]:
    """The unit normal of a face that isn't degenerate."""
    sides, _ = sides_of(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
    length = math.sqrt(sides[9] ** 2 + sides[10] ** 2 + sides[11] ** 2)
    return sides[9] / length, sides[10] / length, sides[11] / length


@kernel
def height(vertices: Floats, v: int, origin: int, normal: tuple[float, float, float]) -> float:
    """How far vertex v is above the plane through vertex `origin`."""
    above = 0.0
    for axis in range(3):
        above += (vertices[v, axis] - vertices[origin, axis]) * normal[axis]
    return above


@kernel
def _reaches(
    vertices: Floats, faces: Indices, f: int, origin: int, normal: tuple[float, float, float], touch: float
) -> bool:
    """Whether a face isn't clearly on one side of a plane."""
    a, b, c = (
        height(vertices, faces[f, 0], origin, normal),
        height(vertices, faces[f, 1], origin, normal),
        height(vertices, faces[f, 2], origin, normal),
    )
    return min(a, b, c) <= touch and max(a, b, c) >= -touch
