"""Broken meshes, each with one fault, and what a sound mesh is."""

import numpy as np

from dataset_tools.cleaning.half_edges import half_edges
from ncmodel.types import Floats, Ints
from tests.helpers import analytic

Geometry = tuple[Floats, Ints]


def box(low: tuple[float, float, float] = (0, 0, 0), high: tuple[float, float, float] = (1, 1, 1)) -> Geometry:
    """A closed box of 12 triangles facing outwards."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))])
    return np.asarray(low) + corners * np.subtract(high, low), faces


def joined(*parts: Geometry) -> Geometry:
    """Several meshes as one."""
    offsets = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = [part[1] + offset for part, offset in zip(parts, offsets, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)


def inside_out(part: Geometry) -> Geometry:
    """The same mesh, every face turned over."""
    return part[0], part[1][:, ::-1].copy()


def flipped_at_random(part: Geometry, seed: int = 0) -> Geometry:
    """The same mesh, half of its faces turned over."""
    vertices, faces = part
    turn = np.random.default_rng(seed).random(len(faces)) < 0.5
    return vertices, np.where(turn[:, None], faces[:, ::-1], faces)


def loose(part: Geometry, noise: float = 0.0, seed: int = 0) -> Geometry:
    """The same triangles, none sharing a vertex, each corner moved a little."""
    vertices, faces = part
    corners = vertices[faces].reshape(-1, 3)
    corners = corners + noise * np.random.default_rng(seed).uniform(-0.5, 0.5, corners.shape)
    return corners, np.arange(len(corners)).reshape(-1, 3)


def with_seam(cells: int = 8, other: int = 5, gap: float = 0.0) -> Geometry:
    """Two halves of a flat square that meet along x = 0, cut into different numbers of cells: T-junctions all along."""
    left = strip(-1.0, 0.0, cells)
    right = strip(gap, 1.0, other)
    return joined(left, right)


def strip(x0: float, x1: float, cells: int) -> Geometry:
    """A flat rectangle facing +z, one cell wide and `cells` high."""
    y = np.linspace(0, 1, cells + 1)
    vertices = np.array([[x, v, 0.0] for v in y for x in (x0, x1)])
    a = 2 * np.arange(cells)
    return vertices, np.concatenate([np.stack([a, a + 1, a + 3], 1), np.stack([a, a + 3, a + 2], 1)])


def moebius(segments: int = 40, across: int = 4) -> Geometry:
    """A one-sided band."""
    u = np.linspace(0, 2 * np.pi, segments, endpoint=False)[:, None]
    w = np.linspace(-0.3, 0.3, across + 1)[None, :]
    radius = 1 + w * np.cos(u / 2)
    points = np.stack([radius * np.cos(u), w * np.sin(u / 2), radius * np.sin(u)], axis=-1)
    wide = across + 1
    index = np.arange(segments * wide).reshape(segments, wide)
    index = np.concatenate([index, index[:1, ::-1]])
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return points.reshape(-1, 3), faces


def sphere(radius: float = 1.0, centre: tuple[float, float, float] = (0, 0, 0), fineness: int = 2) -> Geometry:
    """A closed sphere facing outwards."""
    vertices, faces = analytic.icosphere(fineness, radius)
    return vertices + np.asarray(centre), faces


def hemisphere() -> Geometry:
    """The upper half of a sphere, open below, facing outwards."""
    vertices, faces = sphere(fineness=3)
    return vertices, faces[vertices[faces][:, :, 1].mean(axis=1) > 0]


def signed_volume(vertices: Floats, faces: Ints) -> float:
    """Positive for a closed mesh that faces outwards."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("nd,nd->", a, np.cross(b, c))) / 6


def is_surface(faces: Ints) -> bool:
    """At most two faces at every edge, wound alike."""
    sides = half_edges(faces)
    directed = np.stack([sides.start, sides.end], axis=1)
    return int(sides.count.max()) <= 2 and len(np.unique(directed, axis=0)) == len(directed)


def is_closed(faces: Ints) -> bool:
    """Exactly two faces at every edge, wound alike."""
    return is_surface(faces) and bool((half_edges(faces).count == 2).all())


def moved(part: Geometry, by: tuple[float, float, float] = (0.0, 0.0, 0.0), scale: float = 1.0) -> Geometry:
    """The same mesh, scaled about the origin and then moved."""
    return part[0] * scale + np.array(by), part[1]


def face_normals(vertices: Floats, faces: Ints) -> Floats:
    """(F, 3) normals of faces, as long as twice their areas."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return np.asarray(np.cross(b - a, c - a))
