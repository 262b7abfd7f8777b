"""A tree of boxes around points: which of them lie near a segment, however long it is and however unevenly they lie."""

from typing import NamedTuple, Self

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints

LEAF = 8
"""Points in a leaf."""
BITS = 10
"""Of each coordinate, for the order along the curve."""


class PointTree(NamedTuple):
    """Points in the order of a space-filling curve and, a few at a time, in the leaves of a binary tree.

    Attributes:
        order: (N,) the points along the curve.
        box: (2 leaves, 6) the lowest and the highest corner around the points of each node: node 1 is the root, 2 n and
            2 n + 1 are the children of node n, and the second half are the leaves.
    """

    order: Ints
    box: Floats

    @classmethod
    def of(cls, points: Floats) -> Self:
        """The tree of points (N, 3)."""
        low = points.min(axis=0)
        scale = (2**BITS - 1) / max(float((points.max(axis=0) - low).max()), 1e-300)
        order = np.argsort(_places(points, low, scale), kind="stable")
        return cls(order, _boxes(points, order))


@kernel
def spread(cell: np.uint32) -> np.uint32:
    """A number of `BITS` bits with two zeros between them: a third of a place along Morton's curve."""
    cell = (cell | cell << np.uint32(16)) & np.uint32(0x030000FF)
    cell = (cell | cell << np.uint32(8)) & np.uint32(0x0300F00F)
    cell = (cell | cell << np.uint32(4)) & np.uint32(0x030C30C3)
    return (cell | cell << np.uint32(2)) & np.uint32(0x09249249)


@kernel
def _places(points: Floats, low: Floats, scale: float) -> Ints:
    """(N,) each point's place along Morton's curve."""
    place = np.zeros(len(points), np.int64)
    for i in range(len(points)):
        for axis in range(3):
            place[i] |= np.int64(spread(np.uint32((points[i, axis] - low[axis]) * scale))) << axis
    return place


@kernel
def _boxes(points: Floats, order: Ints) -> Floats:
    leaves = 1
    while leaves * LEAF < len(order):
        leaves *= 2
    box = np.empty((2 * leaves, 6))
    box[:, :3], box[:, 3:] = np.inf, -np.inf
    for m in range(len(order)):
        node = leaves + m // LEAF
        for axis in range(3):
            box[node, axis] = min(box[node, axis], points[order[m], axis])
            box[node, 3 + axis] = max(box[node, 3 + axis], points[order[m], axis])
    for node in range(leaves - 1, 0, -1):
        for axis in range(3):
            box[node, axis] = min(box[2 * node, axis], box[2 * node + 1, axis])
            box[node, 3 + axis] = max(box[2 * node, 3 + axis], box[2 * node + 1, 3 + axis])
    return box


@kernel
def near_segment(tree: PointTree, start: Floats, axis: Floats, reach: float, found: Ints) -> int:
    """The points whose leaves' boxes come within reach of a segment, filled into `found`: all near it, and a few more.

    Args:
        tree: The points.
        start: (3,) where the segment starts.
        axis: (3,) from there to its end.
        reach: How near.
        found: (N,) filled with the points' numbers, in the tree's order.

    Returns:
        How many were filled in.
    """
    leaves, count = len(tree.box) // 2, 0
    # Depth first: each level leaves one node waiting at most.
    stack, size = np.empty(64, np.int64), 1
    stack[0] = 1
    while size:
        size -= 1
        node = stack[size]
        if _misses(tree.box, node, start, axis, reach):
            continue
        if node < leaves:
            stack[size], stack[size + 1] = 2 * node + 1, 2 * node
            size += 2
            continue
        for m in range((node - leaves) * LEAF, min((node - leaves + 1) * LEAF, len(tree.order))):
            found[count] = tree.order[m]
            count += 1
    return count


@kernel
def _misses(box: Floats, node: int, start: Floats, axis: Floats, reach: float) -> bool:
    """Whether a segment passes a node's box, that much larger on all sides, by."""
    enters, leaves = 0.0, 1.0
    for k in range(3):
        low, high = box[node, k] - reach - start[k], box[node, 3 + k] + reach - start[k]
        if axis[k] == 0.0:
            if low > 0.0 or high < 0.0:
                return True
            continue
        first, last = low / axis[k], high / axis[k]
        enters, leaves = max(enters, min(first, last)), min(leaves, max(first, last))
    # Not strictly: rounding must lose nothing.
    return enters > leaves + 1e-9
