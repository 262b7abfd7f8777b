"""How a finished shape comes: as it was modelled, coarse, noisy, or as a scan with holes."""

import numpy as np

from dataset_tools.modelling.fields import ripples
from dataset_tools.modelling.sculpting import Surface, decimated
from ncmodel.types import Floats, Ints

FINISHES = {"clean": 0.66, "coarse": 0.14, "noisy": 0.08, "scan": 0.12}
"""Name -> share of the shapes."""

FEWEST, MOST = 5_000, 100_000
"""Faces of a shape."""


def finished(surface: Surface, rng: np.random.Generator) -> Surface:
    """A surface with a finish drawn by chance; it has at least about `FEWEST` faces and at most `MOST`."""
    kind = str(rng.choice(list(FINISHES), p=list(FINISHES.values())))
    surface = _compact(surface)
    while len(surface[1]) < FEWEST:
        surface = subdivided(surface)
    count = len(surface[1])
    if kind == "coarse":
        surface = decimated(surface, max(FEWEST, round(count * rng.uniform(0.2, 0.5))))
    elif count > MOST:
        surface = decimated(surface, MOST)
    if kind == "noisy":
        surface = _bumpy(surface, rng, rng.uniform(0.0004, 0.0012), rng.uniform(0.0, 0.004))
    if kind == "scan":
        surface = _with_holes(_bumpy(surface, rng, rng.uniform(0.0002, 0.0008), rng.uniform(0.002, 0.006)), rng)
    return _compact(surface)


def subdivided(surface: Surface) -> Surface:
    """Each triangle in four."""
    from trimesh.remesh import subdivide

    vertices, faces = subdivide(*surface)
    return np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64)


def _bumpy(surface: Surface, rng: np.random.Generator, grain: float, bumps: float) -> Surface:
    """Vertices off the surface along its normals, each by itself (`grain`) and in waves (`bumps`), of the size."""
    vertices, faces = surface
    size = float(np.ptp(vertices, axis=0).max())
    wave = ripples(rng, size * rng.uniform(0.03, 0.1), 24)
    height = size * (grain * rng.normal(size=len(vertices)) + bumps * 0.3 * wave(vertices))
    return vertices + height[:, None] * _normals(vertices, faces), faces


def _normals(vertices: Floats, faces: Ints) -> Floats:
    corners = vertices[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(total, faces[:, k], across)
    return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300))


def _with_holes(surface: Surface, rng: np.random.Generator) -> Surface:
    """A few ragged holes, and the bottom open, as scanners leave them where they don't see."""
    vertices, faces = surface
    size = float(np.ptp(vertices, axis=0).max())
    middle = vertices[faces].mean(axis=1)
    ragged = ripples(rng, 0.05 * size, 10)(middle)
    keep = np.ones(len(faces), dtype=bool)
    for _ in range(int(rng.integers(1, 6))):
        centre = middle[int(rng.integers(len(middle)))]
        reach = size * rng.uniform(0.01, 0.045) * (1 + 0.25 * ragged)
        keep &= np.linalg.norm(middle - centre, axis=1) > reach
    if rng.random() < 0.5:
        keep &= middle[:, 1] > vertices[:, 1].min() + size * (0.012 + 0.002 * ragged)
    return vertices, faces[keep]


def _compact(surface: Surface) -> Surface:
    """A surface without unused vertices and faces without area."""
    vertices, faces = surface
    corners = vertices[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    faces = faces[area > 1e-12 * float(np.ptp(vertices, axis=0).max()) ** 2]
    used, index = np.unique(faces, return_inverse=True)
    return vertices[used], index.reshape(-1, 3)
