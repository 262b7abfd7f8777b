"""Which parts of lines on the picture run along other lines, and where what is left of them lies then.

Arrays in, arrays out: lines are points close to each other, one line after the other, the strongest claim first.
"""

import math
from typing import NamedTuple, Self

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints

BRANCH = 2.0
"""Pixels over which a line comes from another one that goes on beside it, for each pixel between both."""
STAYS, CRUMB, _DRAWN_IN = -1, -2, -3
"""What becomes of points that run along no stroke: they stay, or are too few, or lie on another stroke then."""
_ROW = 1 << 32
"""Larger than any square's row, for one number for column and row."""


class Squares(NamedTuple):
    """Points by the squares of the picture that they lie in.

    Attributes:
        side: Of the squares, pixels.
        keys: (N,) sorted numbers of the squares.
        sorting: (N,) the points in that order.
    """

    side: float
    keys: Ints
    sorting: Ints

    @classmethod
    def of(cls, points: Floats, side: float) -> Self:
        """Points (N, 2) in squares."""
        square = np.floor(points / side).astype(np.int64)
        key = square[:, 0] * _ROW + square[:, 1]
        sorting = np.argsort(key, kind="stable")
        return cls(side, key[sorting], sorting)


class Rule(NamedTuple):
    """When strokes run along each other.

    Attributes:
        spacing: Pixels between the points at which they are compared, at most.
        tolerance: Pixels between them, at most.
        parallel: Least cosine between their directions; others cross.
        shortest_run: Pixels; strokes that are close for a shorter stretch touch, or cross at a small angle.
        crumb: What remains between or beside such stretches has more such points than this, unless it bridges a gap.
        lead: Pixels over which a stroke comes from the one it ran along, for each pixel between them; 0 if it doesn't.
        fainter: A stroke stays if its opacity is above that of the other one by more than this.
    """

    spacing: float
    tolerance: float
    parallel: float = 0.97
    shortest_run: float = 4.0
    crumb: int = 2
    lead: float = 0.0
    fainter: float = 0.02


@kernel
def retraced(
    points: Floats, along: Floats, alpha: Floats, first: Ints, squares: Squares, whole: int, rims: int, rule: Rule
) -> tuple[Ints, Floats]:
    """(N,) for points on stretches that run along earlier strokes, a point that they pass; else what becomes of them.

    What goes is no reason for another one to go: of every two lines, one is drawn. And (N, 2) where all points are
    then: those that go lie where they pass the stroke that stays, and what is left of theirs comes from there.

    Args:
        points: (N, 2) pixels, stroke after stroke.
        along: (N, 2) directions of length 1.
        alpha: (N,) opacity.
        first: (C + 1,) where each stroke starts.
        squares: Where the points lie.
        whole: How many of the first strokes stay as they are.
        rims: How many of the first are outline.
        rule: When strokes run along each other.
    """
    found = np.full(len(points), STAYS)
    placed = points.copy()
    for c in range(whole, len(first) - 1):
        begin, end = first[c], first[c + 1]
        for i in range(begin, end):
            found[i] = _accompanied(points, placed, along, alpha, begin, squares, found, i, rule)
        start, length = begin, 0.0
        for i in range(begin, end + 1):
            if i < end and found[i] >= 0:
                if i > start:
                    length += math.hypot(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1])
                continue
            if length < rule.shortest_run and i - start < end - begin:
                found[start:i] = STAYS
            start, length = i + 1, 0.0
        start = begin
        for i in range(begin, end + 1):
            if i < end and found[i] == STAYS:
                continue
            short, part = 0 < i - start <= rule.crumb, i - start < end - begin
            near = short and _draw_in(points, placed, first, c, squares, found, start, i, rule.tolerance)
            if near:
                found[start:i] = _DRAWN_IN
            elif short and part and c >= rims and not _needed(found, first, c, start, i):
                found[start:i] = CRUMB
            elif part and rule.lead > 0.0:
                _lead(points, placed, found, first, c, start, i, rule.lead)
            start = i + 1
        if rule.lead > 0.0:
            for i in range(begin, end):
                if found[i] >= 0:
                    placed[i] = placed[found[i]]
    return found, placed


@kernel
def _needed(found: Ints, first: Ints, c: int, start: int, stop: int) -> bool:
    """Whether a short part of stroke c goes on from where one line ends to where another one begins."""
    if start == first[c] or stop == first[c + 1]:
        return False
    return not _are_close(first, found[start - 1], found[stop], stop - start + 2)


