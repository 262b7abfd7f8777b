"""How neat a drawing's lines are: what an illustrator would send back, counted.

All lengths are pixels of the default drawing, 768 on a side. Lines count where they are seen, which is where they have
at least a quarter of full ink: a dash that fades out ends where it is hardly there.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from eval.benchmark.each_view import VIEWS, ViewRow, measure_views
from eval.benchmark.polylines import distance, ends, length_of, meeting, sampled
from ncmodel.camera import DEFAULT_SIZE, Camera
from ncmodel.drawing.draw import draw
from ncmodel.export.page import RELATIVE_WIDTH
from ncmodel.scene.surface import Surface
from ncmodel.types import FILTERED_FAMILIES, Floats, LineFamily, Mask, Stroke

SEEN = 0.25
"""Opacity from which on a line is seen."""
WOBBLE = 0.5
"""Pixels that a line may stray without looking uneven."""
BACK = 16.0
"""Pixels within which a turn is taken back, in a zigzag; a surface's own waves are longer."""
DASH_GAP = (1.0, 15.0)
"""Pixels between two ends that continue each other."""
STRAIGHT = 0.85
"""Cosine up to which an end points at another one."""
CLEAR = 1.5
"""Pixels around a gap in which no other line runs."""
TOUCHING = 1.0
"""Pixels within which an end meets a line."""
DOUBLE = 3.0
"""Pixels within which two lines look like one thick one."""
PARALLEL = 0.9
"""Least cosine between lines that run along each other."""
SHORTEST_DOUBLE = 6.0
"""Pixels; lines that are close for a shorter stretch cross or meet."""
CRUMB = 0.02
"""Share of the picture's shorter side; shorter strokes are crumbs."""
OUTLINE = 2.0
"""Pixels between an outline and the background beside it, and within which an end of it meets another line."""

_RANK = {family.value: rank for rank, family in enumerate(LineFamily)}


@dataclass(frozen=True)
class Neatness(ViewRow):
    """How neat the default drawing of one view is; of everything less is better.

    Attributes:
        jaggedness: Degrees that lines turn to and fro, on 100 pixels of line.
        dashes: Gaps between ends that continue each other.
        dash_length: Their length together, pixels.
        doubles: Share of the length of all lines that runs along a line of another family.
        crumbs: Share of the ink that is in strokes under 2 % of the picture.
        open_outlines: Ends of the outline that meet nothing.
    """

    jaggedness: float
    dashes: float
    dash_length: float
    doubles: float
    crumbs: float
    open_outlines: float


def measure_neatness(
    surfaces: Iterable[Surface],
    advance: Callable[[str], None],
    views: Sequence[tuple[float, float]] = VIEWS,
    size: int = DEFAULT_SIZE,
) -> list[Neatness]:
    """Draw every surface from every view by default and look at the lines.

    Args:
        surfaces: What to draw.
        advance: Called after each surface.
        views: Azimuth and elevation, degrees.
        size: Side of the pictures, pixels.
    """
    return measure_views(Neatness, _measure, surfaces, advance, views, size)


def neatness_rows(found: Sequence[Neatness]) -> list[list[str]]:
    """A table, its head first."""
    head = ["shape", "jaggedness", "dashes", "dashes px", "doubles %", "crumbs %", "open outlines"]
    return [
        head,
        *(
            [
                each.shape,
                f"{each.jaggedness:.1f}",
                f"{each.dashes:.1f}",
                f"{each.dash_length:.1f}",
                f"{100 * each.doubles:.2f}",
                f"{100 * each.crumbs:.2f}",
                f"{each.open_outlines:.1f}",
            ]
            for each in found
        ),
    ]


