"""Strokes that run along others, taken away.

Where two surfaces nearly coincide (sheets with two sides, parts that overlap), so do their lines: in a picture that
changes nothing, but a plotter would draw them twice; the longer stroke stays. And where lines of different kinds, or
the two edges of something thin, run side by side with no white between them, they make a bar that no illustrator would
draw: what has the stronger claim stays.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ncmodel.drawing.packed import Packed, Samples, sampled
from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, LineFamily, Mask, Stroke

DOT = 2
"""Points of an outline beside another line that are no way to a corner, at most."""
SPACING = 1.0
"""Pixels between the points at which strokes are compared, at most."""
TOUCHING = 1.0
"""Pixels from the end of a stroke to a line that it ends on, at most."""
_CLAIMS = (
    (LineFamily.CONTOURS,),
    (LineFamily.BOUNDARIES,),
    (LineFamily.CREASES,),
    (LineFamily.INTERSECTIONS,),
    (LineFamily.RIDGES, LineFamily.VALLEYS),
    (LineFamily.SUGGESTIVE, LineFamily.APPARENT),
)
"""Where lines run along each other, those of the earlier families stay."""
_CLAIM = {family.value: rank for rank, families in enumerate(_CLAIMS) for family in families}


class _Rule(NamedTuple):
    """When strokes run along each other.

    Attributes:
        spacing: Pixels between the points at which they are compared, at most.
        tolerance: Pixels between them, at most.
        parallel: Least cosine between their directions; others cross.
        shortest_run: Pixels; strokes that are close for a shorter stretch touch, or cross at a small angle.
        crumb: What remains between or beside such stretches has more such points than this, unless it bridges a gap.
        lead: Such points that are left out where a stroke leaves the one it ran along, for a straight way from there.
        fainter: A stroke stays if its opacity is above that of the other one by more than this.
    """

    spacing: float
    tolerance: float
    parallel: float = 0.97
    shortest_run: float = 4.0
    crumb: int = 2
    lead: int = 0
    fainter: float = 0.02


def drop_overlapping(strokes: Sequence[Stroke], tolerance: float) -> tuple[Stroke, ...]:
    """Strokes of one family without the parts that lie within `tolerance` pixels of longer strokes of no less ink.

    Args:
        strokes: Polylines of two points or more.
        tolerance: Pixels, at most `SPACING`.
    """
    if len(strokes) < 2:
        return tuple(strokes)
    order = np.argsort(-Packed.of(strokes).length, kind="stable")
    return _without_retraced(strokes, order, 0, 0, _Rule(SPACING, tolerance))


def drop_accompanying(
    strokes: Sequence[Stroke], pixels: float, outline: Callable[[Sequence[Stroke]], Mask]
) -> tuple[Stroke, ...]:
    """Strokes without the parts that run along strokes of a stronger claim.

    Contours are claimed first and stay whole, as an outline is closed; then edges on the outline, boundaries, creases,
    intersections, ridges and valleys, suggestive contours and apparent ridges; among equals, the one of more ink.

    Args:
        strokes: Polylines of two points or more, of any families.
        pixels: How near lines are that run along each other.
        outline: Which of some strokes are part of the outline; asked of edges.
    """
    if len(strokes) < 2:
        return tuple(strokes)
    claim = np.array([_CLAIM.get(stroke.family, len(_CLAIMS)) for stroke in strokes])
    edges = np.flatnonzero((claim > 0) & (claim < _CLAIM[LineFamily.RIDGES.value]))
    inside = np.ones(len(strokes), dtype=np.bool_)
    inside[edges] = ~outline([strokes[number] for number in edges.tolist()])
    order = np.lexsort((-Packed.of(strokes).ink, claim, inside & (claim > 0)))
    rule = _Rule(pixels / 2.0, pixels, parallel=0.94, shortest_run=2.0 * pixels, crumb=8, lead=4, fainter=0.3)
    outlines = int((~inside | (claim == 0)).sum())
    return _without_retraced(strokes, order, int((claim == 0).sum()), outlines, rule)


def _without_retraced(strokes: Sequence[Stroke], order: Ints, whole: int, rims: int, rule: _Rule) -> tuple[Stroke, ...]:
    """Strokes without what runs along earlier ones.

    Args:
        strokes: Polylines.
        order: Their indices, from the strongest claim to the weakest.
        whole: How many of the first stay whole.
        rims: How many of the first go on to other lines, however short the way to these.
        rule: When strokes run along each other.
    """
    fine = sampled([strokes[index] for index in order.tolist()], rule.spacing)
    cell = max(rule.tolerance, rule.spacing)
    square = np.floor(fine.points / cell).astype(np.int64)
    key = square[:, 0] * _ROW + square[:, 1]
    sorting = np.argsort(key, kind="stable")
    squares = _Squares(cell, key[sorting], sorting)
    along = _retraced(fine.points, fine.along, fine.alpha, fine.first, squares, max(whole, 1), rims, rule)
    pieces: list[list[Stroke]] = [[stroke] for stroke in strokes]
    for rank in np.flatnonzero(np.maximum.reduceat(along, fine.first[:-1]) >= 0).tolist():
        index, part = order[rank], slice(fine.first[rank], fine.first[rank + 1])
        kept = along[part] == _STAYS
        changes = np.flatnonzero(np.diff(np.concatenate([[False], kept, [False]]).astype(np.int8)))
        spans = (part.start + changes).reshape(-1, 2).tolist()
        pieces[index] = [_piece(strokes[index], fine, part, span, along, rule.lead) for span in spans]
    left = tuple(piece for some in pieces for piece in some)
    return _reaching(left, fine.points, along) if rule.lead else left


def _reaching(strokes: tuple[Stroke, ...], points: Floats, along: Ints) -> tuple[Stroke, ...]:
    """Strokes that go on to the line that stays, where they ended on one that was taken away.

    Args:
        strokes: What is left.
        points: (N, 2) samples of all that there was.
        along: (N,) as `_retraced` gives it.
    """
    from scipy.spatial import cKDTree

    gone = np.flatnonzero(along >= 0)
    if len(gone) == 0 or len(strokes) == 0:
        return strokes
    packed = Packed.of(strokes)
    ends = packed.ends.reshape(-1, 2)
    distance, place = cKDTree(points[gone]).query(ends, distance_upper_bound=TOUCHING)
    near = np.flatnonzero(np.isfinite(distance))
    target = np.zeros_like(ends)
    target[near] = points[along[gone[place[near]]]]
    loose = near[np.linalg.norm(target - ends, axis=1)[near] > 1.5 * TOUCHING]
    loose = loose[~packed.meet_another(loose, TOUCHING)]
    found = list(strokes)
    for end in loose.tolist():
        stroke = found[end // 2]
        found[end // 2] = _extended(stroke, target[end], 0 if end % 2 == 0 else len(stroke.points))
    return tuple(found)


def _extended(stroke: Stroke, point: Floats, place: int) -> Stroke:
    """A stroke with one point more at an end, in the shade that it has there."""
    source = max(place - 1, 0)
    depth = None if stroke.depth is None else np.insert(stroke.depth, place, stroke.depth[source])
    alpha = np.insert(stroke.alpha, place, stroke.alpha[source])
    return Stroke(stroke.family, np.insert(stroke.points, place, point, axis=0), alpha, depth)


_STAYS, _CRUMB = -1, -2
"""What becomes of points that run along no stroke."""
_ROW = 1 << 32
"""Larger than any square's row, for one number for column and row."""


