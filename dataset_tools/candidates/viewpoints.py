"""Where a shape is seen from: cameras on a ring around it, at random azimuths that only its name decides."""

import hashlib

import numpy as np

from ncmodel.camera import DEFAULT_DISTANCE, Camera
from ncmodel.types import Floats, Ints, Mesh

ELEVATION = 30.0
"""Degrees above the ground plane."""


def choose_azimuths(name: str, count: int, seed: int = 0) -> list[float]:
    """Azimuths of a shape's views, degrees.

    Args:
        name: The shape's name, which decides them together with `seed`.
        count: How many; asking for more leaves the first ones as they are.
        seed: Another seed, other azimuths.
    """
    return [float(azimuth) for azimuth in _generator(name, seed).uniform(0.0, 360.0, count)]


def camera_at(mesh: Mesh, azimuth: float, size: tuple[int, int]) -> Camera:
    """The upright camera at an azimuth (degrees), aimed at the surface's centroid, the shape filling the frame."""
    x, y, z = surface_centroid(mesh.vertices, mesh.faces)
    return Camera.orbit(mesh.vertices, azimuth, ELEVATION, DEFAULT_DISTANCE, size, (float(x), float(y), float(z)))


def surface_centroid(vertices: Floats, faces: Ints) -> Floats:
    """(3,) centroid of the surface (area-weighted): where vertices are dense doesn't matter."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.asarray(np.average((a + b + c) / 3, axis=0, weights=area))


def _generator(name: str, seed: int) -> np.random.Generator:
    digest = hashlib.sha256(name.encode()).digest()
    return np.random.default_rng([seed, *np.frombuffer(digest, dtype="<u4").tolist()])
