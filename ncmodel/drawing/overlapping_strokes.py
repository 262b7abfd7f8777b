"""Strokes that run along others, taken away.

Where two surfaces nearly coincide (sheets with two sides, parts that overlap), so do their lines: in a picture that
changes nothing, but a plotter would draw them twice; the longer stroke stays. And where lines of different kinds, or
the two edges of something thin, run side by side with no white between them, they make a bar that no illustrator would
draw: what has the stronger claim stays.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ncmodel.drawing.packed import Packed, Samples, sampled
from ncmodel.lines.retracing import CRUMB, STAYS, Rule, Squares, retraced
from ncmodel.types import Floats, Ints, LineFamily, Mask, Stroke

SPACING = 1.0
"""Pixels between the points at which strokes are compared, at most."""
LEAD = 8.0
"""Pixels over which an end of a line goes over to another line, for each pixel between both: less would be a kink."""
TOUCHING = 1.0
"""Pixels from the end of a stroke to a line that it ends on, at most."""
Outline = Callable[[Sequence[Stroke]], Mask]
"""Which of some strokes are part of the outline."""
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


def drop_overlapping(strokes: Sequence[Stroke], tolerance: float) -> tuple[Stroke, ...]:
    """Strokes of one family without the parts that lie within `tolerance` pixels of longer strokes of no less ink.

    Args:
        strokes: Polylines of two points or more.
        tolerance: Pixels, at most `SPACING`.
    """
    if len(strokes) < 2:
        return tuple(strokes)
    order = np.argsort(-Packed.of(strokes).length, kind="stable")
    return _without_retraced(strokes, order, 0, 0, Rule(SPACING, tolerance))


def drop_accompanying(strokes: Sequence[Stroke], pixels: float, outline: Outline) -> tuple[Stroke, ...]:
    """Strokes without the parts that run along strokes of a stronger claim.

    Contours are claimed first and stay whole, as an outline is closed; then edges on the outline, boundaries, creases,
    intersections, ridges and valleys, suggestive contours and apparent ridges; among equals, the one of more ink.

    Args:
        strokes: Polylines of two points or more, of any families.
        pixels: How near lines are that run along each other.
        outline: Asked of edges, and of what would be left of lines as crumbs.
    """
    if len(strokes) < 2:
        return tuple(strokes)
    claim = np.array([_CLAIM.get(stroke.family, len(_CLAIMS)) for stroke in strokes])
    edges = np.flatnonzero((claim > 0) & (claim < _CLAIM[LineFamily.RIDGES.value]))
    inside = np.ones(len(strokes), dtype=np.bool_)
    inside[edges] = ~outline([strokes[number] for number in edges.tolist()])
    order = np.lexsort((-Packed.of(strokes).ink, claim, inside & (claim > 0)))
    rule = Rule(pixels / 2.0, pixels, parallel=0.94, shortest_run=2.0 * pixels, crumb=8, lead=LEAD, fainter=0.3)
    outlines = int((~inside | (claim == 0)).sum())
    return _without_retraced(strokes, order, int((claim == 0).sum()), outlines, rule, outline)


def drop_beside(strokes: Sequence[Stroke], drawn: Sequence[Stroke], pixels: float) -> tuple[Stroke, ...]:
    """Hidden strokes without the parts that run along visible ones, or along hidden ones of a stronger claim.

    Args:
        strokes: Hidden polylines of two points or more, of any families.
        drawn: The visible ones.
        pixels: How near lines are that run along each other.
    """
    if not strokes:
        return ()
    claim = np.array([_CLAIM.get(stroke.family, len(_CLAIMS)) for stroke in strokes])
    order = len(drawn) + np.lexsort((-Packed.of(strokes).ink, claim))
    order = np.concatenate([np.arange(len(drawn)), order])
    rule = Rule(pixels / 2.0, pixels, parallel=0.94, shortest_run=2.0 * pixels, crumb=8, fainter=1.0)
    left = _without_retraced([*drawn, *strokes], order, len(drawn), len(drawn), rule)
    return tuple(stroke for stroke in left if stroke.hidden)


def _without_retraced(
    strokes: Sequence[Stroke], order: Ints, whole: int, rims: int, rule: Rule, outline: Outline | None = None
) -> tuple[Stroke, ...]:
    """Strokes without what runs along earlier ones.

    Args:
        strokes: Polylines.
        order: Their indices, from the strongest claim to the weakest.
        whole: How many of the first stay whole.
        rims: How many of the first are outline: however short, what isn't near to other lines stays.
        rule: When strokes run along each other.
        outline: Which of some strokes are part of the outline: of what would be left out as too short, those stay.
    """
    fine = sampled([strokes[index] for index in order.tolist()], rule.spacing)
    squares = Squares.of(fine.points, max(rule.tolerance, rule.spacing))
    along, placed = retraced(fine.points, fine.along, fine.alpha, fine.first, squares, max(whole, 1), rims, rule)
    pieces: list[list[Stroke]] = [[stroke] for stroke in strokes]
    touched = np.logical_or.reduceat(along != STAYS, fine.first[:-1])
    for rank in np.flatnonzero(touched).tolist():
        pieces[order[rank]] = []
    short: list[tuple[int, Stroke]] = []
    for mark in (STAYS, CRUMB):
        for rank, *span in _spans((along == mark) & np.repeat(touched, np.diff(fine.first)), fine.first):
            index, part = int(order[rank]), slice(fine.first[rank], fine.first[rank + 1])
            piece = _piece(strokes[index], fine, placed, part, slice(*span))
            if mark == STAYS:
                pieces[index].append(piece)
            else:
                short.append((index, piece))
    if outline is not None and short:
        for (index, crumb), stays in zip(short, outline([crumb for _, crumb in short]).tolist(), strict=True):
            if stays:
                pieces[index].append(crumb)
    left = tuple(piece for some in pieces for piece in some)
    return _reaching(left, fine.points, placed, rule.lead) if rule.lead else left


def _spans(chosen: Mask, first: Ints) -> list[tuple[int, int, int]]:
    """Runs of chosen samples, none across two strokes: the stroke's number, where the run starts, where it stops."""
    begins, ends = chosen.copy(), chosen.copy()
    begins[1:] &= ~chosen[:-1]
    ends[:-1] &= ~chosen[1:]
    begins[first[:-1]] = chosen[first[:-1]]
    ends[first[1:] - 1] = chosen[first[1:] - 1]
    starts, stops = np.flatnonzero(begins), np.flatnonzero(ends) + 1
    ranks = np.searchsorted(first, starts, side="right") - 1
    return list(zip(ranks.tolist(), starts.tolist(), stops.tolist(), strict=True))


def _reaching(strokes: tuple[Stroke, ...], points: Floats, placed: Floats, lead: float) -> tuple[Stroke, ...]:
    """Strokes that end on the lines that stay, where they ended on what was taken away or moved.

    Args:
        strokes: What is left.
        points: (N, 2) samples of all that there was.
        placed: (N, 2) as `retraced` gives it.
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
    depth = None if stroke.depth is None else fine[:, 3]
    return replace(stroke, points=fine[:, :2], alpha=fine[:, 2], depth=depth)


def _piece(stroke: Stroke, fine: Samples, placed: Floats, part: slice, span: slice) -> Stroke:
    """The part of a stroke between two samples, with one point more at each side: it meets what it ran along."""
    chosen = slice(max(span.start - 1, part.start), min(span.stop + 1, part.stop))
    own = fine.own[chosen].copy()
    own[[0, -1]] = True
    shifted = (placed[chosen] != fine.points[chosen]).any(axis=1)
    own[1:] |= shifted[1:] != shifted[:-1]
    depth = None if stroke.depth is None else fine.depth[chosen][own]
    return replace(stroke, points=placed[chosen][own], alpha=fine.alpha[chosen][own], depth=depth)
