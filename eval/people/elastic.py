"""A drawing bent so that its outline lies on the mesh's: only where it is asked for, since it takes real error away."""

import math

import cv2
import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree

from eval.people.outline import DrawnOutline
from ncmodel.types import Image

REACH = 0.03
"""Share of the picture's diagonal that an outline is bent at most; what is farther off is something else."""
_POINTS = 160
_STIFFNESS = 30.0
"""Of the thin plate, in squared pixels of a picture 768 wide."""
_STEP = 16
"""Pixels between the places where the plate is evaluated."""


def bent(ink: Image, drawn: DrawnOutline, goal: DrawnOutline) -> Image:
    """(H, W) a drawing bent smoothly (thin plate spline) so that its outline comes to lie on another.

    Args:
        ink: (H, W) the drawing, 1 = line.
        drawn: Its outline.
        goal: Where the outline is to be, in a picture of the same size.
    """
    height, width = ink.shape
    away, nearest = cKDTree(drawn.points).query(goal.points)
    near = np.flatnonzero(away <= REACH * math.hypot(width, height))
    chosen = near[np.unique(np.linspace(0, len(near) - 1, min(len(near), _POINTS)).astype(np.intp))]
    if len(chosen) < 8:
        return ink
    # Where each place of the result is taken from.
    shift = drawn.points[nearest[chosen]] - goal.points[chosen]
    stiffness = _STIFFNESS * (max(width, height) / 768) ** 2
    plate = RBFInterpolator(goal.points[chosen], shift, kernel="thin_plate_spline", smoothing=stiffness)
    columns, rows = np.arange(0, width + _STEP, _STEP), np.arange(0, height + _STEP, _STEP)
    coarse = plate(np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)).reshape(len(rows), len(columns), 2)
    u, v = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    fields = (cv2.remap(coarse[..., n].astype(np.float32), u / _STEP, v / _STEP, cv2.INTER_LINEAR) for n in (0, 1))
    right, down = fields
    return np.asarray(cv2.remap(ink, u + right, v + down, cv2.INTER_LINEAR), dtype=np.float32)
