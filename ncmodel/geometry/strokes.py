"""From loose segments to long strokes: chained through shared points, simplified.

Segments of a line meet at points that neighbouring faces compute on their own, equal up to rounding. Such points are
matched on a grid much finer than a pixel; where more than two segments meet, the straightest pairs are joined.
"""

import math
from dataclasses import dataclass

import numpy as np

from ncmodel.camera import Camera
from ncmodel.geometry.retraced import without_retraced
from ncmodel.geometry.union_find import root
from ncmodel.kernels import kernel
from ncmodel.types import Floats, Ints, Mask, Segments, Stroke

TOLERANCE = 0.25
"""Pixels that a stroke may stray from its segments, unless told otherwise."""

WELD = 2.0**-20
"""Points that share a grid cell of this size, relative to the points' extent, are one point."""
SHARPEST_TURN = 0.0
"""At junctions, segments are joined if the cosine of the turn between them is above this."""
CROWD = 16
"""Where more ends than this meet in one point, there is no telling which goes on where: none are joined."""
DOT = 0.01
"""Pixels; shorter strokes (edges seen end-on) have no length where coordinates are written in hundredths."""
ALPHA_TOLERANCE = 0.02
"""Opacity may be off by this much after simplification."""


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
    nodes = weld_points(points.reshape(-1, points.shape[2])).reshape(-1, 2)
    kept = _distinct(nodes)
    partner = _link(nodes[kept].ravel(), np.ascontiguousarray(points[kept]))
    segment, flipped, first = _trace(partner)
    return Chains(kept[segment], flipped, first)


def connected(points: Floats) -> Ints:
    """(S,) a number for each of (S, 2, D) segments, equal for those that are connected through shared end points."""
    if len(points) == 0:
        return np.empty(0, np.int64)
    nodes = weld_points(points.reshape(-1, points.shape[2]))
    segment = np.repeat(np.arange(len(points)), 2)
    return np.asarray(_joined(segment, nodes)[::2])


def weld_points(points: Floats) -> Ints:
    """(N,) a number for each of (N, D) points, D <= 3, equal for points that coincide up to rounding."""
    low = points.min(axis=0)
    cell = max(float((points.max(axis=0) - low).max()), 1e-300) * WELD
    aligned, shifted = (_cells((points - low) / cell + shift) for shift in (0.0, 0.5))
    # Two grids, half a cell apart: a pair that one of them parts, the other holds together.
    return _joined(aligned, shifted)


def _cells(scaled: Floats) -> Ints:
    """(N,) dense numbers of the grid cells that the points fall in."""
    key = np.zeros(len(scaled), dtype=np.int64)
    for axis in range(scaled.shape[1]):
        key = (key << 21) + scaled[:, axis].astype(np.int64)
    number: Ints = np.unique(key, return_inverse=True)[1]
    return number


@kernel
def _joined(aligned: Ints, shifted: Ints) -> Ints:
    """Numbers in which points are equal that share a number in either argument, or are linked by such points."""
    parent = np.arange(aligned.max() + 1)
    owner = np.full(shifted.max() + 1, -1)
    for i in range(len(aligned)):
        if owner[shifted[i]] < 0:
            owner[shifted[i]] = aligned[i]
        a, b = root(parent, aligned[i]), root(parent, owner[shifted[i]])
        parent[max(a, b)] = min(a, b)
    number = np.empty(len(aligned), np.int64)
    for i in range(len(aligned)):
        number[i] = root(parent, aligned[i])
    return number


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


