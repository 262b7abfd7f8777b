"""Which corners of a polygon lie in a triangle: found by a tree of boxes, so that a polygon may have a million."""

from typing import NamedTuple

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints

LEAF = 8
"""Corners in a leaf."""
BITS = 16
"""Of each coordinate, for the order along the curve."""


class CornerTree(NamedTuple):
    """The corners of a polygon, in the order of a space-filling curve, in the leaves of a binary tree.

    Attributes:
        order: (n,) the corners along the curve.
        leaf: (n,) the node that each lies in.
        box: (2 leaves, 4) the lowest and the highest corner of the box around those of each node: node 1 is the root,
            2 n and 2 n + 1 are the children of node n, and the second half are the leaves.
        left: (2 leaves,) how many of a node's corners haven't been taken away.
        gone: (n,) which have.
    """

    order: Ints
    leaf: Ints
    box: Floats
    left: Ints
    gone: Ints


@kernel
def corner_tree(flat: Floats) -> CornerTree:
    """The tree of a polygon's corners (n, 2)."""
    leaves = 1
    while leaves * LEAF < len(flat):
        leaves *= 2
    box, left = np.empty((2 * leaves, 4)), np.zeros(2 * leaves, np.int64)
    box[:, :2], box[:, 2:] = np.inf, -np.inf
    order, leaf = np.argsort(_places(flat)), np.empty(len(flat), np.int64)
    for m in range(len(flat)):
        n, node = order[m], leaves + m // LEAF
        leaf[n] = node
        left[node] += 1
        for axis in range(2):
            box[node, axis] = min(box[node, axis], flat[n, axis])
            box[node, 2 + axis] = max(box[node, 2 + axis], flat[n, axis])
    for node in range(leaves - 1, 0, -1):
        left[node] = left[2 * node] + left[2 * node + 1]
        for axis in range(2):
            box[node, axis] = min(box[2 * node, axis], box[2 * node + 1, axis])
            box[node, 2 + axis] = max(box[2 * node, 2 + axis], box[2 * node + 1, 2 + axis])
    return CornerTree(order, leaf, box, left, np.zeros(len(flat), np.int64))


@kernel
def _places(flat: Floats) -> Ints:
    """(n,) each corner's place along Morton's curve."""
    place = np.zeros(len(flat), np.int64)
    size = max(np.ptp(flat[:, 0]), np.ptp(flat[:, 1]), 1e-300)
    for axis in range(2):
        low = flat[:, axis].min()
        for n in range(len(flat)):
            cell = np.int64((flat[n, axis] - low) / size * (2**BITS - 1))
            for bit in range(BITS):
                place[n] |= ((cell >> bit) & 1) << (2 * bit + axis)
    return place


@kernel
def take_away(tree: CornerTree, n: int) -> None:
    """Take a corner away, so that it isn't found any more."""
    tree.gone[n] = 1
    node = tree.leaf[n]
    while node:
        tree.left[node] -= 1
        node //= 2


@kernel
def corners_within(tree: CornerTree, flat: Floats, a: Floats, b: Floats, c: Floats, slack: float, looks: Ints) -> bool:
    """Whether a corner that is left lies in a triangle, but not at one of its own corners.

    Args:
        tree: Of the corners.
        flat: (n, 2) the corners.
        a: (2,) the triangle's corners, counter-clockwise.
        b: The second.
        c: The third.
        slack: Twice the area by which a corner may lie outside.
        looks: (1,) to which the number of corners and boxes that are looked at is added.
    """
    leaves = len(tree.left) // 2
    ax, ay, bx, by, cx, cy = a[0], a[1], b[0], b[1], c[0], c[1]
    # Depth first: each level leaves one node waiting at most.
    stack, size = np.empty(64, np.int64), 1
    stack[0] = 1
    while size:
        size -= 1
        node = stack[size]
        looks[0] += 1
        if tree.left[node] == 0:
            continue
        if (
            _beyond(tree.box, node, ax, ay, bx, by, slack)
            or _beyond(tree.box, node, bx, by, cx, cy, slack)
            or _beyond(tree.box, node, cx, cy, ax, ay, slack)
        ):
            continue
        if node < leaves:
            stack[size], stack[size + 1] = 2 * node + 1, 2 * node
            size += 2
            continue
        for m in range((node - leaves) * LEAF, min((node - leaves + 1) * LEAF, len(flat))):
            n = tree.order[m]
            x, y = flat[n, 0], flat[n, 1]
            if tree.gone[n] or (x == ax and y == ay) or (x == bx and y == by) or (x == cx and y == cy):
                continue
            looks[0] += 1
            turn = min(_turn(ax, ay, bx, by, x, y), _turn(bx, by, cx, cy, x, y), _turn(cx, cy, ax, ay, x, y))
            if turn >= -slack:
                return True
    return False


@kernel
def _beyond(box: Floats, node: int, ux: float, uy: float, vx: float, vy: float, slack: float) -> bool:
    """Whether a box lies beyond a side uv of a triangle; as rounding is monotonic, no corner inside it then doesn't."""
    x = box[node, 0] if vy - uy > 0 else box[node, 2]
    y = box[node, 3] if vx - ux > 0 else box[node, 1]
    return _turn(ux, uy, vx, vy, x, y) < -slack


@kernel
def _turn(ax: float, ay: float, bx: float, by: float, cx: float, cy: float) -> float:
    """Twice the signed area of triangle abc, positive when counter-clockwise."""
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


@kernel
def turn_of(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the signed area of the triangle of three points (2,), positive when counter-clockwise."""
    return float(_turn(a[0], a[1], b[0], b[1], c[0], c[1]))
