"""Paths as segments, and their strokes."""

from collections.abc import Sequence

import numpy as np

from ncmodel.camera import Camera
from ncmodel.drawing.strokes import strokes
from ncmodel.types import Floats, LineFamily, Mask, Segments, Stroke

CAMERA = Camera((0.0, 0.0, 3.0), focal_pixels=300.0)
PIXELS_PER_UNIT = 100.0  # at z = 0


def segments_of(*paths: Floats) -> Floats:
    """(n, 2, 3) segments along paths of points."""
    return np.concatenate([np.stack([path[:-1], path[1:]], axis=1) for path in paths])


def wave(n: int, y: float, rng: np.random.Generator) -> Floats:
    """(n, 3) points along a wavy path that crosses the picture at a height."""
    x = np.linspace(-1, 1, n)
    return np.stack([x, y + 0.1 * np.sin(9 * x + y), 0.02 * rng.normal(size=n)], axis=1)


def strokes_of(
    points: Floats, alpha: Floats | None = None, tolerance: float = 0.25, shortest: float = 0.0
) -> list[Stroke]:
    """The strokes of segments of even opacity, unless `alpha` says otherwise."""
    opacity = np.ones(points.shape[:2]) if alpha is None else alpha
    lines = Segments(LineFamily.RIDGES, points, opacity, np.zeros(len(points), dtype=np.int64))
    return list(strokes(lines, CAMERA, tolerance, shortest))


def stroke(*points: tuple[float, float], family: str = "contours", alpha: float = 1.0) -> Stroke:
    """A stroke of even opacity through some points."""
    return Stroke(family, np.array(points, dtype=np.float64), np.full(len(points), alpha))


def pen_reversed(stroke: Stroke) -> Stroke:
    """The same stroke, drawn from its other end."""
    return Stroke(stroke.family, stroke.points[::-1], stroke.alpha[::-1])


def inside(strokes: Sequence[Stroke]) -> Mask:
    """(C,) for strokes of which none is part of the outline."""
    return np.zeros(len(strokes), dtype=np.bool_)
