"""Many drawings on one picture, each with its name."""

import math
from collections.abc import Sequence

import cv2
import numpy as np

from ncmodel.pictures import Pixels, from_ink, shrink
from ncmodel.types import Image

CELL = 256
"""Pixels of a drawing's cell; its name gets `CAPTION` more below."""
CAPTION = 24
THUMBNAIL_WIDTH = 4.0
"""Line width, at 768, of drawings that are to be scaled down: thinner lines would turn grey."""
_FONT = cv2.FONT_HERSHEY_SIMPLEX


def thumbnail(ink: Image) -> Pixels:
    """A drawing scaled down to fit a cell."""
    return shrink(from_ink(ink), CELL)


def contact_sheet(drawings: Sequence[tuple[str, Pixels]]) -> Pixels:
    """Thumbnails with their names in a grid, in their order, about as wide as high."""
    columns = max(1, math.ceil(math.sqrt(len(drawings))))
    rows = max(1, math.ceil(len(drawings) / columns))
    sheet = np.full((rows * (CELL + CAPTION), columns * CELL), 255, dtype=np.uint8)
    for index, (name, small) in enumerate(drawings):
        top, left = index // columns * (CELL + CAPTION), index % columns * CELL
        height, width = small.shape
        top_of, left_of = top + (CELL - height) // 2, left + (CELL - width) // 2
        sheet[top_of : top_of + height, left_of : left_of + width] = small
        _write(sheet, name, left, top + CELL)
    return sheet


def _write(sheet: Pixels, name: str, left: int, top: int) -> None:
    """A caption in the middle of its cell, in letters that the font has, smaller or cut short if it must be."""
    text = name.encode("ascii", "replace").decode()
    scale = 0.45
    while text and cv2.getTextSize(text, _FONT, scale, 1)[0][0] > CELL - 8:
        text = text[:-1]
    width = cv2.getTextSize(text, _FONT, scale, 1)[0][0]
    place = (left + (CELL - width) // 2, top + CAPTION - 9)
    cv2.putText(sheet, text, place, _FONT, scale, 0, 1, cv2.LINE_AA)
