"""From a scan or a photo of paper to ink: grey paper, uneven light and a pale print taken away, pencil made black."""

import cv2
import numpy as np

from ncmodel.types import Image, Mask

_THICKEST = 0.015
"""Share of the shorter side: what is dark and wider than this is no line but paper, shade or a printed rendering."""

_NOISE = 4.0
"""Standard deviations of the paper's grain that a line is darker by, at least."""
_FAINTEST = 0.04
"""Of the paper's brightness: the faintest pencil told from paper without grain."""

_SPECK = 0.006
"""Share of the shorter side: shorter marks are dirt."""


def paper_brightness(brightness: Image) -> Image:
    """(H, W) what the paper would be like without its lines, from a picture in [0, 1].

    Whatever is thinner than `_THICKEST` and darker than what is around it is closed (grey closing); light that falls
    off and a printed rendering, which is neither, stay.
    """
    size = _odd(_THICKEST * min(brightness.shape))
    # The grain's bright side must not be taken for the paper.
    calm = cv2.GaussianBlur(brightness, (0, 0), 1.5)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    closed = cv2.morphologyEx(calm, cv2.MORPH_CLOSE, kernel, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(cv2.GaussianBlur(closed, (0, 0), size / 8), dtype=np.float32)


def line_darkness(brightness: Image) -> Image:
    """(H, W) how much darker than the paper each pixel is, as a share of the paper's brightness; 0..1."""
    paper = np.maximum(paper_brightness(brightness), 0.02)
    return np.asarray(np.clip(1.0 - brightness / paper, 0.0, 1.0), dtype=np.float32)


def pencil_ink(brightness: Image) -> Image:
    """(H, W) ink of a drawing on paper, 1 = line, 0.5 where a pixel is as dark as counts.

    Args:
        brightness: (H, W) in [0, 1].

    The level that counts is between the paper's grain and the lines (Otsu's threshold among what is darker than the
    grain), so faint pencil is as black as ink.
    """
    darkness = line_darkness(brightness)
    calm = np.asarray(cv2.GaussianBlur(darkness, (0, 0), 0.7), dtype=np.float32)
    level = _level(calm)
    ink = np.clip(calm / (2.0 * level), 0.0, 1.0)
    return np.where(_lasting(calm >= level, min(brightness.shape)), ink, 0.0).astype(np.float32)


def _level(darkness: Image) -> float:
    """Darkness from which on a pixel is a line's."""
    grain = 1.4826 * float(np.median(np.abs(darkness - np.median(darkness))))
    floor = max(_FAINTEST, float(np.median(darkness)) + _NOISE * grain)
    dark = darkness[darkness > floor]
    if dark.size < 16:
        return max(floor, 0.5)
    return max(floor, _otsu(dark) / 2)


def _otsu(values: Image) -> float:
    bytes_ = np.clip(np.rint(255.0 * values), 0, 255).astype(np.uint8)
    threshold, _ = cv2.threshold(bytes_.reshape(1, -1), 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    return float(threshold) / 255.0


def _lasting(mask: Mask, side: int) -> Mask:
    """A mask, grown by two pixels for the lines' soft edges, without specks."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    extent = np.maximum(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT])
    large = extent >= max(3.0, _SPECK * side)
    large[0] = False
    return np.asarray(cv2.dilate(large[labels].astype(np.uint8), np.ones((5, 5), np.uint8)) > 0)


def _odd(size: float) -> int:
    return max(3, 2 * round(size / 2) + 1)
