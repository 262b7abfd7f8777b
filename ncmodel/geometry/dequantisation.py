"""Heights that were rounded to whole levels -> a smooth surface that they may have been.

Rounding turns slopes into terraces. What was there before is known but for half a level up and down; of all surfaces
within that the one that bends least is sought: argmin sum_v (L h)_v^2, a thin plate between bounds. L is the Laplacian
with cotangent weights in the plane below the heights, so that inclined planes don't bend; on a border, and beside a
cliff, a plate bends freely.

It is found from wide forms to narrow ones: terraces are wide where slopes are gentle, so means over squares of 2^n
vertices are smoothed first, and each result is where the next finer one starts. Each time that is an accelerated
projected gradient (Beck and Teboulle 2009) with a fixed number of rounds. On the mesh itself heights may leave their
bounds by as much again: a plate that rests on one has a kink in its curvature there, which would be drawn.
"""

import math

import numpy as np

from ncmodel.geometry.adjacency import Offsets, Rings
from ncmodel.geometry.normals_areas import Indices, check_columns
from ncmodel.jit import kernel
from ncmodel.types import Floats, Mask

HALF = 0.5
"""Levels that rounding moves a height at most."""
SLACK = 0.1
"""Levels by which the mean height of a square with one step in it may be beyond that of its middle."""
ROUNDS = 150
"""Of smoothing, at each width."""
STEP = 0.25
"""Of the gradient: L^T L has no eigenvalue above 4 where no weight is negative."""
NARROWEST = 6
"""Squares along the shorter side of the coarsest grid."""
EMPTY = np.inf
"""The height of squares without vertices."""


def dequantised(levels: Floats, plan: Floats, rings: Rings, sloping: Mask) -> Floats:
    """Smooth heights within one level of those given.

    Args:
        levels: (V,) whole heights.
        plan: (V, 2) where each vertex lies, seen from above.
        rings: Which corners meet at each vertex.
        sloping: (F,) the faces of the surface to be smoothed, which must not fold over each other seen from above;
            the vertices of no such face keep their heights.

    Returns:
        (V,) heights in levels.
    """
    starts, neighbours, weights, moving = _laplacian(plan, *rings, sloping)
    chosen = np.flatnonzero(moving)
    heights = levels.copy()
    heights[chosen] = _wide_forms(levels[chosen], plan[chosen])
    return np.asarray(_smoothed(heights, levels, starts, neighbours, weights, moving))


def _wide_forms(levels: Floats, plan: Floats) -> Floats:
    """(n,) heights without what is as narrow as the distance between vertices."""
    corner = plan.min(axis=0)
    extent = plan.max(axis=0) - corner
    spacing = math.sqrt(float(extent[0] * extent[1]) / len(plan))
    doublings = max(1, int(math.log2(float(extent.min()) / spacing / NARROWEST)))
    place = (plan - corner) / (spacing * 2.0**doublings)
    low, high = _bounds(levels, place)
    grid = _smoothed_grid(np.where(low < EMPTY, (low + high) / 2.0, EMPTY), low, high)
    for _ in range(doublings - 1):
        place *= 2.0
        low, high = _bounds(levels, place)
        centres = np.ascontiguousarray(np.indices(low.shape).reshape(2, -1).T / 2.0 + 0.25)
        start = _sampled(grid, centres, low.ravel(), high.ravel()).reshape(low.shape)
        grid = _smoothed_grid(start, low, high)
    return np.asarray(_sampled(grid, place, levels - 2.0 * HALF, levels + 2.0 * HALF))


