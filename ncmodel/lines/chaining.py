"""Loose segments joined into chains through the points that they share.

Segments of a line meet at points that neighbouring faces compute on their own, equal up to rounding. Such points are
matched on a grid much finer than a pixel; where more than two segments meet, the straightest pairs are joined.
"""

import math
from dataclasses import dataclass

import numpy as np

from ncmodel.geometry.adjacency import components
from ncmodel.jit import kernel
from ncmodel.mesh.weld import coincident, rounding
from ncmodel.types import Floats, Ints, Mask

SHARPEST_TURN = 0.0
"""At junctions, segments are joined if the cosine of the turn between them is above this."""
CROWD = 16
"""Where more ends than this meet in one point, there is no telling which goes on where: none are joined."""


@dataclass(frozen=True, eq=False)
class Chains:
    """Segments in chains, each running on from the one before it.

    Attributes:
        segment: (M,) indices of segments, chain after chain; duplicates and segments of no length are absent.
        flipped: (M,) True where the segment is passed from its second point to its first.
        first: (C + 1,) where each chain starts in `segment`; the last entry is M.
    """

    segment: Ints
    flipped: Mask
    first: Ints

    def __len__(self) -> int:
        return len(self.first) - 1


def chain(points: Floats) -> Chains:
    """Chain segments through shared end points.

    Args:
        points: (S, 2, D) end points; D = 3 in space, 2 on the picture plane.

    Returns:
        Chains as long as they get: they end only at free ends and at junctions with no straight way on.
    """
    if len(points) == 0:
        return Chains(np.empty(0, np.int64), np.empty(0, np.bool_), np.zeros(1, np.int64))
    nodes = shared_ends(points)
    kept = _distinct(nodes)
    partner = _link(nodes[kept].ravel(), np.ascontiguousarray(points[kept]))
    segment, flipped, first = _trace(partner)
    return Chains(kept[segment], flipped, first)


def connected(points: Floats) -> Ints:
    """(S,) a number for each of (S, 2, D) segments, equal for those that are connected through shared end points."""
    if len(points) == 0:
        return np.empty(0, np.int64)
    nodes = shared_ends(points)
    return np.asarray(components(nodes, nodes.size)[nodes[:, 0]])


def shared_ends(points: Floats) -> Ints:
    """(S, 2) a number for each end of (S, 2, D) segments, equal for ends that are one up to rounding."""
    ends = points.reshape(-1, points.shape[2])
    return coincident(ends, rounding(ends)).reshape(-1, 2)


def _distinct(nodes: Ints) -> Ints:
    """Indices of the segments that have a length and repeat no earlier one."""
    ordered = np.sort(nodes, axis=1)
    key = ordered[:, 0] * (int(nodes.max()) + 1) + ordered[:, 1]
    first = np.unique(key, return_index=True)[1]
    first.sort()
    kept: Ints = first[ordered[first, 0] != ordered[first, 1]]
    return kept


def _link(ends: Ints, points: Floats) -> Ints:
    """(2S,) for each segment end (2s + 0 or 1) the end of another segment that it is joined to, or -1."""
    order = np.argsort(ends, kind="stable")
    return _pair(ends[order], order, points)


@kernel
def _pair(sorted_nodes: Ints, order: Ints, points: Floats) -> Ints:
    partner = np.full(len(order), -1)
    start = 0
    while start < len(order):
        stop = start + 1
        while stop < len(order) and sorted_nodes[stop] == sorted_nodes[start]:
            stop += 1
        if stop - start == 2:
            partner[order[start]], partner[order[start + 1]] = order[start + 1], order[start]
        elif stop - start > 2:
            _pair_straightest(order[start:stop], points, partner)
        start = stop
    return partner


@kernel
def _pair_straightest(ends: Ints, points: Floats, partner: Ints) -> None:
    """Join the ends that meet in one point, the straightest pair first."""
    if len(ends) > CROWD:
        return
    while True:
        best, a, b = SHARPEST_TURN, -1, -1
        for i in ends:
            for j in ends:
                if i < j and partner[i] < 0 and partner[j] < 0 and i // 2 != j // 2:
                    straight = _straightness(points, i, j)
                    if straight > best:
                        best, a, b = straight, i, j
        if a < 0:
            return
        partner[a], partner[b] = b, a


@kernel
def _straightness(points: Floats, i: int, j: int) -> float:
    """Cosine of the turn when passing from the segment of end i to that of end j."""
    product, first, second = 0.0, 0.0, 0.0
    for k in range(points.shape[2]):
        a = points[i // 2, i % 2, k] - points[i // 2, 1 - i % 2, k]
        b = points[j // 2, 1 - j % 2, k] - points[j // 2, j % 2, k]
        product += a * b
        first += a * a
        second += b * b
    return product / max(math.sqrt(first * second), 1e-300)


@kernel
def _trace(partner: Ints) -> tuple[Ints, Mask, Ints]:
    """Walk the links: open chains from their free ends first, then the loops."""
    count = len(partner) // 2
    segment, flipped = np.empty(count, np.int64), np.empty(count, np.bool_)
    first = np.zeros(count + 1, np.int64)
    done = np.zeros(count, np.bool_)
    filled, chains = 0, 0
    for loops in (False, True):
        for end in range(2 * count):
            if done[end // 2] or not (loops or partner[end] < 0):
                continue
            at = end
            while at >= 0 and not done[at // 2]:
                done[at // 2] = True
                segment[filled], flipped[filled] = at // 2, at % 2 == 1
                filled += 1
                at = partner[at ^ 1]
            chains += 1
            first[chains] = filled
    return segment, flipped, first[: chains + 1]