class _Squares(NamedTuple):
    """Points by the squares of the picture that they lie in.

    Attributes:
        side: Of the squares, pixels.
        keys: (N,) sorted numbers of the squares.
        sorting: (N,) the points in that order.
    """

    side: float
    keys: Ints
    sorting: Ints


def _piece(stroke: Stroke, fine: Samples, part: slice, span: tuple[int, int], along: Ints, lead: int) -> Stroke:
    """The part of a stroke between two samples, with one point more at each side: it meets what it ran along."""
    begin, end = max(span[0] - 1, part.start), min(span[1] + 1, part.stop)
    place, lead = np.arange(begin, end), min(lead, (span[1] - span[0]) // 3)
    own = fine.own[begin:end].copy()
    own[[0, -1]] = True
    if lead and begin < span[0]:
        place[0] = along[begin]
        own[1 : lead + 1] = False
        own[lead + 1] = True  # however far its next point is, it strays no longer than the lead
    if lead and end > span[1]:
        place[-1] = along[end - 1]
        own[-1 - lead : -1] = False
        own[-2 - lead] = True
    depth = None if stroke.depth is None else fine.depth[place[own]]
    return Stroke(stroke.family, fine.points[place[own]], fine.alpha[begin:end][own], depth)


@kernel
def _retraced(
    points: Floats, along: Floats, alpha: Floats, first: Ints, squares: _Squares, whole: int, rims: int, rule: _Rule
) -> Ints:
    """(N,) for points on stretches that run along earlier strokes, a point that they pass; else `_STAYS` or `_CRUMB`.

    What goes is no reason for another one to go: of every two lines, one is drawn.

    Args:
        points: (N, 2) pixels, stroke after stroke.
        along: (N, 2) directions of length 1.
        alpha: (N,) opacity.
        first: (C + 1,) where each stroke starts.
        squares: Where the points lie.
        whole: How many of the first strokes stay as they are.
        rims: How many of the first go on to other lines.
        rule: When strokes run along each other.
    """
    found = np.full(len(points), _STAYS)
    for c in range(whole, len(first) - 1):
        begin, end = first[c], first[c + 1]
        for i in range(begin, end):
            found[i] = _accompanied(points, along, alpha, begin, squares, found, i, rule)
        start, length = begin, 0.0
        for i in range(begin, end + 1):
            if i < end and found[i] >= 0:
                if i > start:
                    length += math.hypot(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1])
                continue
            if length < rule.shortest_run and i - start < end - begin:
                found[start:i] = _STAYS
            start, length = i + 1, 0.0
        start = begin
        for i in range(begin, end + 1):
            if i < end and found[i] == _STAYS:
                continue
            short = 0 < i - start <= rule.crumb and i - start < end - begin
            if short and not _needed(found, first, c, start, i, rims):
                found[start:i] = _CRUMB
            start = i + 1
    return found


