"""The length that makes thresholds dimensionless (docs/geometry.md 5)."""

import math
from itertools import combinations

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats

SAMPLES = 500
CURVATURE_SHARE = 0.01
RADIUS_SHARE = 0.05
"""fs = min(CURVATURE_SHARE / kappa10, RADIUS_SHARE * R), as rtsc has it."""


def sampled_feature_size(curvatures: Floats, radius: float) -> float:
    """The feature size as rtsc has it, from the curvature of up to 500 vertices that a fixed random sequence picks.

    Args:
        curvatures: (V, 2) principal curvatures.
        radius: Of the smallest sphere around the shape.
    """
    count = min(len(curvatures), SAMPLES)
    state, picked = 0, []
    for _ in range(count):
        state = (1664525 * state + 1013904223) % 2**32
        picked.append(state % len(curvatures))
    return _feature_size(float(np.sort(np.abs(curvatures[picked]), axis=None)[2 * count // 10]), radius)


def feature_size_of_all(curvatures: Floats, radius: float) -> float:
    """What `sampled_feature_size` estimates: the same from the curvature of all vertices, whatever their order.

    Args:
        curvatures: (V, 2) principal curvatures; without any, the shape counts as flat.
        radius: Of the smallest sphere around the shape.
    """
    sizes = np.abs(curvatures).ravel() if len(curvatures) else np.zeros(1)
    rank = 2 * len(curvatures) // 10
    return _feature_size(float(np.partition(sizes, rank)[rank]), radius)


def enclosing_radius(points: Floats) -> float:
    """Radius of the smallest sphere around points (n, 3).

    The sphere around a few points grows: the farthest point outside joins them, and those that the new smallest sphere
    doesn't touch leave. The radius rises with each step, so no set of points comes twice.
    """
    support = points[:1]
    centre, radius = points[0], 0.0
    while True:
        farthest, distance = _farthest(points, centre)
        if distance <= radius * (1 + 1e-12):
            return radius
        support, centre, grown = _smallest_around(np.concatenate([support, points[farthest : farthest + 1]]))
        if grown <= radius:  # only rounding is left
            return distance
        radius = grown


@kernel
def _farthest(points: Floats, centre: Floats) -> tuple[int, float]:
    """The point (n, 3) farthest from `centre`, and its distance."""
    farthest, largest = 0, 0.0
    for n in range(len(points)):
        x, y, z = points[n, 0] - centre[0], points[n, 1] - centre[1], points[n, 2] - centre[2]
        square = x * x + y * y + z * z
        if square > largest:
            farthest, largest = n, square
    return farthest, math.sqrt(largest)


def _feature_size(kappa: float, radius: float) -> float:
    cap = RADIUS_SHARE * radius
    return min(CURVATURE_SHARE / kappa, cap) if kappa > 0 else cap


def _smallest_around(points: Floats) -> tuple[Floats, Floats, float]:
    """Of at most five points, those on the smallest sphere around all, its centre and its radius."""
    best: tuple[Floats, Floats, float] | None = None
    for size in range(2, min(len(points), 4) + 1):
        for chosen in combinations(range(len(points)), size):
            support = points[list(chosen)]
            centre = _circumcentre(support)
            radius = float(np.linalg.norm(support[0] - centre))
            reach = float(np.linalg.norm(points - centre, axis=1).max())
            if reach <= radius * (1 + 1e-10) and (best is None or radius < best[2]):
                best = support, centre, radius
    if best is None:  # nearly cospherical or collinear points: rounding spoils every sphere
        centre = points.mean(axis=0)
        best = points[:4], centre, float(np.linalg.norm(points - centre, axis=1).max())
    return best


def _circumcentre(points: Floats) -> Floats:
    """The point in the affine hull of two to four points that is as far from one as from the others."""
    edges = points[1:] - points[0]
    offset = np.linalg.lstsq(2 * edges @ edges.T, (edges**2).sum(axis=1), rcond=None)[0] @ edges
    return np.asarray(points[0] + offset)
