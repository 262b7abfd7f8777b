"""Lines that no curvature explains: where an artist sees the light turn, on a shape without its small bumps."""

import cv2
import numpy as np

from dataset_tools.artists.motif import CLEAR, Motif, at
from dataset_tools.artists.polylines import STEP, Polyline, resampled, runs
from ncmodel.types import Floats, Image

KIND = "shading"
TYPICAL_SLOPE = 0.012
"""Change of the shading a pixel at which a line's salience is 1/2."""


def shading_lines(motif: Motif, light: Floats, level: float, blur: float) -> list[Polyline]:
    """The line between light and dark.

    Args:
        motif: What is drawn.
        light: (3,) the direction of the light: right, up, towards the eye.
        level: The share of the shape that is dark.
        blur: Standard deviation of what is too small to be seen, pixels.
    """
    weight = np.maximum(_blurred(motif.hit.astype(np.float32), blur), 1e-3)
    smooth = np.stack([_blurred(motif.normals[..., k], blur) / weight for k in range(3)], axis=-1)
    smooth /= np.maximum(np.linalg.norm(smooth, axis=-1, keepdims=True), 1e-6)
    shade = (smooth @ np.asarray(light / np.linalg.norm(light), dtype=np.float32)).astype(np.float32)
    if not motif.hit.any():
        return []
    dark = (shade < np.quantile(shade[motif.hit], level)) & motif.hit
    slope = np.hypot(cv2.Sobel(shade, cv2.CV_32F, 1, 0, scale=1 / 8), cv2.Sobel(shade, cv2.CV_32F, 0, 1, scale=1 / 8))
    rings, _ = cv2.findContours(dark.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    found: list[Polyline] = []
    for ring in rings:
        if len(ring) > CLEAR:
            found += _parts(motif, ring[:, 0].astype(np.float64) + 0.5, slope)
    return found


def _parts(motif: Motif, ring: Floats, slope: Image) -> list[Polyline]:
    """The parts of a closed line that are far enough from the silhouette."""
    clear = np.asarray(at(motif.from_silhouette, ring) > CLEAR)
    if not clear.all():
        start = int(np.argmin(clear))
        ring, clear = np.roll(ring, -start, axis=0), np.roll(clear, -start)
    steep = at(slope, ring).astype(np.float64)
    salience = steep / (steep + TYPICAL_SLOPE)
    return [
        resampled(ring[begin:end], KIND, salience[begin:end]) for begin, end in runs(clear) if end - begin > 10 * STEP
    ]


def _blurred(image: Image, blur: float) -> Image:
    return np.asarray(cv2.GaussianBlur(image, (0, 0), blur), dtype=np.float32)
