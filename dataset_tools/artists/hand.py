"""How a hand draws a line: smoothly, not quite where it is, and a little too far."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter1d

from dataset_tools.artists.motif import Motif, at
from dataset_tools.artists.polylines import STEP, Polyline
from ncmodel.types import Floats, Image

GRID = 5
"""Nodes along a side of the field by which a whole drawing is out of place."""
AT_THE_EDGE = 0.5
"""The silhouette is seen best: it is out of place by this share."""
INSIDE = 50.0
"""Pixels from the silhouette where lines are out of place entirely."""


@dataclass(frozen=True)
class Hand:
    """What is an artist's own in the drawing of lines.

    Attributes:
        smoothing: Standard deviation of what is smoothed away along a line, pixels.
        misplaced: Typical distance of a place in the drawing from where it is, pixels.
        wobble: Typical distance of a line from where it was meant, pixels.
        overshoot: How far lines run on at their ends, at most, pixels.
    """

    smoothing: float
    misplaced: float
    wobble: float
    overshoot: float

    def field(self, motif: Motif, rng: np.random.Generator) -> Image:
        """(H, W, 2) by how much each place is out of place."""
        nodes = rng.normal(0.0, self.misplaced, (GRID, GRID, 2)).astype(np.float32)
        field = cv2.resize(nodes, motif.shape[::-1], interpolation=cv2.INTER_CUBIC)
        share = AT_THE_EDGE + (1.0 - AT_THE_EDGE) * np.minimum(motif.from_silhouette / INSIDE, 1.0)
        return np.asarray(field * share[..., None])

    def draw(self, line: Polyline, field: Image, rng: np.random.Generator, steady: bool = False) -> Polyline:
        """A line as this hand draws it; an outline more steadily."""
        points = smoothed(line.points, self.smoothing / 2 if steady else self.smoothing)
        if steady:
            return Polyline(points + at(field, points), line.kind, line.salience)
        points = _overshot(points, rng.uniform(0.0, self.overshoot, 2))
        wobble = _wobble(len(points), rng) * self.wobble
        points = points + at(field, points) + wobble
        return Polyline(points, line.kind, np.full(len(points), line.salience.mean()))


def smoothed(points: Floats, sigma: float) -> Floats:
    """Points of a line smoothed along it; its ends stay, and a closed line stays closed."""
    if len(points) < 4:
        return points
    steps = min(sigma / STEP, len(points) / 6)
    if np.linalg.norm(points[0] - points[-1]) < 1.5 * STEP:
        return np.asarray(gaussian_filter1d(points, steps, axis=0, mode="wrap"))
    # What is mirrored at a line's end through that end keeps the end and its direction.
    reach = min(len(points) - 1, int(4 * steps) + 1)
    before, after = 2 * points[0] - points[reach:0:-1], 2 * points[-1] - points[-2 : -reach - 2 : -1]
    return np.asarray(gaussian_filter1d(np.concatenate([before, points, after]), steps, axis=0)[reach:-reach])


def _overshot(points: Floats, lengths: Floats) -> Floats:
    """A line that runs straight on by `lengths` pixels at its two ends."""
    reach = min(4, len(points) - 1)
    ends = []
    for tip, inner, length in ((points[0], points[reach], lengths[0]), (points[-1], points[-1 - reach], lengths[1])):
        away = tip - inner
        steps = np.arange(1, int(length / STEP) + 1)[:, None] * STEP
        ends.append(tip + steps * away / max(float(np.linalg.norm(away)), 1e-9))
    return np.concatenate([ends[0][::-1], points, ends[1]])


def _wobble(count: int, rng: np.random.Generator) -> Floats:
    """(count, 2) a slow wander about 0, of a typical size of 1."""
    turns = count * STEP / rng.uniform(120.0, 300.0, 2)
    phase = rng.uniform(0.0, 2 * np.pi, 2)
    at_place = np.linspace(0.0, 1.0, count)[:, None]
    aside = rng.normal(0.0, 0.7, 2)
    return np.asarray(aside + np.sin(2 * np.pi * turns * at_place + phase))
