"""The published code's way from the image branch's output to lines: where its Hessian says valley, on 8 bits."""

import cv2
import numpy as np
from skimage.feature import hessian_matrix, hessian_matrix_eigvals
from skimage.morphology import skeletonize

from ncmodel.model.ridge_detection import Ridges, chained, neighbours
from ncmodel.types import Image, Mask, Stroke

PAPER = 220
"""Levels from here on, of 255, are paper."""

SIGMA = 3.7
"""Standard deviation of the smoothing, pixels."""

LEAST_CURVATURE = 0.0015
"""Larger eigenvalue of the Hessian, of brightness 0..1 a square pixel, from which on a pixel is of a line."""

EROSION = 5
"""Side, pixels, of the square that lines are eroded by."""


def line_mask(brightness: Image) -> Mask:
    """Pixels of lines.

    Args:
        brightness: (H, W) probability of paper in [0, 1]: 1 minus that of a line.
    """
    levels = (brightness * np.float32(255.0)).astype(np.uint8)  # cut, not rounded
    levels[levels >= PAPER] = 255
    # Outside the picture the published code takes 0; derivatives are differences of the smoothed picture.
    hessian = hessian_matrix(levels, SIGMA, mode="constant", cval=0, order="rc", use_gaussian_derivatives=False)
    valley = hessian_matrix_eigvals(hessian)[0] >= LEAST_CURVATURE
    square = np.ones((EROSION, EROSION), dtype=np.uint8)
    return np.asarray(cv2.erode(valley.astype(np.uint8), square), dtype=np.bool_)


def centre_lines(mask: Mask) -> tuple[Stroke, ...]:
    """Strokes along the middle of a mask's lines, in its pixels."""
    thin = skeletonize(mask)
    rows, columns = np.nonzero(thin)
    ends = neighbours(thin)
    points = np.stack([columns, rows], axis=1).astype(np.float64) + 0.5
    return chained(Ridges(points[ends], np.ones(ends.shape)))
