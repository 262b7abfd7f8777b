"""From visible segments to long strokes on the picture plane: chained, simplified, without dots."""

import math

import numpy as np

from ncmodel.camera import Camera
from ncmodel.drawing.overlapping_strokes import drop_overlapping
from ncmodel.jit import kernel
from ncmodel.lines.chaining import chain
from ncmodel.mesh.weld import coincident, rounding
from ncmodel.types import Floats, Ints, LineSet, Mask, Segments, Stroke

TOLERANCE = 0.25
"""Pixels that a stroke may stray from its segments, unless told otherwise."""


DOT = 0.01
"""Pixels; shorter strokes (edges seen end-on) have no length where coordinates are written in hundredths."""
ALPHA_TOLERANCE = 0.02
"""Opacity may be off by this much after simplification."""


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
    projected = camera.project(points)
    pixels, depth = np.ascontiguousarray(projected[:, :2]), projected[:, 2]
    first = np.concatenate([[0], last + 1])
    kept = _simplify(pixels, alpha, first, tolerance, ALPHA_TOLERANCE if tolerance else 0.0)
    bounds = np.searchsorted(np.flatnonzero(kept), first)
    pixels, alpha, depth = pixels[kept], alpha[kept], depth[kept]
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(pixels, axis=0), axis=1))])
    length = travelled[bounds[1:] - 1] - travelled[bounds[:-1]]
    drawn = (length >= max(shortest, DOT)) & ~_spurs(points, first, length < tolerance)
    parts = [slice(bounds[c], bounds[c + 1]) for c in np.flatnonzero(drawn).tolist()]
    found = [Stroke(segments.family.value, pixels[part], alpha[part], depth[part]) for part in parts]
    return drop_overlapping(found, min(tolerance, TOLERANCE))


def simplified(points: Floats, first: Ints, tolerance: float) -> Mask:
    """(N,) which points of polylines (points first[c] : first[c + 1]) are enough for some pixels of tolerance."""
    return np.asarray(_simplify(points, np.ones(len(points)), first, tolerance, 1.0))


def without_dots(lines: LineSet, camera: Camera, shortest: float) -> LineSet:
    """The lines that `strokes` would draw: without those whose chains are shorter than `shortest` pixels."""
    chains = chain(lines.points)
    if len(chains) == 0:
        return lines
    pixels = camera.project(lines.points)[..., :2]
    length = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1)[chains.segment]
    owner = np.repeat(np.arange(len(chains)), np.diff(chains.first))
    return lines.take(np.sort(chains.segment[np.bincount(owner, length)[owner] >= max(shortest, DOT)]))


def _spurs(points: Floats, first: Ints, short: Mask) -> Mask:
    """(C,) True for the `short` ones of polylines (points first[c] : first[c + 1]) that end on one that isn't short."""
    if not short.any() or short.all():
        return np.zeros(len(short), dtype=np.bool_)
    node = coincident(points, rounding(points))
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