@kernel
def _bounds(levels: Floats, place: Floats) -> tuple[Floats, Floats]:
    """The least and the greatest height that the centre of each square may have; `EMPTY` without vertices.

    Args:
        levels: (n,).
        place: (n, 2) in squares, at least 0.
    """
    check_columns(place, 2)
    rows, columns = int(place[:, 0].max()) + 1, int(place[:, 1].max()) + 1
    count, mean = np.zeros((rows, columns)), np.zeros((rows, columns))
    beside = np.zeros((rows, columns, 2))
    lowest, highest = np.full((rows, columns), np.inf), np.full((rows, columns), -np.inf)
    for n in range(len(place)):
        i, j = int(place[n, 0]), int(place[n, 1])
        count[i, j] += 1.0
        mean[i, j] += levels[n]
        beside[i, j, 0] += place[n, 0] - i - 0.5
        beside[i, j, 1] += place[n, 1] - j - 0.5
        lowest[i, j], highest[i, j] = min(lowest[i, j], levels[n]), max(highest[i, j], levels[n])
    mean /= np.maximum(count, 1.0)
    low, high = np.full((rows, columns), EMPTY), np.full((rows, columns), EMPTY)
    for i in range(rows):
        for j in range(columns):
            if count[i, j] == 0.0:
                continue
            # The vertices' middle is beside the square's, and the height there another where the ground slopes.
            up, down, left, right = max(i - 1, 0), min(i + 1, rows - 1), max(j - 1, 0), min(j + 1, columns - 1)
            value = mean[i, j]
            if count[up, j] > 0.0 and count[down, j] > 0.0:
                value -= (mean[down, j] - mean[up, j]) / max(down - up, 1) * beside[i, j, 0] / count[i, j]
            if count[i, left] > 0.0 and count[i, right] > 0.0:
                value -= (mean[i, right] - mean[i, left]) / max(right - left, 1) * beside[i, j, 1] / count[i, j]
            steps = highest[i, j] - lowest[i, j]
            if steps == 1.0:
                # The step runs near the square's middle, where the height is between the levels.
                between = lowest[i, j] + HALF
                low[i, j], high[i, j] = min(value, between) - SLACK, max(value, between) + SLACK
            else:
                # Errors of rounding cancel out over several levels.
                low[i, j], high[i, j] = value - HALF / (1.0 + steps), value + HALF / (1.0 + steps)
    return low, high


@kernel
def _sampled(grid: Floats, place: Floats, low: Floats, high: Floats) -> Floats:
    """(n,) a grid's values at places (in squares), linear between the squares' centres, within bounds."""
    check_columns(place, 2)
    result = np.empty(len(place))
    for n in range(len(place)):
        x, y = place[n, 0] - 0.5, place[n, 1] - 0.5
        i, j = int(np.floor(x)), int(np.floor(y))
        total, weight = 0.0, 0.0
        for a in (i, i + 1):
            for b in (j, j + 1):
                if 0 <= a < grid.shape[0] and 0 <= b < grid.shape[1] and grid[a, b] < EMPTY:
                    share = (1.0 - abs(x - a)) * (1.0 - abs(y - b))
                    total += share * grid[a, b]
                    weight += share
        value = total / weight if weight > 0.0 else (low[n] + high[n]) / 2.0
        result[n] = min(max(value, low[n]), high[n]) if low[n] < EMPTY else EMPTY
    return result


@kernel
def _smoothed_grid(start: Floats, low: Floats, high: Floats) -> Floats:
    """A grid of heights that bends least within its bounds."""
    rows, columns = start.shape
    inside = np.zeros((rows, columns), np.bool_)
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            filled = max(low[i - 1, j], low[i + 1, j], low[i, j - 1], low[i, j + 1], low[i, j]) < EMPTY
            inside[i, j] = filled
    # With a border of squares that don't bend, so that each has four neighbours.
    now, ahead, bend = start.copy(), start.copy(), np.zeros((rows + 2, columns + 2))
    momentum = 1.0
    for _ in range(ROUNDS):
        for i in range(1, rows - 1):
            for j in range(1, columns - 1):
                if inside[i, j]:
                    around = ahead[i - 1, j] + ahead[i + 1, j] + ahead[i, j - 1] + ahead[i, j + 1]
                    bend[i + 1, j + 1] = around / 4.0 - ahead[i, j]
        following = (1.0 + np.sqrt(1.0 + 4.0 * momentum * momentum)) / 2.0
        push = (momentum - 1.0) / following
        momentum = following
        for i in range(rows):
            for j in range(columns):
                if low[i, j] < EMPTY:
                    around = bend[i, j + 1] + bend[i + 2, j + 1] + bend[i + 1, j] + bend[i + 1, j + 2]
                    value = ahead[i, j] - STEP * (around / 4.0 - bend[i + 1, j + 1])
                    value = min(max(value, low[i, j]), high[i, j])
                    ahead[i, j] = value + push * (value - now[i, j])
                    now[i, j] = value
    return now


