"""The order in which a plotter's pen draws strokes: from each one to the nearest that is left.

The ends of strokes lie in a balanced k-d tree whose nodes count what is left below them, so that finding the next end
and striking it out take about the logarithm of their number, however they are spread.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, Mask, Stroke

LEAF = 8
"""Ends in a leaf of the tree, at most."""


def pen_order(strokes: Sequence[Stroke]) -> tuple[Stroke, ...]:
    """The strokes in an order, and each in a direction, that keeps the pen's way in the air short.

    From the origin, the nearest end of a stroke not drawn yet is next.
    """
    if not strokes:
        return ()
    ends = np.array([stroke.points[[0, -1]] for stroke in strokes])
    order, reverse = _nearest_next(ends.reshape(-1, 2))
    return tuple(
        replace(strokes[i], points=strokes[i].points[::-1], alpha=strokes[i].alpha[::-1]) if back else strokes[i]
        for i, back in zip(order.tolist(), reverse.tolist(), strict=True)
    )


@kernel
def _nearest_next(ends: Floats) -> tuple[Ints, Mask]:
    """Greedy tour over strokes with ends 2i and 2i + 1, from the origin: the order, and which are drawn backwards."""
    count = len(ends) // 2
    item, boxes, left = _tree(ends)
    place = np.empty(len(ends), np.int64)
    place[item] = np.arange(len(ends))
    drawn = np.zeros(count, np.bool_)
    order, reverse = np.empty(count, np.int64), np.empty(count, np.bool_)
    x, y = 0.0, 0.0
    for n in range(count):
        end = _nearest(ends, item, boxes, left, drawn, x, y)
        order[n], reverse[n] = end // 2, end % 2 == 1
        drawn[order[n]] = True
        x, y = ends[end ^ 1]
        _strike(left, place[end], len(ends))
        _strike(left, place[end ^ 1], len(ends))
    return order, reverse


@kernel
def _tree(points: Floats) -> tuple[Ints, Floats, Ints]:
    """A balanced tree over (N, 2) points: node i has the children 2i + 1 and 2i + 2, each with half of its items.

    Returns:
        The points' numbers in the order of the leaves; each node's (4,) box, low x, low y, high x, high y; how many
        points it has.
    """
    item = np.arange(len(points))
    nodes = 1
    while nodes * LEAF < len(points):
        nodes *= 2
    boxes, left = np.empty((2 * nodes, 4)), np.zeros(2 * nodes, np.int64)
    stack = [(0, 0, len(points))]
    while stack:
        node, first, last = stack.pop()
        inside = points[item[first:last]]
        x, y = inside[:, 0], inside[:, 1]
        boxes[node] = np.array([x.min(), y.min(), x.max(), y.max()])
        left[node] = last - first
        if last - first > LEAF:
            wide = boxes[node, 2] - boxes[node, 0] >= boxes[node, 3] - boxes[node, 1]
            item[first:last] = item[first:last][np.argsort(x if wide else y, kind="mergesort")]
            middle = (first + last) // 2
            stack.append((2 * node + 1, first, middle))
            stack.append((2 * node + 2, middle, last))
    return item, boxes, left


@kernel
def _nearest(ends: Floats, item: Ints, boxes: Floats, left: Ints, drawn: Mask, x: float, y: float) -> int:
    """The end nearest to (x, y) of a stroke not drawn yet; there is one."""
    best, found = np.inf, -1
    stack = [(0, 0, len(ends), 0.0)]
    while stack:
        node, first, last, off = stack.pop()
        if left[node] == 0 or off >= best:
            continue
        if last - first <= LEAF:
            for end in item[first:last]:
                square = (ends[end, 0] - x) ** 2 + (ends[end, 1] - y) ** 2
                if square < best and not drawn[end // 2]:
                    best, found = square, end
            continue
        middle = (first + last) // 2
        near, far = (2 * node + 1, first, middle), (2 * node + 2, middle, last)
        a, b = _squared_distance(boxes[near[0]], x, y), _squared_distance(boxes[far[0]], x, y)
        if b < a:
            near, far, a, b = far, near, b, a
        stack.append((far[0], far[1], far[2], b))
        stack.append((near[0], near[1], near[2], a))
    return found


@kernel
def _squared_distance(box: Floats, x: float, y: float) -> float:
    """From a point to a box."""
    dx = max(box[0] - x, 0.0, x - box[2])
    dy = max(box[1] - y, 0.0, y - box[3])
    return float(dx * dx + dy * dy)


@kernel
def _strike(left: Ints, place: int, count: int) -> None:
    """Take the item at a place in the order of leaves out of the counts of all nodes above it."""
    node, first, last = 0, 0, count
    left[0] -= 1
    while last - first > LEAF:
        middle = (first + last) // 2
        if place < middle:
            node, last = 2 * node + 1, middle
        else:
            node, first = 2 * node + 2, middle
        left[node] -= 1
