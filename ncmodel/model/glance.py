"""A drawing from afar: how much ink lies in each cell of a coarse grid.

What a ranking module thinks of two drawings differs little if they look alike from there, whichever families their
lines are of: where two families run along each other, one may fade away and hardly anything has changed.

Letters in shapes: B drawings, P pixels that carry lines, K of them that are looked at, C cells.
"""

import numpy as np

from ncmodel.types import Floats, Image, Ints

SIDE = 12
"""Cells along each side of the picture."""

PIXELS = 4096
"""Pixels that are looked at: a thousand drawings are seen in some hundredths of a second."""

FAINT = 0.05
"""Of the fullest cell's ink, the share that is added to all cells: the first line in an empty one isn't everything."""


class Glance:
    """Looks at drawings of one view.

    Args:
        pixels: (P,) flat indices of the pixels that carry lines, in rising order; at least one.
        ink: (P,) of all lines together, unfaded.
        shape: (height, width) of the picture.

    Attributes:
        pixels: (K,) indices into P of those that are looked at: cell after cell.
    """

    def __init__(self, pixels: Ints, ink: Image, shape: tuple[int, int]) -> None:
        rows, columns = np.divmod(pixels, shape[1])
        cells = rows * SIDE // shape[0] * SIDE + columns * SIDE // shape[1]
        some = np.arange(0, len(pixels), -(-len(pixels) // PIXELS))
        self.pixels: Ints = some[np.argsort(cells[some], kind="stable")]
        self._first = np.flatnonzero(np.diff(cells[self.pixels], prepend=-1))
        full = np.add.reduceat(ink[self.pixels].astype(np.float64), self._first)
        self._faint = max(FAINT * float(full.max()), 1e-6)
        self._unit = float(np.sqrt((full + self._faint).sum()))

    def __call__(self, ink: Image) -> Floats:
        """(B, K) ink of drawings -> (B, C) square roots of ink, of which a hand sees equal steps as equal.

        All lines together are at distance 1 from the origin.
        """
        cells = np.add.reduceat(ink.astype(np.float64), self._first, axis=1)
        seen: Floats = np.sqrt(cells + self._faint) / self._unit
        return seen
