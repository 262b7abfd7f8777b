"""Which sides of faces are seen from outside: rays from sample points to all directions, those that escape count."""

import numpy as np

from ncmodel.geometry.raycast import RayScene
from ncmodel.types import Floats, Ints, Mesh

DIRECTIONS = 64
"""External viewpoints, infinitely far away, spread evenly over the sphere."""

MAX_RAYS = 4_000_000
"""Meshes too fine for that many rays are seen from fewer directions, at least `MIN_DIRECTIONS`."""

MIN_DIRECTIONS = 16

EXTRA_SAMPLES = 20_000
"""Samples spread by area besides one a face, so that large faces seen through a gap are not taken for hidden."""

CLEARANCE = 1e-5
"""Rays start this far from the surface, in units of the mesh's radius, so as not to meet the face they start from."""


def exposure(vertices: Floats, faces: Ints) -> Floats:
    """How much of the outside each side of each face sees.

    Args:
        vertices: (V, 3).
        faces: (F, 3).

    Returns:
        (F, 2) for the front and the back: the cosine-weighted share of its directions that are free, 0 hidden .. 1 all
        of the half space.
    """
    scene = RayScene(Mesh(vertices, faces))
    point, face = _samples(vertices, faces)
    normal = _normals(vertices, faces)[face]
    count = int(np.clip(MAX_RAYS // len(face), MIN_DIRECTIONS, DIRECTIONS))
    free = np.zeros((len(faces), 2))
    total = np.zeros((len(faces), 2))
    for direction in sphere_directions(count):
        cosine = normal @ direction
        start = point + CLEARANCE * scene.radius * direction
        escapes = scene.first_hit(start, np.broadcast_to(direction, start.shape))[1] < 0
        for side, weight in enumerate((np.maximum(cosine, 0.0), np.maximum(-cosine, 0.0))):
            free[:, side] += np.bincount(face, weight * escapes, minlength=len(faces))
            total[:, side] += np.bincount(face, weight, minlength=len(faces))
    return np.divide(free, total, out=np.zeros_like(free), where=total > 0)


def sphere_directions(count: int) -> Floats:
    """(count, 3) unit vectors spread evenly over the sphere (a Fibonacci lattice), none along an axis."""
    i = np.arange(count) + 0.5
    height = 1 - 2 * i / count
    angle = np.pi * (1 + np.sqrt(5)) * i
    radius = np.sqrt(1 - height * height)
    return np.stack([radius * np.cos(angle), height, radius * np.sin(angle)], axis=1)


def _normals(vertices: Floats, faces: Ints) -> Floats:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.asarray(np.divide(normal, length, out=np.zeros_like(normal), where=length > 0))


def _samples(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Points on the surface and the faces they lie on: every centroid, and `EXTRA_SAMPLES` spread by area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    share = np.cumsum(area) / max(area.sum(), np.finfo(float).tiny)
    steps = np.arange(EXTRA_SAMPLES)
    extra = np.minimum(np.searchsorted(share, (steps + 0.5) / EXTRA_SAMPLES), len(faces) - 1)
    # Additive recurrence with the plastic number: evenly spread pairs in the unit square, folded into the triangle.
    u, v = (steps * 0.7548776662466927) % 1.0, (steps * 0.5698402909980532) % 1.0
    fold = u + v > 1.0
    u, v = np.where(fold, 1 - u, u)[:, None], np.where(fold, 1 - v, v)[:, None]
    spread = a[extra] + u * (b[extra] - a[extra]) + v * (c[extra] - a[extra])
    return np.concatenate([(a + b + c) / 3, spread]), np.concatenate([np.arange(len(faces)), extra])
