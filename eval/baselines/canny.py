"""Canny edges of the shaded picture, as Cole et al. (2008) suggest, with parameters found by grid search."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from eval.measures.evaluation import Target
from ncmodel.chamfer import chamfer_distance
from ncmodel.scene.view import View
from ncmodel.types import Floats, Image

GRADIENT_UNIT = 8192.0
"""Gradients go into OpenCV's detector as 16-bit numbers: a step from black to white in one pixel is this many."""


@dataclass(frozen=True)
class CannySettings:
    """Parameters of the edge detector (Canny 1986).

    Attributes:
        sigma: Of the Gaussian that smooths the picture first, pixels; 0 for none.
        high: Brightness per pixel above which an edge starts; white is 1.
        low: Brightness per pixel down to which an edge is followed.
    """

    sigma: float = 1.0
    high: float = 0.06
    low: float = 0.03


GRID = tuple(
    CannySettings(sigma, high, share * high)
    for sigma, high, share in product((1.0, 2.0, 3.0), (0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.12), (0.25, 0.5))
)
"""What the grid search tries."""


def draw(view: View, settings: CannySettings) -> Image:
    """(H, W) ink of the edges in the shaded picture of a view; one pixel wide."""
    return edges(view.shaded[0], settings)


def edges(brightness: Image, settings: CannySettings) -> Image:
    """(H, W) ink of the edges in a picture of values in [0, 1]."""
    smooth = np.asarray(brightness, dtype=np.float32)
    if settings.sigma > 0.0:
        smooth = np.asarray(cv2.GaussianBlur(smooth, (0, 0), settings.sigma, borderType=cv2.BORDER_REPLICATE))
    across, down = (_slope(smooth, axis) for axis in ((1, 0), (0, 1)))
    low, high = settings.low * GRADIENT_UNIT, settings.high * GRADIENT_UNIT
    found = cv2.Canny(across, down, low, high, L2gradient=True)
    return np.asarray(found > 0, dtype=np.float32)


def _slope(picture: Image, axis: tuple[int, int]) -> NDArray[np.int16]:
    """Brightness per pixel along an axis, times `GRADIENT_UNIT`; Sobel's kernel gives 8 for a slope of 1."""
    slope = cv2.Sobel(picture, cv2.CV_32F, *axis, ksize=3, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(np.rint(np.asarray(slope) * (GRADIENT_UNIT / 8.0)), dtype=np.int16)


def search(examples: Sequence[tuple[View, Target]], grid: Sequence[CannySettings] = GRID) -> CannySettings:
    """The parameters with the least mean Chamfer distance to the references of training views.

    Args:
        examples: Views and what their drawings are judged by; at least one.
        grid: What to try; the first of equals is taken.
    """
    if not examples:
        raise ValueError("no examples to choose parameters by")
    costs = np.mean([example_costs(view, target, grid) for view, target in examples], axis=0)
    return grid[int(np.argmin(costs))]


def example_costs(view: View, target: Target, grid: Sequence[CannySettings] = GRID) -> Floats:
    """(N,) Chamfer distances of N settings on one view, the mean over its references."""
    drawings = (target.prepare(draw(view, settings)) for settings in grid)
    means = [np.mean([chamfer_distance(lines, other) for other in target.references.values()]) for lines in drawings]
    return np.array(means, dtype=np.float64)
