"""Building blocks for shapes made in code: level sets of signed distances, lofts, grids, spheres.

Level sets are meshed by marching cubes, then a few rounds of tangential relaxation and Newton steps back onto the
surface, since curvature needs well-shaped triangles whose vertices lie on it.
"""

import math
from collections.abc import Callable

import numpy as np

from ncmodel.types import Floats, Ints

Distance = Callable[[Floats], Floats]
"""Signed distance (negative inside) of (n, 3) points."""

GRID = 64
"""Marching-cubes cells along the longest side: about 6-14 thousand faces a shape."""

RELAXATIONS = 6


# Level sets


def level_set(distance: Distance, low: Floats, high: Floats, grid: int = GRID) -> tuple[Floats, Ints]:
    """Mesh the zero set of a signed distance.

    Args:
        distance: The signed distance, smooth near its zero set.
        low: (3,) lower corner of a box around the shape.
        high: (3,) upper corner.
        grid: Cells along the box's longest side.

    Returns:
        Vertices (V, 3) and outward-facing faces (F, 3).
    """
    from skimage.measure import marching_cubes

    cell = float((high - low).max()) / grid
    counts = np.ceil((high - low) / cell).astype(int) + 1
    axes = [low[a] + cell * np.arange(counts[a]) for a in range(3)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = distance(points.reshape(-1, 3)).reshape(counts)
    vertices, faces, _, _ = marching_cubes(values, 0.0, spacing=(cell, cell, cell))
    relaxed = _relax(distance, vertices.astype(np.float64) + low, faces.astype(np.int64), cell)
    return outward_facing(relaxed, faces.astype(np.int64))


def _relax(distance: Distance, vertices: Floats, faces: Ints, cell: float) -> Floats:
    """Even out the triangles along the surface, then step back onto it."""
    from scipy.sparse import coo_matrix

    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = np.concatenate([edges, edges[:, ::-1]])
    count = len(vertices)
    neighbours = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count)).tocsr()
    neighbours.data[:] = 1.0
    degree = np.asarray(neighbours.sum(axis=1))
    for _ in range(RELAXATIONS):
        gradient = _gradient(distance, vertices, 1e-3 * cell)
        normal = gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), 1e-12)
        shift = neighbours @ vertices / degree - vertices
        vertices = vertices + 0.7 * (shift - (shift * normal).sum(1, keepdims=True) * normal)
        vertices = _onto_surface(distance, vertices, cell)
    return _onto_surface(distance, vertices, cell)


def _onto_surface(distance: Distance, vertices: Floats, cell: float) -> Floats:
    gradient = _gradient(distance, vertices, 1e-3 * cell)
    step = distance(vertices)[:, None] * gradient / np.maximum((gradient**2).sum(1, keepdims=True), 1e-6)
    return np.asarray(vertices - np.clip(step, -0.5 * cell, 0.5 * cell))


def _gradient(distance: Distance, points: Floats, h: float) -> Floats:
    offsets = h * np.eye(3)
    columns = [(distance(points + offset) - distance(points - offset)) / (2 * h) for offset in offsets]
    return np.stack(columns, axis=1)


def smooth_min(a: Floats, b: Floats, radius: float) -> Floats:
    """Union of two signed distances with a fillet of about `radius` (polynomial smooth minimum)."""
    h = np.maximum(radius - np.abs(a - b), 0.0) / radius
    return np.asarray(np.minimum(a, b) - radius * h**3 / 6.0)


def smooth_cut(a: Floats, b: Floats, radius: float) -> Floats:
    """`a` with `b` cut away, the new edge rounded."""
    return -smooth_min(-a, b, radius)


