"""Distances of pixels to drawn ones."""

import cv2
import numpy as np

from ncmodel.types import Image, Mask


def distance_to(mask: Mask) -> Image:
    """(H, W) Euclidean distance of every pixel to the nearest pixel of a mask, in pixels.

    OpenCV rounds the last bit now up, now down, depending on where in memory a picture happens to lie. Squares of
    distances are whole numbers; up to about 1,000 pixels that tells which one was meant.

    Raises:
        ValueError: The mask is empty.
    """
    if not mask.any():
        raise ValueError("the distance to an empty mask is undefined")
    distance = cv2.distanceTransform((~mask).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    square = np.square(distance, dtype=np.float32)
    np.rint(square, out=square)
    return np.asarray(np.sqrt(square, out=square))