def seen(strokes: Sequence[Stroke]) -> list[Stroke]:
    """The parts of strokes that have at least `SEEN` of full ink."""
    found = []
    for stroke in strokes:
        alpha, excess = stroke.alpha, stroke.alpha - SEEN
        crossing = np.flatnonzero(excess[:-1] * excess[1:] < 0.0)
        cuts = crossing + excess[crossing] / (excess[crossing] - excess[crossing + 1])
        own = np.arange(len(alpha))
        places = np.union1d(own, cuts)
        points = np.stack([np.interp(places, own, column) for column in stroke.points.T], axis=1)
        opacity = np.interp(places, own, alpha)
        dark = np.concatenate([[False], opacity >= SEEN - 1e-9, [False]])
        for begin, end in np.flatnonzero(np.diff(dark.astype(np.int8))).reshape(-1, 2).tolist():
            if length_of(points[begin:end]) > 0.0:
                found.append(Stroke(stroke.family, points[begin:end], opacity[begin:end]))
    return found


def jaggedness(strokes: Sequence[Stroke]) -> float:
    """Degrees that strokes turn and take back within `BACK` pixels, on 100 pixels of their length.

    A curve turns one way, and a corner is turned once: neither counts. What strays by less than `WOBBLE` is no turn.
    """
    length = math.fsum(length_of(stroke.points) for stroke in strokes)
    undone = math.fsum(_undone_turning(stroke.points) for stroke in strokes)
    return 100.0 * math.degrees(undone) / length if length > 0.0 else 0.0


def dash_gaps(strokes: Sequence[Stroke]) -> list[float]:
    """Lengths of the gaps, `DASH_GAP` pixels long, between ends that point at each other with nothing between them.

    Ends that meet a line are no ends of dashes, and each end belongs to one gap, the shortest.
    """
    from scipy.spatial import cKDTree

    lines = [stroke.points for stroke in strokes]
    places, outwards = ends(lines)
    free = np.flatnonzero(~meeting(lines, TOUCHING))
    if len(free) == 0:
        return []
    pairs = free[cKDTree(places[free]).query_pairs(DASH_GAP[1], output_type="ndarray")]
    one, other = pairs[:, 0], pairs[:, 1]
    way = places[other] - places[one]
    length = np.linalg.norm(way, axis=1)
    way /= np.maximum(length, 1e-12)[:, None]
    facing = np.minimum((outwards[one] * way).sum(axis=1), -(outwards[other] * way).sum(axis=1)) > STRAIGHT
    chosen = np.flatnonzero(facing & (length >= DASH_GAP[0]))
    drawn = sampled(lines).points
    for share in (0.25, 0.5, 0.75):
        between = places[one[chosen]] * (1.0 - share) + places[other[chosen]] * share
        chosen = chosen[distance(between, drawn) > np.minimum(CLEAR, 0.2 * length[chosen])]
    found, taken = [], set[int]()
    for pair in chosen[np.argsort(length[chosen], kind="stable")].tolist():
        if not taken & {one[pair], other[pair]}:
            taken |= {one[pair], other[pair]}
            found.append(float(length[pair]))
    return found


def doubled_share(strokes: Sequence[Stroke]) -> float:
    """Share of the length of strokes that runs within `DOUBLE` pixels along a stroke of another family.

    Of two such strokes the one counts whose family comes later in `LineFamily`: what could be left out.
    """
    from scipy.spatial import cKDTree

    samples = sampled([stroke.points for stroke in strokes], 1.0)
    if samples.weight.sum() == 0.0:
        return 0.0
    rank = np.array([_RANK.get(stroke.family, len(_RANK)) for stroke in strokes])[samples.owner]
    pairs = cKDTree(samples.points).query_pairs(DOUBLE, output_type="ndarray")
    pairs = pairs[rank[pairs[:, 0]] != rank[pairs[:, 1]]]
    later = np.where(rank[pairs[:, 0]] > rank[pairs[:, 1]], pairs[:, 0], pairs[:, 1])
    earlier = pairs.sum(axis=1) - later
    apart, along = samples.points[later] - samples.points[earlier], samples.along[earlier]
    beside = np.abs((apart * along).sum(axis=1)) <= 1.0
    parallel = np.abs((samples.along[later] * along).sum(axis=1)) >= PARALLEL
    accompanied = np.zeros(len(samples.points), dtype=np.bool_)
    accompanied[later[beside & parallel]] = True
    run = np.cumsum(np.diff(accompanied, prepend=False) | (np.diff(samples.owner, prepend=-1) != 0))
    lengths = np.bincount(run, samples.weight)
    return float(samples.weight[accompanied & (lengths[run] >= SHORTEST_DOUBLE)].sum() / samples.weight.sum())


