"""How lines on the picture go on beyond their ends, and what they meet there.

Arrays in, arrays out: lines are points, one line after the other, and end 2c is the first point of line c, end 2c + 1
its last one.
"""

import math

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints

STRAIGHT = 0.9
"""Least cosine between the ways of two ends, and between each and the gap."""
CROSSWISE = 0.3
"""Least sine between the ways of two ends that meet in a corner."""


@kernel
def boxes(points: Floats, first: Ints, margin: float) -> Floats:
    """(C, 4) left, top, right and bottom of each stroke, with a margin; what lies outside is near no point of it."""
    found = np.empty((len(first) - 1, 4))
    for c in range(len(found)):
        x, y = points[first[c] : first[c + 1], 0], points[first[c] : first[c + 1], 1]
        found[c] = x.min() - margin, y.min() - margin, x.max() + margin, y.max() + margin
    return found


@kernel
def inside(points: Floats, steps: Floats, first: Ints, reach: float) -> Floats:
    """(2C, 2) the points that lie some pixels from both ends of each stroke, or at its other end."""
    found = np.empty((2 * (len(first) - 1), 2))
    for end in range(len(found)):
        begin, last = first[end // 2], first[end // 2 + 1] - 1
        at, inwards = (begin, 1) if end % 2 == 0 else (last, -1)
        left = reach
        for _ in range(last - begin - 1):
            step = steps[max(at, at + inwards)]
            if step >= left:
                break
            left -= step
            at += inwards
        share = min(left / max(steps[max(at, at + inwards)], 1e-12), 1.0)
        for axis in range(2):
            found[end, axis] = points[at, axis] + share * (points[at + inwards, axis] - points[at, axis])
    return found


@kernel
def continuing(
    point: Floats, way: Floats, length: Floats, order: Ints, pixels: float, touching: float
) -> tuple[Ints, Ints, Floats]:
    """Pairs of ends that continue each other on the picture, and how far apart they are.

    Args:
        point: (E, 3) ends of strokes.
        way: (E, 2) where they go on.
        length: (E,) of their strokes.
        order: The ends from left to right.
        pixels: The longest gap; a stroke bridges none that is longer than itself.
        touching: Ends that are nearer have no way between them.
    """
    one, other, cost = [np.int64(0) for _ in range(0)], [np.int64(0) for _ in range(0)], [0.0 for _ in range(0)]
    for m in range(len(order)):
        i = order[m]
        for n in range(m + 1, len(order)):
            j = order[n]
            x, y = point[j, 0] - point[i, 0], point[j, 1] - point[i, 1]
            if x > pixels:
                break
            gap = np.hypot(x, y)
            if gap > pixels or gap > min(length[i], length[j]) / (2.0 if i // 2 == j // 2 else 1.0):
                continue
            if way[i, 0] * way[j, 0] + way[i, 1] * way[j, 1] > -STRAIGHT:
                continue
            if gap > touching:
                ahead = min(x * way[i, 0] + y * way[i, 1], -x * way[j, 0] - y * way[j, 1])
                if ahead < STRAIGHT * gap:
                    continue
            one.append(i)
            other.append(j)
            cost.append(gap)
    return np.array(one), np.array(other), np.array(cost)


@kernel
def crossings(
    point: Floats, way: Floats, length: Floats, free: Ints, pixels: float
) -> tuple[Ints, Ints, Floats, Floats]:
    """Pairs of free ends whose ways cross ahead of both: (n,), (n,), where (n, 3), and how far ahead (n,)."""
    one, other = [np.int64(0) for _ in range(0)], [np.int64(0) for _ in range(0)]
    place, cost = [0.0 for _ in range(0)], [0.0 for _ in range(0)]
    for m in range(len(free)):
        i = free[m]
        for n in range(m + 1, len(free)):
            j = free[n]
            x, y = point[j, 0] - point[i, 0], point[j, 1] - point[i, 1]
            if max(abs(x), abs(y)) > 2.0 * pixels:
                continue
            across = way[i, 0] * way[j, 1] - way[i, 1] * way[j, 0]
            if i // 2 == j // 2 or math.hypot(x, y) > 2.0 * pixels or abs(across) < CROSSWISE:
                continue
            ahead = (x * way[j, 1] - y * way[j, 0]) / across
            there = (x * way[i, 1] - y * way[i, 0]) / across
            if min(ahead, there) > 0.0 and ahead <= min(pixels, length[i]) and there <= min(pixels, length[j]):
                one.append(i)
                other.append(j)
                # Halfway on the arc (a quadratic Bezier curve) that goes on from one end to the other.
                place.append(point[i, 0] + x / 4.0 + ahead * way[i, 0] / 2.0)
                place.append(point[i, 1] + y / 4.0 + ahead * way[i, 1] / 2.0)
                place.append((point[i, 2] + point[j, 2]) / 2.0)
                cost.append(max(ahead, there))
    return np.array(one), np.array(other), np.array(place).reshape(-1, 3), np.array(cost)


@kernel
def ahead_of(
    point: Floats, way: Floats, length: Floats, free: Ints, points: Floats, depth: Floats, first: Ints, pixels: float
) -> tuple[Ints, Floats]:
    """The free ends that meet another stroke, or its end, if they go on: (n,) and where: (n, 3)."""
    end, place = [np.int64(0) for _ in range(0)], [0.0 for _ in range(0)]
    box = boxes(points, first, pixels)
    for i in free:
        nearest, at = min(pixels, length[i]), (0.0, 0.0, 0.0)
        u, v = way[i, 0], way[i, 1]
        found = False
        for c in range(len(first) - 1):
            x, y = point[i, 0], point[i, 1]
            if c == i // 2 or x < box[c, 0] or y < box[c, 1] or x > box[c, 2] or y > box[c, 3]:
                continue
            for n in (first[c], first[c + 1] - 1):
                x, y = points[n, 0] - point[i, 0], points[n, 1] - point[i, 1]
                gap = math.hypot(x, y)
                if gap < nearest and u * x + v * y > STRAIGHT * gap:
                    nearest, found, at = gap, True, (points[n, 0], points[n, 1], depth[n])
            for n in range(first[c] + 1, first[c + 1]):
                x, y = points[n - 1, 0] - point[i, 0], points[n - 1, 1] - point[i, 1]
                dx, dy = points[n, 0] - points[n - 1, 0], points[n, 1] - points[n - 1, 1]
                before, after = u * y - v * x, u * (y + dy) - v * (x + dx)
                if before * after > 0.0 or before == after:
                    continue
                share = before / (before - after)
                ahead = u * (x + share * dx) + v * (y + share * dy)
                if 0.0 < ahead < nearest:
                    nearest, found = ahead, True
                    z = depth[n - 1] + share * (depth[n] - depth[n - 1])
                    at = (points[n - 1, 0] + share * dx, points[n - 1, 1] + share * dy, z)
        if found:
            end.append(i)
            place += [at[0], at[1], at[2]]
    return np.array(end), np.array(place).reshape(-1, 3)


@kernel
def matched(one: Ints, other: Ints, count: int) -> Ints:
    """(count,) for each end the one it is joined to, or -1: pairs are taken in their order, each end once."""
    partner = np.full(count, -1)
    for k in range(len(one)):
        if partner[one[k]] < 0 and partner[other[k]] < 0:
            partner[one[k]], partner[other[k]] = other[k], one[k]
    return partner
