"""The order in which a plotter's pen draws strokes: from each one to the nearest that is left."""

from collections.abc import Sequence

import numpy as np

from ncmodel.types import Floats, Stroke

BRANCHES = 4
"""Entries in a node of the tree of ends: the fewer, the quicker one is taken out."""


def pen_order(strokes: Sequence[Stroke]) -> tuple[Stroke, ...]:
    """The strokes in an order, and each in a direction, that keeps the pen's way in the air short.

    From the origin, the nearest end of a stroke not drawn yet is next; of equally near ones, the first.
    """
    if not strokes:
        return ()
    return tuple(
        strokes[i].reversed() if back else strokes[i]
        for i, back in _nearest_next(np.array([stroke.points[[0, -1]] for stroke in strokes]))
    )


def _nearest_next(ends: Floats) -> list[tuple[int, bool]]:
    """Greedy tour from the origin over strokes with ends (N, 2, 2): which is next, and whether backwards."""
    from rtree.index import Index, Property

    points = ends.reshape(-1, 2).tolist()
    tree = Index(
        ((number, (x, y, x, y), None) for number, (x, y) in enumerate(points)),
        properties=Property(leaf_capacity=BRANCHES, index_capacity=BRANCHES),
    )
    tour: list[tuple[int, bool]] = []
    x, y = 0.0, 0.0
    for _ in range(len(ends)):
        end = min(tree.nearest((x, y, x, y), 1))
        tour.append((end // 2, end % 2 == 1))
        for drawn in (end, end ^ 1):
            x, y = points[drawn]
            tree.delete(drawn, (x, y, x, y))
    return tour
