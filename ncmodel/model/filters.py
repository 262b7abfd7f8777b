"""Line drawings as functions of thresholds: equations 1-5 of the paper, differentiable in t.

The equations hold for each pixel on its own, so the last dimension may list all pixels of a picture or only those that
carry lines; whoever works on whole pictures flattens them. Letters in shapes: B drawings, P pixels, K of them that are
looked at, C cells.
"""

import numpy as np
import torch
from torch import Tensor

from ncmodel.types import Floats, Image, Ints

SMALLEST_FEATURE = 1e-6
"""Features below this count as this one: they fade within a threshold of a millionth of the 90th percentile, and the
gradient -1/feature stays a number that sums can hold."""

CELLS = 12
"""Cells along each side of the picture."""

LOOKED_AT = 4096
"""Pixels that are looked at: a thousand drawings are seen in some hundredths of a second."""

FAINT = 0.05
"""Of the fullest cell's ink, the share that is added to all cells: the first line in an empty one isn't everything."""


def line_drawing(lines: Tensor, features: Tensor, always: Tensor, thresholds: Tensor) -> Tensor:
    """I_G(t) = max(I_S(t_S), I_R(t_R), I_V(t_V), I_A(t_A), I_C, I_B) of equation 5, for one or many t.

    Equations 1-4 are the same for every family: S(x) max(1 - t/Dk(x), 0). As I_C and I_B are never negative, it makes
    no difference to the largest of all if that is S(x) - t S(x)/Dk(x), whose second part is the same for all t.

    At t = 0 all lines are there, whatever their features; from t = `SMALLEST_FEATURE` on none is where the feature
    isn't positive. Gradients are finite everywhere.

    Args:
        lines: (4, P) ink in [0, 1] of suggestive contours S, ridges R, valleys V and apparent ridges A, unfiltered.
        features: (4, P) Dk, k1, k2 (valleys: positive where concave) and, for apparent ridges, q1, in units of their
            90th percentiles. Equation 4 writes k_t there, Judd et al.'s view-dependent curvature; q1, as rtsc
            computes it, is the square of that curvature.
        always: (P,) ink of what no threshold filters: the larger of contours I_C and boundaries I_B.
        thresholds: (B, 4) t = (t_S, t_R, t_V, t_A), each at least 0.

    Returns:
        (B, P) ink.

    Raises:
        ValueError: The shapes don't fit together.
    """
    if lines.shape != features.shape or lines.ndim != 2 or len(lines) != 4 or always.shape != lines.shape[1:]:
        shapes = [tuple(part.shape) for part in (lines, features, always)]
        raise ValueError(f"lines, features and always have shapes {shapes}, expected (4, P), (4, P) and (P,)")
    if thresholds.ndim != 2 or thresholds.shape[1] != 4:
        raise ValueError(f"thresholds have shape {tuple(thresholds.shape)}, expected (B, 4)")
    drawn = always.expand(len(thresholds), -1)
    for line, feature, t in zip(lines, features, thresholds.T, strict=True):
        steepness = line / feature.clamp(min=SMALLEST_FEATURE)
        drawn = torch.maximum(drawn, torch.addcmul(line, t[:, None], steepness, value=-1))
    return drawn


class Fading:
    """How much ink of one family is left at which threshold.

    With pixels in order of falling feature, those above t keep sum(S) - t sum(S / feature), which is linear in t
    between two features: so share and threshold can be told from each other.

    Args:
        ink: (P,) S.
        feature: (P,) what filters it.
    """

    def __init__(self, ink: Image, feature: Image) -> None:
        drawn = ink > 0
        strength, own = np.maximum(feature[drawn].astype(np.float64), 1e-12), ink[drawn].astype(np.float64)
        order = np.argsort(-strength, kind="stable")
        strength, own = strength[order], own[order]
        self._total, self._steepness = np.cumsum(own), np.cumsum(own / strength)
        self._left = self._total - strength * self._steepness

    @property
    def present(self) -> bool:
        """Whether the family has lines in this view."""
        return len(self._total) > 0

    def threshold(self, share: float) -> float:
        """The t at which `share` of the ink is left: 0 for share 1, the largest feature for share 0."""
        wanted, last = share * self._total[-1], self._above(share)
        return float(max((self._total[last] - wanted) / self._steepness[last], 0.0))

    def _above(self, share: float) -> int:
        """The last pixel, in order of falling feature, that isn't gone where `share` of the ink is left."""
        return max(int(np.searchsorted(self._left, share * self._total[-1], side="right")) - 1, 0)


class Glance:
    """Looks at drawings of one view from afar: how much ink lies in each cell of a coarse grid.

    What a ranking module thinks of two drawings differs little if they look alike from there, whichever families their
    lines are of: where two run along each other, one may fade away and hardly anything has changed.

    Args:
        pixels: (P,) flat indices of the pixels that carry lines, in rising order; at least one.
        ink: (P,) of all lines together, unfaded.
        shape: (height, width) of the picture.

    Attributes:
        pixels: (K,) indices into P of those that are looked at: cell after cell.
    """

    def __init__(self, pixels: Ints, ink: Image, shape: tuple[int, int]) -> None:
        rows, columns = np.divmod(pixels, shape[1])
        cells = rows * CELLS // shape[0] * CELLS + columns * CELLS // shape[1]
        some = np.arange(0, len(pixels), -(-len(pixels) // LOOKED_AT))
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
