"""Meshes of surfaces whose curvature is known, at any tessellation.

Builders return (vertices (V, 3), faces (F, 3)), counter-clockwise from outside, unscaled: wrap them in
`types.Mesh` to keep their size, or in `make_mesh` to normalise them.
"""

from collections.abc import Callable

import numpy as np

from ncmodel.types import Floats, Ints

Surface = tuple[Floats, Ints]


def grid_faces(rows: int, columns: int, wrap_rows: bool = False, wrap_columns: bool = False) -> Ints:
    """Two triangles a cell over a rows x columns grid of vertices, oriented by (row axis) x (column axis)."""
    r = np.arange(rows if wrap_rows else rows - 1)
    c = np.arange(columns if wrap_columns else columns - 1)
    i, j = (index.ravel() for index in np.meshgrid(r, c, indexing="ij"))
    a, b = i * columns + j, ((i + 1) % rows) * columns + j
    d, e = i * columns + (j + 1) % columns, ((i + 1) % rows) * columns + (j + 1) % columns
    return np.stack([np.stack([a, b, e], 1), np.stack([a, e, d], 1)], axis=1).reshape(-1, 3)


def icosphere(subdivisions: int = 3, radius: float = 1.0) -> Surface:
    """A sphere of 20 * 4**subdivisions nearly equal triangles: k1 = k2 = 1 / radius."""
    g = (1 + 5**0.5) / 2
    vertices = np.array(
        [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g]]
        + [[0, -1, -g], [0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]]
    )
    triangles = "0 11 5 0 5 1 0 1 7 0 7 10 0 10 11 1 5 9 5 11 4 11 10 2 10 7 6 7 1 8"
    triangles += " 3 9 4 3 4 2 3 2 6 3 6 8 3 8 9 4 9 5 2 4 11 6 2 10 8 6 7 9 8 1"
    faces = np.array(triangles.split(), dtype=np.int64).reshape(-1, 3)
    for _ in range(subdivisions):
        vertices, faces = _subdivided(vertices, faces)
    return radius * vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces


def sphere(rings: int = 24, segments: int = 48, radius: float = 1.0) -> Surface:
    """A sphere in latitude and longitude, with slivers at its poles."""
    theta = np.linspace(0, np.pi, rings + 1)[1:-1, None]
    phi = np.linspace(0, 2 * np.pi, segments, endpoint=False)[None, :]
    ones = np.ones_like(phi)
    middle = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta) * ones, np.sin(theta) * np.cos(phi)], axis=-1)
    vertices = np.concatenate([middle.reshape(-1, 3), [[0, 1, 0], [0, -1, 0]]])
    top, bottom = len(vertices) - 2, len(vertices) - 1
    j = np.arange(segments)
    k = (j + 1) % segments
    last = (rings - 2) * segments
    caps = [np.stack([np.full(segments, top), j, k], 1), np.stack([last + k, last + j, np.full(segments, bottom)], 1)]
    return radius * vertices, np.concatenate([grid_faces(rings - 1, segments, wrap_columns=True), *caps])


def ellipsoid(subdivisions: int = 4, axes: tuple[float, float, float] = (1.0, 0.7, 0.5)) -> Surface:
    """x^2/a^2 + y^2/b^2 + z^2/c^2 = 1 from an icosphere; see `ellipsoid_curvature`."""
    vertices, faces = icosphere(subdivisions)
    return vertices * np.array(axes), faces


def ellipsoid_curvature(points: Floats, axes: tuple[float, float, float] = (1.0, 0.7, 0.5)) -> tuple[Floats, Floats]:
    """(K, H) Gaussian and mean curvature (convex positive) of the ellipsoid at points on it."""
    squares = np.square(axes)
    s = (points**2 / squares**2).sum(axis=1)
    product = squares.prod()
    gauss = 1 / (product * s**2)
    mean = (squares.sum() - (points**2).sum(axis=1)) / (2 * product * s**1.5)
    return gauss, mean


def torus(rings: int = 64, sides: int = 32, major: float = 0.355, minor: float = 0.145, twist: float = 0.0) -> Surface:
    """A torus about the y axis; `twist` shears the grid by a share of a cell per ring (rings * twist / sides whole)."""
    u, v = torus_angles(rings, sides, twist)
    tube = major + minor * np.cos(v)
    vertices = np.stack([tube * np.sin(u), minor * np.sin(v), tube * np.cos(u)], axis=-1)
    return vertices.reshape(-1, 3), grid_faces(rings, sides, wrap_rows=True, wrap_columns=True)


def torus_angles(rings: int = 64, sides: int = 32, twist: float = 0.0) -> tuple[Floats, Floats]:
    """(rings, sides) angle around the axis and angle around the tube of the torus's vertices."""
    i, j = np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij")
    return 2 * np.pi * i / rings, 2 * np.pi * (j + twist * i) / sides


def cylinder(rows: int = 24, sides: int = 48, radius: float = 0.3, height: float = 1.0) -> Surface:
    """An open tube along y: curvatures 1 / radius and 0."""
    y, phi = np.meshgrid(
        np.linspace(height / 2, -height / 2, rows), np.linspace(0, 2 * np.pi, sides, endpoint=False), indexing="ij"
    )
    vertices = np.stack([radius * np.sin(phi), y, radius * np.cos(phi)], axis=-1)
    return vertices.reshape(-1, 3), grid_faces(rows, sides, wrap_columns=True)


def plane(cells: int = 8, size: float = 1.0) -> Surface:
    """A flat square facing +z."""
    return height_field(lambda x, y: 0 * x, cells, size)


def monkey_saddle(cells: int = 32, size: float = 1.0, strength: float = 1.0) -> Surface:
    """z = strength (x^3 - 3 x y^2), facing +z: flat at the origin, derivative of curvature known there."""
    return height_field(lambda x, y: strength * (x**3 - 3 * x * y**2), cells, size)


def height_field(height: Callable[[Floats, Floats], Floats], cells: int = 32, size: float = 1.0) -> Surface:
    """z = height(x, y) over a square of side `size` with (cells + 1)^2 vertices, facing +z."""
    axis = size * (np.arange(cells + 1) / cells - 0.5)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    vertices = np.stack([x, y, height(x, y)], axis=-1)
    return vertices.reshape(-1, 3), grid_faces(cells + 1, cells + 1)


def cube(size: float = 1.0) -> Surface:
    """A box with 8 vertices and 12 faces."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)], dtype=np.int64)
    return corners * size / 2, faces


def _subdivided(vertices: Floats, faces: Ints) -> Surface:
    """Each triangle into four, through the middles of its edges."""
    edges = np.sort(faces[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), axis=1)
    unique, index = np.unique(edges, axis=0, return_inverse=True)
    middles = len(vertices) + index.reshape(-1, 3)
    a, b, c = faces.T
    m0, m1, m2 = middles.T
    split = [[a, m2, m1], [b, m0, m2], [c, m1, m0], [m0, m1, m2]]
    children = np.stack([np.stack(triangle, axis=1) for triangle in split], axis=1).reshape(-1, 3)
    return np.concatenate([vertices, vertices[unique].mean(axis=1)]), children
