"""References as people hand them in: pencil, grey paper, white on black, brought to black ink on white paper."""

from pathlib import Path

import cv2
import numpy as np

from eval.measures.thinning import DEFAULT_THRESHOLD, binarise
from ncmodel.errors import InputError
from ncmodel.images import read_grey
from ncmodel.types import Floats, Image

MOST_INK = 1 / 3
"""Share of a picture that lines may cover: more is a shaded picture, a mask, or the wrong way round."""

_WHITE, _BLACK = 0.9, 0.3
"""Brightness of paper and of lines from which on a picture is taken as it is."""

_LEAST_CONTRAST = 0.15
"""Between lines and paper; less is the paper itself."""

_SPECKS = (20, 0.0005)
"""Pixels, at least so many and this share of all, that may be darker than the lines: dirt, noise."""

_MARGIN = 1 / 40
"""Of each side, where scans have their dark edges, which say nothing of the lines."""

_CELLS = 16
"""Along each side, in which the light on the paper is measured."""
_UNEVEN = 0.05
"""Difference in brightness over a page from which on the light on it counts as uneven."""
_FITTED, _MOST_OFF = 0.9, 0.05
"""So many of the cells are as bright as a smooth light makes them, but for this: otherwise it's what is drawn."""

WIDEST = 0.05
"""Of a picture's longer side; what is wider on average is no line."""


def read_reference(path: str | Path) -> Image:
    """(H, W) ink of a reference, 1 = line.

    Dark lines on white paper are taken as they are. Otherwise ink is 0 at the paper's brightness and 1 at that of the
    lines, which are what differs most from the paper, on either side.

    Raises:
        InputError: The file is missing or no picture.
    """
    brightness = read_grey(path)
    paper = _paper(brightness)
    depth = paper - brightness
    inner = depth[tuple(slice(round(_MARGIN * side), side - round(_MARGIN * side)) for side in depth.shape)]
    least, share = _SPECKS
    aside = min(max(least, round(share * inner.size)), (inner.size - 1) // 4)
    levels = np.partition(inner.ravel(), (aside, inner.size - 1 - aside))
    below, above = float(levels[-1 - aside]), -float(levels[aside])
    contrast = max(below, above)
    as_it_is = below >= above and paper.min() >= _WHITE and paper.min() - below <= _BLACK
    if contrast < _LEAST_CONTRAST or as_it_is:
        return np.asarray(1.0 - brightness, dtype=np.float32)
    return np.asarray(np.clip((depth if below >= above else -depth) / contrast, 0.0, 1.0), dtype=np.float32)


def _paper(brightness: Image) -> Floats:
    """(H, W) or (1, 1) the paper's brightness: the median, as lines cover less than half.

    A lamp or a window lights a page unevenly: where the medians of a page's cells follow a quadratic of the place, but
    for a few, the paper does. A mask or a shaded shape doesn't.
    """
    height, width = (side // _CELLS for side in brightness.shape)
    median = np.median(brightness)
    if min(height, width) < 2:
        return np.full((1, 1), median)
    cells = brightness[: height * _CELLS, : width * _CELLS].reshape(_CELLS, height, _CELLS, width)
    medians = np.median(cells.swapaxes(1, 2).reshape(_CELLS**2, -1), axis=1)
    centres = [
        (np.arange(_CELLS) + 0.5) * size / side for size, side in zip((height, width), brightness.shape, strict=True)
    ]
    terms = _quadratic(centres[0][:, None], centres[1]).reshape(-1, _CELLS**2).T
    kept = np.ones(_CELLS**2, dtype=np.bool_)
    for _ in range(3):  # the cells that lie off pull at the first fits
        weights = np.linalg.lstsq(terms[kept], medians[kept], rcond=None)[0]
        off = np.abs(terms @ weights - medians)
        kept = off <= max(np.quantile(off, _FITTED), 1e-9)
    rows, columns = ((np.arange(side) + 0.5) / side for side in brightness.shape)
    paper = np.tensordot(weights, _quadratic(rows[:, None], columns), 1)
    if np.quantile(off, _FITTED) > _MOST_OFF or np.ptp(paper) < _UNEVEN:
        return np.full((1, 1), median)
    return np.asarray(paper)


def _quadratic(y: Floats, x: Floats) -> Floats:
    """(6, H, W) the terms of a quadratic of the place."""
    return np.stack(np.broadcast_arrays(1.0, x, y, x * x, x * y, y * y))


def read_lines(path: str | Path, threshold: float = DEFAULT_THRESHOLD) -> Image:
    """`read_reference` of a picture that must be lines on paper.

    Args:
        path: The picture.
        threshold: Ink from which on a pixel counts as drawn.

    Raises:
        InputError: The file is missing, no picture, or more than `MOST_INK` of it is ink.
    """
    ink = read_reference(path)
    share = ink_share(ink, threshold)
    if share > MOST_INK:
        raise InputError(path, f"{share:.0%} of it is ink", "lines on paper, at most a third of it ink")
    return ink


def line_width(ink: Image, threshold: float = DEFAULT_THRESHOLD) -> float:
    """Mean width in pixels of what counts as drawn: four times its mean distance from its edges; 0 for nothing."""
    mask = binarise(ink, threshold)
    distance = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    # Of a pixel the distance to the middle of the next one is known, half a pixel behind the edge.
    return 4.0 * float(distance[mask].mean() - 0.5) if mask.any() else 0.0


def ink_share(ink: Image, threshold: float = DEFAULT_THRESHOLD) -> float:
    """Share of a picture that counts as drawn."""
    return float(binarise(ink, threshold).mean())