def capsule(points: Floats, a: Floats, b: Floats, radius_a: float, radius_b: float) -> Floats:
    """Signed distance of a tapered capsule from a to b (exact where the radii agree)."""
    along = b - a
    h = np.clip((points - a) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    nearest = a + h[:, None] * along
    return np.asarray(np.linalg.norm(points - nearest, axis=1) - (radius_a + h * (radius_b - radius_a)))


def box(points: Floats, centre: Floats, half: Floats, rounding: float) -> Floats:
    """Signed distance of an axis-aligned box with rounded edges."""
    q = np.abs(points - centre) - (half - rounding)
    outside = np.linalg.norm(np.maximum(q, 0.0), axis=1)
    return np.asarray(outside + np.minimum(q.max(axis=1), 0.0) - rounding)


def cylinder(points: Floats, centre: Floats, axis: int, radius: float, half: float, rounding: float) -> Floats:
    """Signed distance of a cylinder along a coordinate axis, its rims rounded."""
    local = points - centre
    radial = np.linalg.norm(np.delete(local, axis, axis=1), axis=1) - (radius - rounding)
    axial = np.abs(local[:, axis]) - (half - rounding)
    outside = np.hypot(np.maximum(radial, 0.0), np.maximum(axial, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(radial, axial), 0.0) - rounding)


# Parametric surfaces


def loft(profile: Floats, heights: Floats, radius: Floats, twist: float = 0.0) -> tuple[Floats, Ints]:
    """Rings of one star-shaped profile at several heights, closed by flat caps of concentric rings.

    Args:
        profile: (n, 2) radius of the profile at n even angles, and an offset to the angles.
        heights: (m,) increasing heights of the rings.
        radius: (m,) scale of each ring.
        twist: Radians from bottom to top.
    """
    sides = len(profile)
    angle = np.linspace(0.0, 2 * math.pi, sides, endpoint=False) + profile[:, 1]
    turn = twist * (heights - heights[0]) / (heights[-1] - heights[0])
    caps = np.linspace(0.15, 1.0, 8, endpoint=False)
    scale = np.concatenate([caps * radius[0], radius, caps[::-1] * radius[-1]])
    level = np.concatenate([np.full(8, heights[0]), heights, np.full(8, heights[-1])])
    turns = np.concatenate([np.full(8, turn[0]), turn, np.full(8, turn[-1])])
    around = angle[None, :] + turns[:, None]
    reach = scale[:, None] * profile[None, :, 0]
    rings = np.stack([reach * np.cos(around), np.broadcast_to(level[:, None], reach.shape), reach * np.sin(around)], -1)
    body = grid_faces(len(scale), sides, closed=False)
    bottom, top = len(scale) * sides, len(scale) * sides + 1
    here = np.arange(sides)
    there = np.roll(here, -1)
    last = (len(scale) - 1) * sides
    fans = np.concatenate(
        [
            np.stack([np.full(sides, bottom), here, there], axis=1),
            np.stack([np.full(sides, top), last + there, last + here], axis=1),
        ]
    )
    poles = np.array([[0.0, heights[0], 0.0], [0.0, heights[-1], 0.0]])
    return outward_facing(np.concatenate([rings.reshape(-1, 3), poles]), np.concatenate([body, fans]))


def grid_faces(rows: int, columns: int, closed: bool) -> Ints:
    """Triangles of a rows x columns grid that wraps around in columns, and in rows too if `closed`."""
    r = np.arange(rows if closed else rows - 1)[:, None] * columns
    c = np.arange(columns)[None, :]
    above, right = (r + columns) % (rows * columns), (c + 1) % columns
    a, b, d, e = (np.broadcast_to(x, (len(r), columns)).ravel() for x in (r + c, r + right, above + c, above + right))
    return np.concatenate([np.stack([a, d, b], axis=1), np.stack([b, d, e], axis=1)]).astype(np.int64)


def outward_facing(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """The same closed surface, turned inside out if its signed volume is negative."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    inside_out = float(np.einsum("ij,ij->", a, np.cross(b, c))) < 0
    return vertices, np.ascontiguousarray(faces[:, ::-1]) if inside_out else faces


def icosphere(subdivisions: int) -> tuple[Floats, Ints]:
    """A unit sphere of 20 * 4^subdivisions near-equal triangles."""
    from trimesh.creation import icosphere as make

    sphere = make(subdivisions=subdivisions, radius=1.0)
    return np.asarray(sphere.vertices, dtype=np.float64), np.asarray(sphere.faces, dtype=np.int64)
