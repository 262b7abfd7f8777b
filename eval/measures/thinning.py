"""Drawings as thin masks: reading, thresholding, thinning to one pixel, taking silhouettes away."""

from pathlib import Path

import cv2
import numpy as np

from ncmodel.chamfer import distance_to
from ncmodel.errors import ArgumentError
from ncmodel.images import read_grey
from ncmodel.types import Image, Mask

DEFAULT_THRESHOLD = 0.5
"""Ink from which on a pixel counts as drawn: half covered by a full-black line."""

HALF_LEVEL = 0.002
"""Half a grey level of an 8-bit file: ink at the threshold still reaches it after it was written and read."""


def read_ink(path: str | Path) -> Image:
    """(H, W) ink of a drawing, 1 = line, from a picture with dark lines on light paper.

    Raises:
        InputError: The file is missing or no picture.
    """
    return np.asarray(1.0 - read_grey(path), dtype=np.float32)


def binarise(ink: Image, threshold: float = DEFAULT_THRESHOLD) -> Mask:
    """(H, W) pixels with at least `threshold` ink.

    Raises:
        UsageError: The threshold is outside (0, 1]: at 0 the paper itself would count.
    """
    if not 0.0 < threshold <= 1.0:
        raise ArgumentError("threshold", str(threshold), "a number above 0 and up to 1")
    return np.asarray(ink >= threshold - HALF_LEVEL)


def thin(mask: Mask) -> Mask:
    """The mask's lines one pixel wide, connected as before (Zhang and Suen 1984).

    scikit-image's version keeps every connected part; OpenCV's, of the same name, deletes 2 x 2 squares and takes 2.5
    times as long.
    """
    from skimage.morphology import skeletonize

    return np.asarray(skeletonize(mask), dtype=np.bool_)


def thin_lines(ink: Image, threshold: float = DEFAULT_THRESHOLD) -> Mask:
    """A drawing as it is compared: thresholded, then thinned to one pixel.

    Raises:
        UsageError: The threshold is outside (0, 1].
    """
    return thin(binarise(ink, threshold))


def outline(shape: Mask) -> Mask:
    """The pixels of a region that have a neighbour (of four) outside it.

    Of a line a few pixels wide that is nearly all of it, so that an object's filled mask and a drawing of its outline
    give the same. A region cut off by the frame has no outline along the frame.
    """
    kernel = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    inner = cv2.erode(shape.astype(np.uint8), kernel, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(shape & (inner == 0))


def silhouette_band(silhouette: Mask, margin: float) -> Mask:
    """(H, W) pixels within `margin` of a silhouette's outline: what is taken away from both drawings.

    Args:
        silhouette: An object's filled mask, or its drawn outline.
        margin: Pixels; drawn silhouettes lie that far from the true one at most.
    """
    line = outline(silhouette)
    if not line.any():
        return line
    return np.asarray(distance_to(line) <= margin)
