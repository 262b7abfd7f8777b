"""Strokes that taper, cut into pieces of one shade each: what both vector formats write."""

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, Stroke

OPACITY_STEP = 1 / 32
"""Where opacity changes by this, a piece of a taper ends, unless it is shorter than wide."""
OVERLAP = 0.3
"""Pixels that pieces reach beyond their ends, lest their smooth edges leave light seams."""
FAINTEST = 0.5 / 255
"""Opacity below which nothing shows in 8 bits."""


def pieces(strokes: Sequence[Stroke], shortest: float) -> Iterator[tuple[Floats, float]]:
    """Visible parts of strokes that have about one opacity: points (n, 2) and that opacity.

    Args:
        strokes: The strokes.
        shortest: Pixels; parts are no shorter, but for the last one of a stroke.
    """
    points = np.concatenate([stroke.points for stroke in strokes])
    alpha = np.concatenate([np.clip(stroke.alpha, 0.0, 1.0) for stroke in strokes])
    first = np.concatenate([[0], np.cumsum([len(stroke.points) for stroke in strokes])])
    cut_points, opacity, starts = _cut(points, alpha, first, OPACITY_STEP, shortest)
    for n, (begin, end) in enumerate(itertools.pairwise(starts.tolist())):
        if opacity[n] >= FAINTEST:
            yield cut_points[begin:end], float(opacity[n])


def whole(strokes: Sequence[Stroke]) -> Iterator[Floats]:
    """The points (n, 2) of strokes that show, where no line fades."""
    for stroke in strokes:
        if stroke.alpha.max() >= FAINTEST:
            yield stroke.points


@kernel
def _cut(points: Floats, alpha: Floats, first: Ints, step: float, shortest: float) -> tuple[Floats, Floats, Ints]:
    """Polylines cut where their opacity, linear between points, has changed by `step` since the last cut.

    Returns:
        The pieces' points, and of each piece its mean opacity and where it starts (one more: where the last one ends).
    """
    made = [(points[0, 0], points[0, 1]) for _ in range(0)]
    opacity, starts = [0.0 for _ in range(0)], [0]
    for c in range(len(first) - 1):
        made.append((points[first[c], 0], points[first[c], 1]))
        low = high = alpha[first[c]]
        length, amount = 0.0, 0.0
        for i in range(first[c], first[c + 1] - 1):
            dx, dy, rise = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1], alpha[i + 1] - alpha[i]
            whole, at = math.hypot(dx, dy), 0.0
            while at < 1.0 and whole > 0.0:
                limit = low + step if rise > 0 else high - step
                changed = (limit - alpha[i]) / rise if rise != 0 else np.inf
                to = min(max(changed, at + (shortest - length) / whole), 1.0)
                here, there = alpha[i] + at * rise, alpha[i] + to * rise
                low, high = min(low, there), max(high, there)
                length += (to - at) * whole
                amount += (to - at) * whole * (here + there) / 2
                beyond = to if to == 1.0 else to + OVERLAP / whole
                made.append((points[i, 0] + beyond * dx, points[i, 1] + beyond * dy))
                if to < 1.0:
                    before = to - OVERLAP / whole
                    opacity.append(amount / length)
                    starts.append(len(made))
                    made.append((points[i, 0] + before * dx, points[i, 1] + before * dy))
                    low, high, length, amount = there, there, 0.0, 0.0
                at = to
        opacity.append(amount / length if length > 0 else low)
        starts.append(len(made))
    return np.array(made), np.array(opacity), np.array(starts)


def path_data(points: Floats, move: str, line: str) -> str:
    """Coordinates in hundredths of a pixel: `move` and `line` are formats of the first and of every other point."""
    pairs = points.round(2).tolist()
    return move.format(*pairs[0]) + "".join([line.format(*pair) for pair in pairs[1:]])


def decimal(value: float) -> str:
    """Four digits without an exponent, which PDF doesn't know."""
    return np.format_float_positional(value, precision=4, fractional=False, trim="-")
