"""How a picture of any shape sits in the square that the networks see: scaled by area averaging, centred, padded.

Area averaging keeps the amount of ink: a line too thin for the smaller picture turns grey instead of breaking up.
"""

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np

from ncmodel.types import Floats, Image, Ints


@cache
def overlap(inputs: int, outputs: int) -> Floats:
    """(outputs, inputs) weights that average `inputs` cells over `outputs` equal cells; every row sums to 1."""
    edges = np.arange(outputs + 1) * (inputs / outputs)
    low, high = edges[:-1, None], edges[1:, None]
    cells = np.arange(inputs)[None, :]
    shared = np.minimum(high, cells + 1) - np.maximum(low, cells)
    weights: Floats = np.clip(shared, 0.0, None) * (outputs / inputs)
    weights.setflags(write=False)
    return weights


@dataclass(frozen=True)
class Square:
    """Placement of a picture of height x width in a square.

    Attributes:
        height: Of the picture, pixels.
        width: Of the picture, pixels.
        size: Side of the square, pixels.
    """

    height: int
    width: int
    size: int

    def __post_init__(self) -> None:
        if min(self.height, self.width, self.size) < 1:
            raise ValueError(f"{self}: expected positive numbers of pixels")

    @property
    def inner(self) -> tuple[int, int]:
        """(rows, columns) that the picture takes up in the square: the longer side fills it."""
        scale = self.size / max(self.height, self.width)
        return max(1, round(self.height * scale)), max(1, round(self.width * scale))

    @property
    def corner(self) -> tuple[int, int]:
        """(row, column) of the picture's top left corner in the square."""
        rows, columns = self.inner
        return (self.size - rows) // 2, (self.size - columns) // 2

    def fit(self, image: Image, background: float) -> Image:
        """(..., height, width) picture -> (..., size, size), `background` around it.

        Raises:
            ValueError: The image has another size.
        """
        if image.shape[-2:] != (self.height, self.width):
            raise ValueError(f"image has shape {image.shape}, expected (..., {self.height}, {self.width})")
        (rows, columns), (top, left) = self.inner, self.corner
        out = np.full((*image.shape[:-2], self.size, self.size), background, dtype=np.float32)
        placed = out[..., top : top + rows, left : left + columns]
        for index in np.ndindex(image.shape[:-2]):
            placed[index] = _averaged(image[index], rows, columns)
        return out

    def spread(self, pixels: Ints) -> tuple[Ints, Ints, Floats]:
        """What single pixels of the picture add to the square: the same averaging as `fit`, written sparsely.

        Args:
            pixels: (P,) flat indices into the picture.

        Returns:
            Three arrays of equal length: index into `pixels`, flat index into the square, weight.
        """
        (rows, columns), (top, left) = self.inner, self.corner
        row_of, row_cell, row_weight = _entries(overlap(self.height, rows), pixels // self.width)
        entry_of, column_cell, column_weight = _entries(overlap(self.width, columns), (pixels % self.width)[row_of])
        cell = (top + row_cell[entry_of]) * self.size + left + column_cell
        return row_of[entry_of], cell, row_weight[entry_of] * column_weight

    def to_picture(self, points: Floats) -> Floats:
        """(..., 2) points (u, v) in the square -> the same points in the picture."""
        (rows, columns), (top, left) = self.inner, self.corner
        scale = np.array([self.width / columns, self.height / rows])
        moved: Floats = (points - np.array([left, top])) * scale
        return moved


def _averaged(image: Image, rows: int, columns: int) -> Image:
    """(rows, columns) area averages of a picture."""
    height, width = image.shape
    if rows <= height and columns <= width:
        return np.asarray(cv2.resize(image, (columns, rows), interpolation=cv2.INTER_AREA))
    # OpenCV's area averaging only shrinks.
    down, across = overlap(height, rows).astype(np.float32), overlap(width, columns).astype(np.float32)
    return np.asarray(down @ image @ across.T)


def _entries(weights: Floats, chosen: Ints) -> tuple[Ints, Ints, Floats]:
    """The nonzero weights of some inputs: index into `chosen`, output, weight."""
    columns = weights.T[chosen]
    index, output = np.nonzero(columns)
    return index, output, columns[index, output]
