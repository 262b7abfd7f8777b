"""Meshes and eyes at the edges of what the definitions allow, and what each must come to."""

from collections.abc import Callable

import numpy as np

from ncmodel.types import Floats, Ints
from tests.helpers import analytic, dirty

Builder = Callable[[], tuple[Floats, Ints]]


def slivers() -> tuple[Floats, Ints]:
    """A torus squeezed a millionfold around the tube: faces of aspect 1e6."""
    vertices, faces = analytic.torus(24, 12)
    return vertices * np.array([1.0, 1e-6, 1.0]), faces


def needles() -> tuple[Floats, Ints]:
    """A cylinder of 2000 sides and one row: every face a million times as long as wide."""
    vertices, faces = analytic.cylinder(2, 2000, 1e-3, 1.0)
    return vertices, faces


def with_zero_area() -> tuple[Floats, Ints]:
    """Faces that are a point, a doubled corner, and three corners on a line."""
    vertices, faces = analytic.torus(18, 10)
    middle = vertices[:2].mean(axis=0)
    return np.concatenate([vertices, [middle]]), np.concatenate([faces, [[0, 0, 0], [1, 1, 2], [0, 180, 1]]])


def coincident() -> tuple[Floats, Ints]:
    """A soup: no face shares a vertex with another, though all positions meet."""
    vertices, faces = analytic.icosphere(2)
    return vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)


def nearly_coincident() -> tuple[Floats, Ints]:
    """A sphere with a collapsed edge: two vertices 1e-17 apart."""
    vertices, faces = analytic.icosphere(2)
    vertices[faces[0, 1]] = vertices[faces[0, 0]] * (1 + 1e-16)
    return vertices, faces


def unreferenced() -> tuple[Floats, Ints]:
    vertices, faces = analytic.torus(18, 10)
    return np.concatenate([vertices[:7], np.zeros((3, 3)), vertices[7:]]), np.where(faces < 7, faces, faces + 3)


def three_faces_at_an_edge() -> tuple[Floats, Ints]:
    vertices = np.array([[0, 0, 0], [0, 1, 0], [1, 0.5, 0], [-0.5, 0.5, 0.8], [-0.5, 0.5, -0.8]])
    return vertices, np.array([[0, 2, 1], [0, 3, 1], [0, 4, 1]])


def inside_out() -> tuple[Floats, Ints]:
    return dirty.inside_out(analytic.torus(18, 10))


def both_sides() -> tuple[Floats, Ints]:
    """Every face twice, back to back on the same vertices: all normals cancel."""
    vertices, faces = analytic.icosphere(2)
    return vertices, np.concatenate([faces, faces[:, ::-1]])


def touching_shells() -> tuple[Floats, Ints]:
    """Two cubes that share a side."""
    vertices, faces = analytic.cube()
    return np.concatenate([vertices, vertices + [1.0, 0, 0]]), np.concatenate([faces, faces + 8])


def single_triangle() -> tuple[Floats, Ints]:
    return np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])


def spiky() -> tuple[Floats, Ints]:
    """A fan of 3000 faces round one vertex, lifted to a spike."""
    phi = np.linspace(0, 2 * np.pi, 3000, endpoint=False)
    rim = np.stack([np.cos(phi), 0 * phi, np.sin(phi)], axis=1)
    n = np.arange(3000)
    return np.concatenate([rim, [[0, 1, 0]]]), np.stack([n, np.full(3000, 3000), (n + 1) % 3000], axis=1)


def book(pages: int) -> tuple[Floats, Ints]:
    """Two faces for each page, all at one edge, opened to half a turn."""
    angle, n = np.linspace(0, np.pi, pages), np.arange(pages)
    outer = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
    below, above = n + 2, n + 2 + pages
    faces = [np.stack([0 * n, below, above], axis=1), np.stack([0 * n, above, 0 * n + 1], axis=1)]
    return np.concatenate([[[0, 0, 0], [0, 1, 0]], outer, outer + [0, 1, 0]]), np.concatenate(faces)


MESHES: dict[str, Builder] = {
    "tiny": lambda: (analytic.torus(18, 10)[0] * 1e-12, analytic.torus(18, 10)[1]),
    "huge": lambda: (analytic.torus(18, 10)[0] * 1e12, analytic.torus(18, 10)[1]),
    "far away": lambda: (analytic.torus(18, 10)[0] + 1e7, analytic.torus(18, 10)[1]),
    "slivers": slivers,
    "needles": needles,
    "zero area": with_zero_area,
    "coincident": coincident,
    "nearly coincident": nearly_coincident,
    "unreferenced": unreferenced,
    "three faces at an edge": three_faces_at_an_edge,
    "inside out": inside_out,
    "both sides": both_sides,
    "touching shells": touching_shells,
    "single triangle": single_triangle,
    "plane": lambda: analytic.plane(6),
    "sphere": lambda: analytic.icosphere(3),
    "cube": analytic.cube,
    "spiky": spiky,
}
