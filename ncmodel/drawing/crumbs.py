"""Short strokes that carry nothing, left out.

On rough surfaces, lines of curvature are mostly bits: each is there, and none tells anything of the form. What is short
and yet drawn by hand is closed (an eye, a screw), goes on in another line, or is part of the edges of something.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from ncmodel.drawing.packed import Packed
from ncmodel.geometry.adjacency import components
from ncmodel.jit import kernel
from ncmodel.types import FILTERED_FAMILIES, Floats, Ints, Mask, Stroke

CLOSED = 0.25
"""Strokes whose ends are nearer to each other than this share of their length are closed."""
_FILTERED = {family.value for family in FILTERED_FAMILIES}


def without_crumbs(
    strokes: Sequence[Stroke], shortest: float, apart: float, outline: Callable[[Sequence[Stroke]], Mask]
) -> tuple[Stroke, ...]:
    """Strokes without those that are short and carry nothing.

    Strokes that end in one point count together, by their ink: lengths weighted with opacities. Of lines of curvature,
    all short ones go; of contours, boundaries and creases, those that touch no longer stroke. Closed strokes and the
    outline stay.

    Args:
        strokes: Joined ones.
        shortest: Pixels of ink that are enough.
        apart: Pixels from its ends to the next longer stroke for a stroke to touch none.
        outline: Which of some strokes are part of the outline; asked of those in doubt.
    """
    if not strokes:
        return ()
    packed = Packed.of(strokes)
    gap = np.linalg.norm(packed.ends[:, 1] - packed.ends[:, 0], axis=1)
    closed = (gap <= CLOSED * packed.length) & (np.diff(packed.first) > 3)
    group = _groups(packed.ends)
    large = (np.bincount(group, packed.ink) >= shortest)[group] | closed
    curvature = np.array([stroke.family in _FILTERED for stroke in strokes])
    kept = large | ~curvature
    small = np.flatnonzero(~large & ~curvature)
    if len(small):
        longer = [stroke for stroke, is_large in zip(strokes, large.tolist(), strict=True) if is_large]
        kept[small] = _touching(packed.ends[small], longer, apart)
        small = small[~kept[small]]
        kept[small] = outline([strokes[number] for number in small.tolist()])
    return tuple(stroke for stroke, stays in zip(strokes, kept.tolist(), strict=True) if stays)


def _groups(ends: Floats) -> Ints:
    """(C,) a number for each of (C, 2, 2) pairs of ends, equal for those that share one."""
    nodes = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)[1].reshape(-1, 2)
    return np.asarray(components(nodes, nodes.size)[nodes[:, 0]])


def _touching(ends: Floats, strokes: Sequence[Stroke], apart: float) -> Mask:
    """(C,) which of (C, 2, 2) pairs of ends have one within some pixels of other strokes."""
    if not strokes:
        return np.zeros(len(ends), dtype=np.bool_)
    packed = Packed.of(strokes)
    return _within(ends, packed.points, packed.steps, apart)


@kernel
def _within(ends: Floats, points: Floats, steps: Floats, apart: float) -> Mask:
    found = np.zeros(len(ends), np.bool_)
    for i in range(2 * len(ends)):
        u, v = ends[i // 2, i % 2, 0], ends[i // 2, i % 2, 1]
        for n in range(1, len(points)):
            if found[i // 2]:
                break
            if steps[n] > 0.0:
                dx, dy = points[n, 0] - points[n - 1, 0], points[n, 1] - points[n - 1, 1]
                x, y = u - points[n - 1, 0], v - points[n - 1, 1]
                along = min(max((x * dx + y * dy) / (steps[n] * steps[n]), 0.0), 1.0)
                found[i // 2] = math.hypot(x - along * dx, y - along * dy) <= apart
    return found