@kernel
def _needed(found: Ints, first: Ints, c: int, start: int, stop: int, rims: int) -> bool:
    """Whether a short part of stroke c goes on from where one line ends to where another one begins.

    Outlines go on to corners, where others end, if that is farther than a dot.
    """
    if start == first[c] or stop == first[c + 1]:
        return c < rims and stop - start > DOT
    left, other = found[start - 1], found[stop]
    same = np.searchsorted(first, left, side="right") == np.searchsorted(first, other, side="right")
    return not (same and abs(left - other) <= 2 * (stop - start + 2))


@kernel
def _accompanied(
    points: Floats, along: Floats, alpha: Floats, begin: int, squares: _Squares, found: Ints, i: int, rule: _Rule
) -> int:
    """A point of a stroke of those before point `begin`, as far as it stays, that passes point i in its direction."""
    keys, sorting = squares.keys, squares.sorting
    left, top = math.floor(points[i, 0] / squares.side), math.floor(points[i, 1] / squares.side)
    for column in range(left - 1, left + 2):
        n = np.searchsorted(keys, column * _ROW + top - 1)
        while n < len(keys) and keys[n] <= column * _ROW + top + 1:
            j = sorting[n]
            n += 1
            if j >= begin or found[j] != _STAYS or alpha[j] < alpha[i] - rule.fainter:
                continue
            if abs(along[i, 0] * along[j, 0] + along[i, 1] * along[j, 1]) < rule.parallel:
                continue
            x, y = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
            aside = abs(x * along[j, 1] - y * along[j, 0])
            if aside <= rule.tolerance and abs(x * along[j, 0] + y * along[j, 1]) <= rule.spacing:
                return int(j)
    return -1