def crumb_share(strokes: Sequence[Stroke], side: float) -> float:
    """Share of the ink, width times length times opacity, that is in strokes shorter than `CRUMB` of a side."""
    ink = [_ink(stroke) for stroke in strokes]
    crumbs = [amount for amount, stroke in zip(ink, strokes, strict=True) if length_of(stroke.points) < CRUMB * side]
    return math.fsum(crumbs) / math.fsum(ink) if any(ink) else 0.0


def open_ends(strokes: Sequence[Stroke], hit: Mask) -> int:
    """How many ends of contours, boundaries and creases on the outline meet no other line.

    Args:
        strokes: The drawing's.
        hit: (H, W) True where the shape is seen; its outline is where that ends.
    """
    import cv2

    lines = [stroke.points for stroke in strokes]
    places, _ = ends(lines)
    full = np.repeat([stroke.family not in FILTERED_FAMILIES for stroke in strokes], 2)
    inside = cv2.distanceTransform(hit.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    column, row = np.floor(places).astype(np.int64).T
    framed = (column >= 0) & (column < hit.shape[1]) & (row >= 0) & (row < hit.shape[0])
    outline = np.zeros(len(places), dtype=np.bool_)
    outline[framed] = inside[row[framed], column[framed]] <= OUTLINE
    return int((full & outline & ~meeting(lines, OUTLINE)).sum())


def _measure(surface: Surface, camera: Camera) -> tuple[float, float, float, float, float, float]:
    """The measures of one view's default drawing."""
    strokes, hit = draw(surface, camera).strokes, surface.scene.render(camera).hit
    lines = seen(strokes)
    gaps = dash_gaps(lines)
    return (
        jaggedness(lines),
        float(len(gaps)),
        math.fsum(gaps),
        doubled_share(lines),
        crumb_share(strokes, min(hit.shape)),
        float(open_ends(lines, hit)),
    )


def _undone_turning(line: Floats) -> float:
    """Radians of turns that later turns the other way take back within `BACK` pixels, both counted."""
    import cv2

    corners = cv2.approxPolyDP(line.astype(np.float32).reshape(-1, 1, 2), WOBBLE, closed=False).reshape(-1, 2)
    step = np.diff(corners.astype(np.float64), axis=0)
    cross = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]
    turns = np.arctan2(cross, (step[:-1] * step[1:]).sum(axis=1))
    places = np.cumsum(np.linalg.norm(step, axis=1))
    undone, waiting = 0.0, list[list[float]]()
    for turn, at in zip(turns.tolist(), places.tolist(), strict=False):
        while turn and waiting and waiting[-1][0] * turn < 0.0 and at - waiting[-1][1] <= BACK:
            back = min(abs(turn), abs(waiting[-1][0]))
            undone += 2.0 * back
            turn -= math.copysign(back, turn)
            waiting[-1][0] -= math.copysign(back, waiting[-1][0])
            if not waiting[-1][0]:
                waiting.pop()
        if turn:
            waiting.append([turn, at])
    return undone


def _ink(stroke: Stroke) -> float:
    steps = np.linalg.norm(np.diff(stroke.points, axis=0), axis=1)
    opacity = (stroke.alpha[:-1] + stroke.alpha[1:]) / 2
    return float((steps * opacity).sum()) * RELATIVE_WIDTH.get(stroke.family, 1.0)
