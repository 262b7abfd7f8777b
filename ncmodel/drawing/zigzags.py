"""Zigzags of lines of curvature, straightened or taken away.

Where triangles are slivers, as where a fillet meets a flat, curvature jumps from one to the next, and lines of
curvature hop to and fro between their rows. That is the mesh's doing: the surface has no such waves. A line that only
quivers is drawn smoothly; one that hops is no line there.
"""

import math
from collections.abc import Sequence

import numpy as np

from ncmodel.drawing.packed import Packed
from ncmodel.drawing.strokes import simplified
from ncmodel.jit import kernel
from ncmodel.types import FILTERED_FAMILIES, Floats, Ints, Mask, Stroke

QUIVER = 0.75
"""Pixels that a line may stray without being uneven. All pixels are those of a picture whose shorter side is 768."""
WINDOW = 24.0
"""Pixels of line in which turns to and fro make a zigzag: the waves of a surface are longer."""
BACK = math.radians(120.0)
"""Turns of a zigzag in that window, beyond what they come to together."""
SMOOTH = 4.0
"""Pixels: standard deviation of the weights with which a zigzag's points are averaged."""
HOP = 2.0
"""Pixels that a zigzag may be off what is drawn instead; what is off by more is left out."""
SPACING = 1.5
"""Pixels between the points at which a zigzag is looked at, at most."""
_FILTERED = {family.value for family in FILTERED_FAMILIES}


def straightened(strokes: Sequence[Stroke], scale: float) -> tuple[Stroke, ...]:
    """Strokes of which lines of curvature are without zigzags.

    Args:
        strokes: Of any families.
        scale: Pixels per pixel at 768.
    """
    chosen = [number for number, stroke in enumerate(strokes) if stroke.family in _FILTERED]
    if not chosen:
        return tuple(strokes)
    packed = Packed.of([strokes[number] for number in chosen])
    kept = simplified(packed.points, packed.first, QUIVER * scale)
    uneven = _uneven(packed.points, np.flatnonzero(kept), packed.first, WINDOW * scale)
    pieces: list[Sequence[Stroke]] = [(stroke,) for stroke in strokes]
    for place in np.flatnonzero(np.logical_or.reduceat(uneven, packed.first[:-1])).tolist():
        number, part = chosen[place], slice(packed.first[place], packed.first[place + 1])
        pieces[number] = _even(strokes[number], uneven[part], scale)
    return tuple(piece for some in pieces for piece in some)


def _even(stroke: Stroke, uneven: Mask, scale: float) -> list[Stroke]:
    """A stroke smoothed where it is uneven, without what hops there.

    Args:
        stroke: The stroke.
        uneven: (n,) which of its points, and the way on to the next, are part of a zigzag.
        scale: Pixels per pixel at 768.
    """
    steps = np.linalg.norm(np.diff(stroke.points, axis=0), axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    count = max(math.ceil(travelled[-1] / (SPACING * scale)), 2) + 1
    at = np.linspace(0.0, travelled[-1], count)
    values = [*stroke.points.T, stroke.alpha, *([] if stroke.depth is None else [stroke.depth])]
    fine = np.stack([np.interp(at, travelled, value) for value in values], axis=1)
    inside = uneven[np.minimum(np.searchsorted(travelled, at, side="right") - 1, len(steps) - 1)]
    sigma = SMOOTH * scale / at[1]
    smooth = _averaged(fine, sigma)
    # From the line as it is to the smooth one, and back, without a step.
    share = np.minimum(_averaged(inside[:, None].astype(np.float64), sigma) * 2.0, 1.0) * inside[:, None]
    smooth = fine + share * (smooth - fine)
    smooth[[0, -1]] = fine[[0, -1]]  # to the last digit: other strokes may end there, too
    hop = inside & (np.linalg.norm(smooth[:, :2] - fine[:, :2], axis=1) > HOP * scale)
    hops = inside & (_averaged(hop[:, None].astype(np.float64), sigma)[:, 0] > 0.02)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], ~hops, [False]]).astype(np.int8)))
    pieces = []
    for begin, end in edges.reshape(-1, 2).tolist():
        if end - begin > 1:
            part = smooth[begin:end]
            kept = simplified(np.ascontiguousarray(part[:, :2]), np.array([0, len(part)]), 0.1 * scale)
            depth = None if stroke.depth is None else part[kept, 3]
            pieces.append(Stroke(stroke.family, part[kept, :2], part[kept, 2], depth))
    return pieces


def _averaged(values: Floats, sigma: float) -> Floats:
    """(n, k) running means with Gaussian weights; a line goes on beyond its ends as it came, turned round."""
    reach = min(math.ceil(3.0 * sigma), len(values) - 1)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    before, after = 2.0 * values[0] - values[reach:0:-1], 2.0 * values[-1] - values[-2 : -reach - 2 : -1]
    padded = np.concatenate([before, values, after])
    return np.stack([np.convolve(column, weights / weights.sum(), "valid") for column in padded.T], axis=1)


@kernel
def _uneven(points: Floats, corners: Ints, first: Ints, window: float) -> Mask:
    """(N,) the points of polylines that are part of a zigzag.

    Args:
        points: (N, 2) pixels, polyline after polyline.
        corners: (K,) those of them, in order, at which the polylines turn.
        first: (C + 1,) where each polyline starts.
        window: Pixels.
    """
    uneven = np.zeros(len(points), np.bool_)
    turn, at = np.zeros(len(corners)), np.zeros(len(corners))
    begin = 0
    for c in range(len(first) - 1):
        stop = begin
        while stop < len(corners) and corners[stop] < first[c + 1]:
            stop += 1
        for k in range(begin + 1, stop):
            a, b = corners[k - 1], corners[k]
            x, y = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
            at[k] = at[k - 1] + math.hypot(x, y)
            if k + 1 < stop:
                d = corners[k + 1]
                u, v = points[d, 0] - points[b, 0], points[d, 1] - points[b, 1]
                turn[k] = math.atan2(x * v - y * u, x * u + y * v)
        low, total, net = begin + 1, 0.0, 0.0
        for k in range(begin + 1, stop - 1):
            total += abs(turn[k])
            net += turn[k]
            while at[k] - at[low] > window:
                total -= abs(turn[low])
                net -= turn[low]
                low += 1
            if total - abs(net) > BACK:
                uneven[corners[low - 1] : corners[k + 1]] = True
        begin = stop
    return uneven