def strokes(
    segments: Segments, camera: Camera, tolerance: float = TOLERANCE, shortest: float = 0.0
) -> tuple[Stroke, ...]:
    """Long strokes on the picture plane from visible segments.

    Args:
        segments: Pieces of lines in front of the camera, in object space.
        camera: Where they are seen from.
        tolerance: How far, in pixels, a stroke may stray from its segments; 0 keeps every point.
        shortest: Pixels; shorter strokes are left out, as are those shorter than the tolerance that end on longer ones.
    """
    chains = chain(segments.points)
    if len(chains) == 0:
        return ()
    start, owner = chains.first, np.repeat(np.arange(len(chains)), np.diff(chains.first))
    # A chain of n segments has n + 1 points: where each of its segments starts, and where the last one ends.
    last = start[1:] - 1 + np.arange(1, len(chains) + 1)
    points, alpha = np.empty((last[-1] + 1, 3)), np.empty(last[-1] + 1)
    for values, source in ((points, segments.points), (alpha, segments.alpha)):
        values[np.arange(len(owner)) + owner] = source[chains.segment, chains.flipped.astype(np.int64)]
        ends = chains.first[1:] - 1
        values[last] = source[chains.segment[ends], 1 - chains.flipped[ends].astype(np.int64)]
    pixels = np.ascontiguousarray(camera.project(points)[:, :2])
    first = np.concatenate([[0], last + 1])
    kept = _simplify(pixels, alpha, first, tolerance, ALPHA_TOLERANCE if tolerance else 0.0)
    bounds = np.searchsorted(np.flatnonzero(kept), first)
    pixels, alpha = pixels[kept], alpha[kept]
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(pixels, axis=0), axis=1))])
    length = travelled[bounds[1:] - 1] - travelled[bounds[:-1]]
    drawn = (length >= max(shortest, DOT)) & ~_spurs(points, first, length < tolerance)
    found = [
        Stroke(segments.family.value, pixels[bounds[c] : bounds[c + 1]], alpha[bounds[c] : bounds[c + 1]])
        for c in np.flatnonzero(drawn).tolist()
    ]
    return without_retraced(found, min(tolerance, TOLERANCE))


def _spurs(points: Floats, first: Ints, short: Mask) -> Mask:
    """(C,) True for the `short` ones of polylines (points first[c] : first[c + 1]) that end on one that isn't short."""
    if not short.any() or short.all():
        return np.zeros(len(short), dtype=np.bool_)
    node = weld_points(points)
    taken = node[np.repeat(~short, np.diff(first))]
    return np.asarray(short & (np.isin(node[first[:-1]], taken) | np.isin(node[first[1:] - 1], taken)))


@kernel
def _simplify(points: Floats, alpha: Floats, first: Ints, tolerance: float, alpha_tolerance: float) -> Mask:
    """Douglas and Peucker's choice of points: True for the (N,) points that stay.

    Args:
        points: (N, 2) pixels, polyline after polyline.
        alpha: (N,) opacity.
        first: (C + 1,) where each polyline starts.
        tolerance: Pixels that a dropped point may lie off the line that replaces it.
        alpha_tolerance: How far its opacity may be off.
    """
    kept = np.zeros(len(points), np.bool_)
    for c in range(len(first) - 1):
        kept[first[c]] = kept[first[c + 1] - 1] = True
        spans = [(first[c], first[c + 1] - 1)]
        while spans:
            a, b = spans.pop()
            farthest, worst = -1, 1.0
            for i in range(a + 1, b):
                off, fade = _deviation(points, alpha, a, b, i)
                error = max(off / max(tolerance, 1e-12), fade / max(alpha_tolerance, 1e-12))
                if error > worst:
                    farthest, worst = i, error
            if farthest >= 0:
                kept[farthest] = True
                spans.append((a, farthest))
                spans.append((farthest, b))
    return kept


@kernel
def _deviation(points: Floats, alpha: Floats, a: int, b: int, i: int) -> tuple[float, float]:
    """How far point i is from the straight line a-b in pixels, and from its opacity there."""
    dx, dy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    x, y = points[i, 0] - points[a, 0], points[i, 1] - points[a, 1]
    along = min(max((x * dx + y * dy) / max(dx * dx + dy * dy, 1e-300), 0.0), 1.0)
    off = math.hypot(x - along * dx, y - along * dy)
    return off, abs(alpha[i] - alpha[a] - along * (alpha[b] - alpha[a]))