@kernel
def _are_close(first: Ints, one: int, other: int, count: int) -> bool:
    """Whether two points belong to one stroke, with not many more than `count` from one to the other."""
    same = np.searchsorted(first, one, side="right") == np.searchsorted(first, other, side="right")
    return bool(same and abs(one - other) <= 2 * count)


@kernel
def _lead(points: Floats, placed: Floats, found: Ints, first: Ints, c: int, start: int, stop: int, lead: float) -> None:
    """Place a part of stroke c so that it comes from the strokes that it ran along before and after.

    Where it is too short to be in its own place in between, it goes straight over from one shift to the other. Where it
    branches off from a stroke that goes on, it does so at once: nobody sees a kink, and both would run side by side.
    """
    begin, end = first[c], first[c + 1]
    length = 0.0
    for i in range(max(start, begin + 1), min(stop + 1, end)):
        length += math.hypot(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1])
    reach = np.zeros(2)
    shift = np.zeros((2, 2))
    for side, i in ((0, start - 1), (1, stop)):
        if begin <= i < end:
            shift[side] = placed[found[i]] - points[i]
            reach[side] = math.hypot(shift[side, 0], shift[side, 1])
            reach[side] *= lead if _ends_soon(found, first, found[i]) else BRANCH
    if reach[0] + reach[1] > length:
        reach[:] = length
    at = 0.0
    for i in range(start, stop):
        if i > begin:
            at += math.hypot(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1])
        before = max(1.0 - at / max(reach[0], 1e-12), 0.0)
        after = max(1.0 - (length - at) / max(reach[1], 1e-12), 0.0)
        placed[i] = points[i] + before * shift[0] + after * shift[1]


@kernel
def _ends_soon(found: Ints, first: Ints, j: int) -> bool:
    """Whether one of the next points before or after point j isn't part of what stays of its stroke."""
    c = np.searchsorted(first, j, side="right") - 1
    return bool(j - 3 < first[c] or j + 3 >= first[c + 1] or (found[j - 3 : j + 4] != STAYS).any())


@kernel
def _accompanied(
    points: Floats,
    placed: Floats,
    along: Floats,
    alpha: Floats,
    begin: int,
    squares: Squares,
    found: Ints,
    i: int,
    rule: Rule,
) -> int:
    """A point of a stroke of those before point `begin`, as far as it stays, that passes point i in its direction."""
    keys, sorting = squares.keys, squares.sorting
    left, top = math.floor(points[i, 0] / squares.side), math.floor(points[i, 1] / squares.side)
    for column in range(left - 1, left + 2):
        n = np.searchsorted(keys, column * _ROW + top - 1)
        while n < len(keys) and keys[n] <= column * _ROW + top + 1:
            j = sorting[n]
            n += 1
            if j >= begin or found[j] != STAYS or alpha[j] < alpha[i] - rule.fainter:
                continue
            if abs(along[i, 0] * along[j, 0] + along[i, 1] * along[j, 1]) < rule.parallel:
                continue
            x, y = points[i, 0] - placed[j, 0], points[i, 1] - placed[j, 1]
            aside = abs(x * along[j, 1] - y * along[j, 0])
            if aside <= rule.tolerance and abs(x * along[j, 0] + y * along[j, 1]) <= rule.spacing:
                return int(j)
    return -1


@kernel
def _draw_in(
    points: Floats,
    placed: Floats,
    first: Ints,
    c: int,
    squares: Squares,
    found: Ints,
    start: int,
    stop: int,
    within: float,
) -> bool:
    """Whether all points of a part of stroke c are near to what stays of one of those before, and close to each other.

    Then they are placed on it. A part that leads from one line to another one isn't drawn in.
    """
    keys, sorting = squares.keys, squares.sorting
    nearest = np.full(stop - start, -1)
    for i in range(start, stop):
        left, top = math.floor(points[i, 0] / squares.side), math.floor(points[i, 1] / squares.side)
        least = within
        for column in range(left - 1, left + 2):
            n = np.searchsorted(keys, column * _ROW + top - 1)
            while n < len(keys) and keys[n] <= column * _ROW + top + 1:
                j = sorting[n]
                n += 1
                gap = math.hypot(points[i, 0] - placed[j, 0], points[i, 1] - placed[j, 1])
                if j < first[c] and found[j] == STAYS and gap <= least:
                    nearest[i - start], least = j, gap
        if nearest[i - start] < 0:
            return False
    left = found[start - 1] if start > first[c] else nearest[0]
    right = found[stop] if stop < first[c + 1] else nearest[-1]
    if not _are_close(first, left, right, stop - start + 2):
        return False
    for i in range(start, stop):
        placed[i] = placed[nearest[i - start]]
    return True
