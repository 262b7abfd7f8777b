"""Flats: wide parts of a plane that a mesh divides into several faces.

At the vertices around a flat, curvature and normals are means over what meets there: the flat and, say, the fillet at
its rim. Where nothing but long slivers spans the flat, interpolation carries those values all across it, and lines of
curvature follow on a surface that has none.
"""

import math

import numpy as np

from ncmodel.geometry.adjacency import Rings
from ncmodel.geometry.normals_areas import Indices, sides_of
from ncmodel.jit import kernel
from ncmodel.mesh.union_find import root
from ncmodel.types import Floats, Ints, Mask

FLAT_SINE = 2e-4
"""Sine of the bend between two faces below which they lie in one plane: what rounding to single precision does to
narrow faces."""
FACET = 2
"""Planes of no more faces are facets of a curved surface: quads are two."""
WIDER = 3.0
"""So are planes less than this many times as wide as those beside them: the bands of a fillet are alike."""


def flat_faces(vertices: Floats, faces: Indices, rings: Rings) -> Mask:
    """(F,) True for the faces on flats."""
    twin = _twins(rings)
    plane = _planes(vertices, faces, rings, twin)
    area, around = _extents(vertices, faces, rings, twin, plane)
    width = area / np.maximum(around, 1e-300)
    shared, beside = _surroundings(vertices, rings, twin, plane, width)
    flat = (np.bincount(plane, minlength=len(faces)) > FACET) & (width * shared >= WIDER * beside)
    return np.asarray(flat[plane])


@kernel
def _twins(rings: Rings) -> Ints:
    """(3 F,) the corner whose face has the side from a corner to the next one in the opposite direction, or -1."""
    starts, around, _ = rings
    twin = np.full(len(around), -1)
    arriving = np.full(len(starts), -1)
    for v in range(len(starts) - 1):
        for n in range(starts[v], starts[v + 1]):
            arriving[around[n, 1]] = n
        for n in range(starts[v], starts[v + 1]):
            if arriving[around[n, 0]] >= starts[v]:
                twin[n] = arriving[around[n, 0]]
    return twin


@kernel
def _planes(vertices: Floats, faces: Indices, rings: Rings, twin: Ints) -> Ints:
    """(F,) the lowest index of the faces that lie in one plane with a face, joined by their sides."""
    starts, around, face = rings
    plane = np.arange(len(faces))
    for v in range(len(vertices)):
        for n in range(starts[v], starts[v + 1]):
            if twin[n] >= 0 and around[n, 0] > v and _in_plane(vertices, faces, face[n], face[twin[n]]):
                a, b = root(plane, face[n]), root(plane, face[twin[n]])
                plane[max(a, b)] = min(a, b)
    for f in range(len(faces)):
        plane[f] = root(plane, f)
    return plane


@kernel
def _extents(vertices: Floats, faces: Indices, rings: Rings, twin: Ints, plane: Ints) -> tuple[Floats, Floats]:
    """Twice the area of each plane (F,), by its number, and the length of the border around it (F,)."""
    starts, around, face = rings
    area, border = np.zeros(len(faces)), np.zeros(len(faces))
    for f in range(len(faces)):
        sides, _ = sides_of(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
        area[plane[f]] += math.sqrt(sides[9] ** 2 + sides[10] ** 2 + sides[11] ** 2)
    for v in range(len(vertices)):
        for n in range(starts[v], starts[v + 1]):
            if twin[n] < 0 or plane[face[twin[n]]] != plane[face[n]]:
                border[plane[face[n]]] += _length(vertices, v, around[n, 0])
    return area, border


@kernel
def _surroundings(vertices: Floats, rings: Rings, twin: Ints, plane: Ints, width: Floats) -> tuple[Floats, Floats]:
    """Length of each plane's border (F,) that it shares with others, and its integral of their widths (F,)."""
    starts, around, face = rings
    shared, beside = np.zeros(len(plane)), np.zeros(len(plane))
    for v in range(len(vertices)):
        for n in range(starts[v], starts[v + 1]):
            if twin[n] >= 0 and plane[face[twin[n]]] != plane[face[n]]:
                length = _length(vertices, v, around[n, 0])
                shared[plane[face[n]]] += length
                beside[plane[face[n]]] += length * width[plane[face[twin[n]]]]
    return shared, beside


@kernel
def _length(vertices: Floats, i: int, j: int) -> float:
    """Of the side between two vertices."""
    x, y, z = vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1], vertices[j, 2] - vertices[i, 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel
def _in_plane(vertices: Floats, faces: Indices, f: int, g: int) -> bool:
    """Whether the normals of two faces differ by rounding alone; degenerate ones have none."""
    a, flat_a = sides_of(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
    b, flat_b = sides_of(vertices, faces[g, 0], faces[g, 1], faces[g, 2])
    if flat_a or flat_b:
        return False
    ax, ay, az, bx, by, bz = a[9], a[10], a[11], b[9], b[10], b[11]
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    limit = FLAT_SINE**2 * (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz)
    return bool(x * x + y * y + z * z < limit and ax * bx + ay * by + az * bz > 0.0)
