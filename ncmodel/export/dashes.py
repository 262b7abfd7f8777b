"""Dashes of strokes, for pictures of pixels: vector files leave dashing to the program that shows them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ncmodel.types import Floats, Stroke


def dashed(strokes: Sequence[Stroke], dash: float, space: float) -> list[Stroke]:
    """The strokes cut into dashes; each starts with one.

    Args:
        strokes: Polylines of two points or more.
        dash: Length of a dash, pixels.
        space: Pixels between two.
    """
    return [part for stroke in strokes for part in _dashes(stroke, dash, space)]


def _dashes(stroke: Stroke, dash: float, space: float) -> list[Stroke]:
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(stroke.points, axis=0), axis=1))])
    starts = np.arange(0.0, travelled[-1], dash + space)
    return [_between(stroke, travelled, start, min(start + dash, float(travelled[-1]))) for start in starts.tolist()]


def _between(stroke: Stroke, travelled: Floats, start: float, stop: float) -> Stroke:
    """The part of a stroke from one length along it to another."""
    at = np.concatenate([[start], travelled[(travelled > start) & (travelled < stop)], [stop]])
    u, v, alpha = (np.interp(at, travelled, values) for values in (*stroke.points.T, stroke.alpha))
    depth = None if stroke.depth is None else np.interp(at, travelled, stroke.depth)
    return replace(stroke, points=np.stack([u, v], axis=1), alpha=alpha, depth=depth)
