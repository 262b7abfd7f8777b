"""What the decision tree knows of a pixel: curvature and gradient maps of its view, at several scales.

`PICTURE` are properties of pictures: n.v, the length of its gradient and the two curvatures of it as a height field
(eigenvalues of its Hessian), and the length of depth's gradient. `SURFACE` are properties of the surface: the principal
curvatures, the radial curvature kr and sin(theta) DwKr that suggestive contours go by, and the view-dependent curvature
q1 that apparent ridges go by.
"""

import cv2
import numpy as np

from ncmodel.geometry.shading import interpolate
from ncmodel.scene.view import PERCENTILE, View
from ncmodel.types import Floats, Image, Mask

SCALES = (1.0, 2.0, 4.0)
"""Standard deviations of the Gaussians that maps are smoothed with, pixels of pictures whose shorter side is `SIDE`."""

SIDE = 768

PICTURE = ("n_dot_v", "gradient", "largest_curvature", "smallest_curvature", "depth_gradient")
SURFACE = ("k1", "k2", "kr", "sc_num", "q1")
NAMES = tuple(f"{name}_{scale:g}" for scale in SCALES for name in (*PICTURE, *SURFACE))
"""The features, in the order of their maps."""


def feature_maps(view: View) -> Image:
    """(F, H, W) the maps called `NAMES`; those of the surface are 0 where none is seen.

    Lengths are in pixels of pictures whose shorter side is `SIDE`, and quantities of the surface in units of the 90th
    percentile of their size over what is seen, squashed to (-1, 1): beside creases some are a million times as large.
    """
    unit = min(view.camera.width, view.camera.height) / SIDE
    hit = view.buffers.hit
    quantities = (view.surface.k1, view.surface.k2, view.kr, view.sc_num, view.q1)
    surface = [
        _squashed(interpolate(view.buffers, view.surface.faces, np.ascontiguousarray(q)), hit) for q in quantities
    ]
    maps: list[Image | Floats] = []
    for scale in SCALES:
        brightness, depth = (_smoothed(picture, scale * unit) for picture in (view.shaded[0], view.depth))
        largest, smallest = _curvatures(brightness)
        maps += [brightness, _slope(brightness) * unit, largest * unit**2, smallest * unit**2, _slope(depth) * unit]
        # Averages are over the surface alone: the background has no curvature.
        share = np.maximum(_smoothed(hit.astype(np.float32), scale * unit), 1e-6)
        maps += [np.where(hit, _smoothed(values, scale * unit) / share, 0.0) for values in surface]
    return np.stack(maps).astype(np.float32)


def near_surface(view: View) -> Mask:
    """(H, W) the pixels whose features differ from those of empty paper: the surface, and what is near it."""
    # Of its Gaussians OpenCV takes four standard deviations, and differences reach two pixels further.
    reach = int(np.ceil(4 * max(SCALES) * min(view.camera.width, view.camera.height) / SIDE)) + 2
    kernel = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    return np.asarray(cv2.dilate(view.buffers.hit.astype(np.uint8), kernel) > 0)


def _squashed(values: Image, hit: Mask) -> Image:
    size = np.abs(values[hit])
    unit = float(np.percentile(size, PERCENTILE)) if size.any() else 1.0
    scaled = values / (unit or 1.0)
    return np.asarray(scaled / (1.0 + np.abs(scaled)), dtype=np.float32)


def _smoothed(picture: Image, sigma: float) -> Image:
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE))


def _slope(picture: Image) -> Image:
    """(H, W) length of the gradient, per pixel."""
    down, across = np.gradient(picture)
    return np.asarray(np.hypot(down, across))


def _curvatures(picture: Image) -> tuple[Floats, Floats]:
    """(H, W) the larger and the smaller eigenvalue of the Hessian."""
    down, across = np.gradient(picture)
    (hvv, huv), (_, huu) = np.gradient(down), np.gradient(across)
    mean, half = (hvv + huu) / 2, np.hypot((hvv - huu) / 2, huv)
    return mean + half, mean - half
