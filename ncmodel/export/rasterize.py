"""Anti-aliased thick lines: every pixel gets the share of it that the strongest line covers, times its opacity.

A segment is drawn as a capsule (a stroke with round caps). The share of a pixel that it covers is the exact area
between the stroke's two sides on the unit square; around a cap a side is taken as the circle's tangent, which is right
to a few hundredths for lines of two pixels and more. Lines are composited by maximum, so their order never matters.
"""

import math

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats, Image

REACH = math.sqrt(0.5)
"""A stroke touches no pixel whose centre is farther than this from it."""

_NOTHING = np.empty((0, 0), dtype=np.float32)


def draw_segments(
    points: Floats, alpha: Floats, width: float, shape: tuple[int, int], onto: Image | None = None
) -> Image:
    """Ink of straight lines.

    Args:
        points: (S, 2, 2) end points, pixels (u right, v down). Segments of no length or with a coordinate that isn't
            finite are left out; what is outside the image is clipped.
        alpha: (S, 2) opacity at the ends, linear between.
        width: Line width, pixels.
        shape: (H, W) of the image.
        onto: An (H, W) image to add to, by maximum; it stays as it is.

    Returns:
        (H, W) ink in [0, 1].
    """
    ink = np.zeros(shape, dtype=np.float32) if onto is None else onto.copy()
    _draw(_array(points), _array(alpha), _array(alpha), width / 2, ink, _NOTHING)
    return ink


def draw_features(
    points: Floats, alpha: Floats, feature: Floats, width: float, shape: tuple[int, int]
) -> tuple[Image, Image]:
    """Ink of straight lines, and the feature that the strongest line carries at each pixel.

    Args:
        points: (S, 2, 2) end points, as `draw_segments` takes them.
        alpha: (S, 2) opacity at the ends, linear between.
        feature: (S, 2) any quantity at the ends, linear between.
        width: Line width, pixels.
        shape: (H, W) of the images.

    Returns:
        (H, W) ink in [0, 1], and (H, W) the feature of the line with the most ink at the pixel (of the largest one
        among equals); 0 where there is no ink.
    """
    ink = np.zeros(shape, dtype=np.float32)
    carried = np.zeros(shape, dtype=np.float32)
    _draw(_array(points), _array(alpha), _array(feature), width / 2, ink, carried)
    return ink, carried


def _array(values: Floats) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float64)


@kernel
def _below(x: float, nx: float, ny: float) -> float:
    """The area of the unit square about the origin where n.p <= x, for a unit normal n."""
    a, b = max(abs(nx), abs(ny)), min(abs(nx), abs(ny))
    t = abs(x)
    if t >= (a + b) / 2:
        part = 0.5
    elif t <= (a - b) / 2:
        part = t / a
    else:
        part = 0.5 - ((a + b) / 2 - t) ** 2 / (2 * a * b)
    return 0.5 + part if x >= 0 else 0.5 - part


@kernel
def row_span(x0: float, y0: float, x1: float, y1: float, y: float, reach: float, width: int) -> tuple[int, int]:
    """The pixels [first, last) of the row through `y` within `reach` of a segment with y0 <= y1, and a few more."""
    low, high = x0, x1
    if y1 - y0 > reach:
        slope = (x1 - x0) / (y1 - y0)
        low = x0 + slope * min(max(y - reach - y0, 0.0), y1 - y0)
        high = x0 + slope * min(max(y + reach - y0, 0.0), y1 - y0)
    first = min(max(min(low, high) - reach, 0.0), float(width))
    last = min(max(max(low, high) + reach + 1.0, 0.0), float(width))
    return int(first), int(last)


@kernel
def _draw(points: Floats, alpha: Floats, feature: Floats, half: float, ink: Image, carried: Image) -> None:
    """Composite capsules of half width `half` onto `ink`, and their feature onto `carried` unless that is empty."""
    height, width = ink.shape
    reach = half + REACH
    for s in range(len(points)):
        # From the upper to the lower end.
        i = 0 if points[s, 0, 1] <= points[s, 1, 1] else 1
        x0, y0, x1, y1 = points[s, i, 0], points[s, i, 1], points[s, 1 - i, 0], points[s, 1 - i, 1]
        a0, a1, f0, f1 = alpha[s, i], alpha[s, 1 - i], feature[s, i], feature[s, 1 - i]
        dx, dy = x1 - x0, y1 - y0
        square = dx * dx + dy * dy
        if not (0.0 < square < np.inf and a0 + a1 > 0.0):
            continue
        length = math.sqrt(square)
        top = int(min(max(y0 - reach, 0.0), float(height)))
        bottom = int(min(max(y1 + reach + 1.0, 0.0), float(height)))
        for row in range(top, bottom):
            y = row + 0.5
            first, last = row_span(x0, y0, x1, y1, y, reach, width)
            for column in range(first, last):
                x = column + 0.5
                along = min(max(((x - x0) * dx + (y - y0) * dy) / square, 0.0), 1.0)
                nx, ny = x - x0 - along * dx, y - y0 - along * dy
                distance = math.sqrt(nx * nx + ny * ny)
                if distance >= reach:
                    continue
                if distance > 1e-9 * length:
                    nx, ny = nx / distance, ny / distance
                else:
                    nx, ny = -dy / length, dx / length
                cover = _below(half - distance, nx, ny) - _below(-half - distance, nx, ny)
                drawn = np.float32(cover * (a0 + along * (a1 - a0)))
                here = ink[row, column]
                if drawn < here or drawn <= 0.0:
                    continue
                ink[row, column] = drawn
                if carried.size:
                    value = np.float32(f0 + along * (f1 - f0))
                    carried[row, column] = max(value, carried[row, column]) if drawn == here else value