@kernel
def _smoothed(
    start: Floats, levels: Floats, starts: Offsets, neighbours: Indices, weights: Floats, moving: Mask
) -> Floats:
    """Heights of vertices that bend less, within one level of those given; the arrays are those of `_laplacian`."""
    count = len(start)
    now, ahead, bend = start.copy(), start.copy(), np.zeros(count)
    momentum = 1.0
    for _ in range(ROUNDS):
        for v in range(count):
            if starts[v] < starts[v + 1]:
                around = 0.0
                for n in range(starts[v], starts[v + 1]):
                    around += weights[n] * ahead[neighbours[n]]
                bend[v] = around - ahead[v]
        following = (1.0 + np.sqrt(1.0 + 4.0 * momentum * momentum)) / 2.0
        push = (momentum - 1.0) / following
        momentum = following
        for v in range(count):
            if moving[v]:
                ahead[v] += STEP * bend[v]
        for v in range(count):
            for n in range(starts[v], starts[v + 1]):
                ahead[neighbours[n]] -= STEP * weights[n] * bend[v]
        for v in range(count):
            if moving[v]:
                value = min(max(ahead[v], levels[v] - 2.0 * HALF), levels[v] + 2.0 * HALF)
                ahead[v] = value + push * (value - now[v])
                now[v] = value
    return now


@kernel
def _laplacian(
    plan: Floats, starts: Offsets, around: Indices, face: Indices, sloping: Mask
) -> tuple[Offsets, Indices, Floats, Mask]:
    """The neighbours of vertices inside the sloping surface and their weights, of a sum of 1.

    Returns:
        Where the rows of each vertex start, the neighbours, their weights; (V,) whether a vertex is of the surface.
    """
    check_columns(plan, 2)
    check_columns(around, 2)
    count = len(starts) - 1
    first, moving = np.zeros(count + 1, np.int32), np.zeros(count, np.bool_)
    neighbours, weights, found = np.empty(2 * len(face), np.uint32), np.empty(2 * len(face)), 0
    slot, seen_by = np.zeros(count, np.int64), np.full(count, -1)
    for v in range(count):
        total, turn, begin = 0.0, 0.0, found
        for n in range(starts[v], starts[v + 1]):
            if not sloping[face[n]]:
                continue
            moving[v] = True
            i, j = around[n, 0], around[n, 1]
            ax, ay = plan[i, 0] - plan[v, 0], plan[i, 1] - plan[v, 1]
            bx, by = plan[j, 0] - plan[v, 0], plan[j, 1] - plan[v, 1]
            area = abs(ax * by - ay * bx)
            turn += np.arctan2(area, ax * bx + ay * by)
            # The cotangent of the angle across from each side; a negative one has no place in a mean.
            for w, cotangent in (
                (i, (bx * (bx - ax) + by * (by - ay)) / area),
                (j, (ax * (ax - bx) + ay * (ay - by)) / area),
            ):
                if cotangent > 0.0:
                    if seen_by[w] != v:
                        seen_by[w] = v
                        slot[w], neighbours[found], weights[found] = found, w, 0.0
                        found += 1
                    weights[slot[w]] += cotangent
                    total += cotangent
        if turn < 2.0 * math.pi - 1e-3 or total == 0.0:
            found = begin
        for n in range(begin, found):
            weights[n] /= total
        first[v + 1] = found
    return first, neighbours[:found].copy(), weights[:found].copy(), moving
