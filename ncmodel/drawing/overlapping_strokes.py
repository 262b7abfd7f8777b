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

SPACING = 1.0
"""Pixels between the points at which strokes are compared, at most."""
LEAD = 8.0
"""Pixels over which an end of a line goes over to another line, for each pixel between both: less would be a kink."""
BRANCH = 2.0
"""The same where that other line goes on beside it."""
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
    rule = _Rule(pixels / 2.0, pixels, parallel=0.94, shortest_run=2.0 * pixels, crumb=8, lead=LEAD, fainter=0.3)
    outlines = int((~inside | (claim == 0)).sum())
    return _without_retraced(strokes, order, int((claim == 0).sum()), outlines, rule)


def _without_retraced(strokes: Sequence[Stroke], order: Ints, whole: int, rims: int, rule: _Rule) -> tuple[Stroke, ...]:
    """Strokes without what runs along earlier ones.

    Args:
        strokes: Polylines.
        order: Their indices, from the strongest claim to the weakest.
        whole: How many of the first stay whole.
        rims: How many of the first are outline: however short, what isn't near to other lines stays.
        rule: When strokes run along each other.
    """
    fine = sampled([strokes[index] for index in order.tolist()], rule.spacing)
    cell = max(rule.tolerance, rule.spacing)
    square = np.floor(fine.points / cell).astype(np.int64)
    key = square[:, 0] * _ROW + square[:, 1]
    sorting = np.argsort(key, kind="stable")
    squares = _Squares(cell, key[sorting], sorting)
    along, placed = _retraced(fine.points, fine.along, fine.alpha, fine.first, squares, max(whole, 1), rims, rule)
    pieces: list[list[Stroke]] = [[stroke] for stroke in strokes]
    for rank in np.flatnonzero(np.logical_or.reduceat(along != _STAYS, fine.first[:-1])).tolist():
        index, part = order[rank], slice(fine.first[rank], fine.first[rank + 1])
        kept = along[part] == _STAYS
        changes = np.flatnonzero(np.diff(np.concatenate([[False], kept, [False]]).astype(np.int8)))
        spans = (part.start + changes).reshape(-1, 2).tolist()
        pieces[index] = [_piece(strokes[index], fine, placed, part, span) for span in spans]
    left = tuple(piece for some in pieces for piece in some)
    return _reaching(left, fine.points, placed, rule.lead) if rule.lead else left


def _reaching(strokes: tuple[Stroke, ...], points: Floats, placed: Floats, lead: float) -> tuple[Stroke, ...]:
    """Strokes that end on the lines that stay, where they ended on what was taken away or moved.

    Args:
        strokes: What is left.
        points: (N, 2) samples of all that there was.
        placed: (N, 2) as `_retraced` gives it.
        lead: As a rule has it.
    """
    from scipy.spatial import cKDTree

    moved = np.flatnonzero((placed != points).any(axis=1))
    if len(moved) == 0 or len(strokes) == 0:
        return strokes
    packed = Packed.of(strokes)
    ends = packed.ends.reshape(-1, 2)
    distance, place = cKDTree(points[moved]).query(ends, distance_upper_bound=TOUCHING)
    near = np.flatnonzero(np.isfinite(distance))
    near = near[np.linalg.norm(placed[moved[place[near]]] - ends[near], axis=1) > 1.5 * TOUCHING]
    near = near[~packed.meet_another(near, TOUCHING)]
    found = list(strokes)
    for end in near.tolist():
        found[end // 2] = _led(found[end // 2], end % 2 == 1, placed[moved[place[end]]], lead)
    return tuple(found)


def _led(stroke: Stroke, last: bool, target: Floats, lead: float) -> Stroke:
    """A stroke of which one end goes over to a point, without a kink."""
    points = stroke.points[::-1] if last else stroke.points
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    shift = target - points[0]
    reach = min(lead * math.hypot(*shift), float(travelled[-1]))
    place = int(np.searchsorted(travelled, reach))
    at = travelled if travelled[place] == reach else np.concatenate([travelled[:place], [reach], travelled[place:]])
    values = [
        *points.T,
        *(value[::-1] if last else value for value in (stroke.alpha, stroke.depth) if value is not None),
    ]
    fine = np.stack([np.interp(at, travelled, value) for value in values], axis=1)
    fine[:, :2] += np.maximum(1.0 - at / max(reach, 1e-12), 0.0)[:, None] * shift
    fine = fine[::-1] if last else fine
    return Stroke(stroke.family, fine[:, :2], fine[:, 2], None if stroke.depth is None else fine[:, 3])


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


def _piece(stroke: Stroke, fine: Samples, placed: Floats, part: slice, span: tuple[int, int]) -> Stroke:
    """The part of a stroke between two samples, with one point more at each side: it meets what it ran along."""
    chosen = slice(max(span[0] - 1, part.start), min(span[1] + 1, part.stop))
    own = fine.own[chosen].copy()
    own[[0, -1]] = True
    shifted = (placed[chosen] != fine.points[chosen]).any(axis=1)
    own[1:] |= shifted[1:] != shifted[:-1]
    depth = None if stroke.depth is None else fine.depth[chosen][own]
    return Stroke(stroke.family, placed[chosen][own], fine.alpha[chosen][own], depth)


@kernel
def _retraced(
    points: Floats, along: Floats, alpha: Floats, first: Ints, squares: _Squares, whole: int, rims: int, rule: _Rule
) -> tuple[Ints, Floats]:
    """(N,) for points on stretches that run along earlier strokes, a point that they pass; else `_STAYS` or `_CRUMB`.

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
    found = np.full(len(points), _STAYS)
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
                found[start:i] = _STAYS
            start, length = i + 1, 0.0
        start = begin
        for i in range(begin, end + 1):
            if i < end and found[i] == _STAYS:
                continue
            short, part = 0 < i - start <= rule.crumb, i - start < end - begin
            near = short and _draw_in(points, placed, first, c, squares, found, start, i, rule.tolerance)
            if near or (short and part and c >= rims and not _needed(found, first, c, start, i)):
                found[start:i] = _CRUMB
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
    return bool(j - 3 < first[c] or j + 3 >= first[c + 1] or (found[j - 3 : j + 4] != _STAYS).any())


@kernel
def _accompanied(
    points: Floats,
    placed: Floats,
    along: Floats,
    alpha: Floats,
    begin: int,
    squares: _Squares,
    found: Ints,
    i: int,
    rule: _Rule,
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
    squares: _Squares,
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
                if j < first[c] and found[j] == _STAYS and gap <= least:
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
