"""Strokes that run along others, taken away.

Where two surfaces nearly coincide (sheets with two sides, parts that overlap), so do their lines: in a picture that
changes nothing, but a plotter would draw them twice. The longer stroke stays.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, Mask, Stroke

SPACING = 1.0
"""Pixels between the points at which strokes are compared, at most."""
PARALLEL = 0.97
"""Least cosine between the directions of strokes that run along each other; others cross."""
SHORTEST_RUN = 4.0
"""Pixels; strokes that are close for a shorter stretch touch, or cross at a small angle."""
CRUMB = 2
"""What remains between or beside such stretches must have more points than this: it is hardly longer than wide."""
FAINTER = 0.02
"""A stroke stays if its opacity is above that of the other one by more than this."""


def drop_overlapping(strokes: Sequence[Stroke], tolerance: float) -> tuple[Stroke, ...]:
    """Strokes of one family without the parts that lie within `tolerance` pixels of longer strokes of no less ink.

    Args:
        strokes: Polylines of two points or more.
        tolerance: Pixels, at most `SPACING`.
    """
    if len(strokes) < 2:
        return tuple(strokes)
    lengths = [np.linalg.norm(np.diff(stroke.points, axis=0), axis=1).sum() for stroke in strokes]
    order = np.argsort(-np.array(lengths), kind="stable").tolist()
    fine = _sampled([strokes[index] for index in order])
    pixel = np.floor(fine.points / SPACING).astype(np.int64)
    key = pixel[:, 0] * _ROW + pixel[:, 1]
    sorting = np.argsort(key, kind="stable")
    kept = ~_retraced(fine.points, fine.along, fine.alpha, fine.first, key[sorting], sorting, tolerance)
    pieces: list[list[Stroke]] = [[stroke] for stroke in strokes]
    for rank, index in enumerate(order):
        part = slice(fine.first[rank], fine.first[rank + 1])
        if kept[part].all():
            continue
        pieces[index].clear()
        edges = np.flatnonzero(np.diff(np.concatenate([[False], kept[part], [False]]).astype(np.int8)))
        for begin, end in (part.start + edges).reshape(-1, 2).tolist():
            if end - begin <= CRUMB:
                continue
            # One point more at each side: what is left meets what it ran along.
            begin, end = max(begin - 1, part.start), min(end + 1, part.stop)
            own = fine.own[begin:end].copy()
            own[[0, -1]] = True
            pieces[index].append(Stroke(strokes[index].family, fine.points[begin:end][own], fine.alpha[begin:end][own]))
    return tuple(piece for some in pieces for piece in some)


_ROW = 1 << 32
"""Larger than any pixel's row, for one number for column and row."""


@dataclass(frozen=True, eq=False)
class _Samples:
    """Points at most `SPACING` apart along strokes.

    Attributes:
        points: (N, 2) pixels, stroke after stroke.
        along: (N, 2) directions of length 1.
        alpha: (N,) opacity.
        own: (N,) True for the strokes' own points.
        first: (C + 1,) where each stroke starts.
    """

    points: Floats
    along: Floats
    alpha: Floats
    own: Mask
    first: Ints


def _sampled(strokes: Sequence[Stroke]) -> _Samples:
    points = np.concatenate([stroke.points for stroke in strokes])
    start = np.cumsum([0, *(len(stroke.points) for stroke in strokes)])
    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(points, axis=0), axis=1) / SPACING), 1.0).astype(np.int64)
    steps[start[1:-1] - 1] = 1  # from one stroke to the next
    place = np.concatenate([[0], np.cumsum(steps)])
    at = np.arange(place[-1] + 1)
    first = np.append(place[start[:-1]], len(at))
    fine = np.stack([np.interp(at, place, column) for column in points.T], axis=1)
    along = np.diff(fine, axis=0, append=0.0)
    along[first[1:] - 1] = along[first[1:] - 2]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    alpha = np.interp(at, place, np.concatenate([stroke.alpha for stroke in strokes]))
    own = np.zeros(len(at), dtype=np.bool_)
    own[place] = True
    return _Samples(fine, along, alpha, own, first)


@kernel
def _retraced(
    points: Floats, along: Floats, alpha: Floats, first: Ints, keys: Ints, sorting: Ints, tolerance: float
) -> Mask:
    """(N,) True for the points on stretches that run along earlier strokes.

    Args:
        points: (N, 2) pixels, stroke after stroke.
        along: (N, 2) directions of length 1.
        alpha: (N,) opacity.
        first: (C + 1,) where each stroke starts.
        keys: (N,) sorted numbers of the pixels that points lie in.
        sorting: (N,) the points in that order.
        tolerance: Pixels.
    """
    found = np.zeros(len(points), np.bool_)
    for c in range(1, len(first) - 1):
        begin, end = first[c], first[c + 1]
        for i in range(begin, end):
            found[i] = _accompanied(points, along, alpha, begin, keys, sorting, found, i, tolerance)
        start, length = begin, 0.0
        for i in range(begin, end + 1):
            if i < end and found[i]:
                if i > start:
                    length += math.hypot(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1])
                continue
            if length < SHORTEST_RUN and i - start < end - begin:
                found[start:i] = False
            start, length = i + 1, 0.0
    return found


@kernel
def _accompanied(
    points: Floats,
    along: Floats,
    alpha: Floats,
    begin: int,
    keys: Ints,
    sorting: Ints,
    found: Mask,
    i: int,
    tolerance: float,
) -> bool:
    """Whether a stroke of those before point `begin`, as far as it stays, passes point i in its direction."""
    left, top = math.floor(points[i, 0] / SPACING), math.floor(points[i, 1] / SPACING)
    for column in range(left - 1, left + 2):
        n = np.searchsorted(keys, column * _ROW + top - 1)
        while n < len(keys) and keys[n] <= column * _ROW + top + 1:
            j = sorting[n]
            n += 1
            if j >= begin or found[j] or alpha[j] < alpha[i] - FAINTER:
                continue
            if abs(along[i, 0] * along[j, 0] + along[i, 1] * along[j, 1]) < PARALLEL:
                continue
            x, y = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
            aside = abs(x * along[j, 1] - y * along[j, 0])
            if aside <= tolerance and abs(x * along[j, 0] + y * along[j, 1]) <= SPACING:
                return True
    return False
