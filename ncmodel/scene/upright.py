"""Shapes that lie on their side because their file is z-up: told by what is left and right.

Animals, vehicles and bones mirror themselves from left to right, and in no other direction. Where that direction is
drawn as upwards, the shape lies on its side, and the file is z-up. Shapes that mirror themselves along x say nothing
about y and z; nor do plates and parts cut out of them, which are the same above and below. They get no note.
"""

import numpy as np

from ncmodel.scene.surface import Surface
from ncmodel.types import Floats

SAMPLE = 50_000
"""So many vertices at most tell where the shape is,"""
MIRROR_SAMPLE = 500
"""and of these so many are looked up."""
MIRRORED = 0.005
"""Mean distance, in object space, of mirror images from the nearest vertex, up to which a shape mirrors itself."""
DIFFERENT = 4.0
"""How many times as far they are in directions in which it doesn't."""
THIN = 0.15
"""A shape lower than this, in object space, is a plate."""
PLANE = 0.05
"""Share of the vertices in one plane at the top or at the bottom, from which on a part is cut out of a plate."""


def looks_z_up(surface: Surface) -> tuple[str, ...]:
    """A note if a shape mirrors itself upwards and in no other direction; none for most shapes."""
    vertices = surface.mesh.used_vertices
    points = vertices[:: -(-len(vertices) // SAMPLE)]
    low, high = points.min(axis=0), points.max(axis=0)
    ends = np.minimum(points[:, 1] - low[1], high[1] - points[:, 1])
    if high[1] - low[1] < THIN or np.count_nonzero(ends <= MIRRORED) > PLANE * len(points):
        return ()
    upwards = _asymmetry(points, low + high, 1)
    if upwards > MIRRORED or min(_asymmetry(points, low + high, axis) for axis in (0, 2)) < DIFFERENT * MIRRORED:
        return ()
    return ("looks z-up: its two halves mirror each other upwards, as left and right do; try --up z",)


def _asymmetry(points: Floats, twice_middle: Floats, axis: int) -> float:
    """The mean distance of some points (n, 3), mirrored along an axis, from the nearest of all."""
    from scipy.spatial import cKDTree

    mirrored = points[:: -(-len(points) // MIRROR_SAMPLE)].copy()
    mirrored[:, axis] = twice_middle[axis] - mirrored[:, axis]
    return float(cKDTree(points).query(mirrored)[0].mean())
