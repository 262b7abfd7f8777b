"""Straight ways across a surface of triangles, and how it bends along them.

A way goes straight on over an edge if it does so with both faces laid flat (a geodesic; Polthier and Schmies 1998).
"""

import math
from typing import NamedTuple

from ncmodel.geometry.adjacency import Rings
from ncmodel.geometry.normals_areas import Indices, sides_of
from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints

STEPS = 64
"""A way crosses at most so many edges."""

_Vector = tuple[float, float, float]


class Faces(NamedTuple):
    """What is walked on.

    Attributes:
        vertices: (V, 3).
        faces: (F, 3).
        rings: The faces around each vertex.
    """

    vertices: Floats
    faces: Indices
    rings: Rings


@kernel
def walk(
    surface: Faces,
    side: tuple[int, int, int],
    start: _Vector,
    sign: float,
    reach: float,
    least: float,
    most: int,
    bend: Floats,
    place: Floats,
    edge: Ints,
    count: int,
) -> int:
    """Follow the surface straight on from a side of a face, square to it, and write down where it bends.

    Small bends are left out unless they add up. Where the surface ends before the way does, so that nobody knows how it
    would go on, that is written down as a bend of 0.

    Args:
        surface: What is walked on.
        side: The vertices i and j of a side, and the face in which j follows i.
        start: A point on it.
        sign: What distances are multiplied with.
        reach: How far the way goes.
        least: Bends below this are small.
        most: After so many bends it ends.
        bend: Where to write the angles, above 0 if convex.
        place: Where to write their distances.
        edge: Where to write their edges, and the face beyond.
        count: From which place on.

    Returns:
        The place after the last one written.
    """
    i, j, f = side
    vertices, faces, rings = surface.vertices, surface.faces, surface.rings
    along, inwards = _frame(vertices, faces, i, j, f)
    way, at, travelled, small = inwards, start, 0.0, 0.0
    most += count
    for _ in range(STEPS):
        k = int(faces[f, 0]) + int(faces[f, 1]) + int(faces[f, 2]) - i - j
        # The way leaves through the side (j, k) or (k, i).
        a, b = (j, k) if _left_of(vertices, at, way, k, along, inwards) else (k, i)
        length = _distance_to(vertices, at, way, a, b, along, inwards)
        travelled += max(length, 0.0)
        if travelled >= reach:
            return count
        g = neighbour(rings, a, b, f)
        if g < 0 or length < 0.0:
            bend[count], place[count] = 0.0, sign * travelled
            return count + 1
        at = (at[0] + length * way[0], at[1] + length * way[1], at[2] + length * way[2])
        turn = bend_between(surface, a, b, f, g)
        small += turn if abs(turn) < least else 0.0
        if abs(turn) >= least or abs(small) >= least:
            bend[count], place[count] = (turn if abs(turn) >= least else small), sign * travelled
            edge[count, 0], edge[count, 1], edge[count, 2] = a, b, g
            count += 1
            small = 0.0
            if count == most:
                return count
        # The same way on the next face: along the shared side, and off it.
        here, out = _frame(vertices, faces, a, b, f)
        along_side, off_side = _dot(way, here), -_dot(way, out)
        along, inwards = _frame(vertices, faces, b, a, g)
        way = (
            off_side * inwards[0] - along_side * along[0],
            off_side * inwards[1] - along_side * along[1],
            off_side * inwards[2] - along_side * along[2],
        )
        i, j, f = b, a, g
    bend[count], place[count] = 0.0, sign * travelled
    return count + 1


@kernel
def _frame(vertices: Floats, faces: Indices, i: int, j: int, f: int) -> tuple[_Vector, _Vector]:
    """Unit vectors of face f from its corner i to the next one, j, and from that side inwards."""
    k = int(faces[f, 0]) + int(faces[f, 1]) + int(faces[f, 2]) - i - j
    ax, ay, az = vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1], vertices[j, 2] - vertices[i, 2]
    size = max(math.sqrt(ax * ax + ay * ay + az * az), 1e-300)
    ax, ay, az = ax / size, ay / size, az / size
    bx, by, bz = vertices[k, 0] - vertices[i, 0], vertices[k, 1] - vertices[i, 1], vertices[k, 2] - vertices[i, 2]
    share = ax * bx + ay * by + az * bz
    bx, by, bz = bx - share * ax, by - share * ay, bz - share * az
    size = max(math.sqrt(bx * bx + by * by + bz * bz), 1e-300)
    return (ax, ay, az), (bx / size, by / size, bz / size)


@kernel
def _left_of(vertices: Floats, at: _Vector, way: _Vector, k: int, along: _Vector, inwards: _Vector) -> bool:
    """Whether the way passes on that side of vertex k to which `along` points."""
    x, y, z = vertices[k, 0] - at[0], vertices[k, 1] - at[1], vertices[k, 2] - at[2]
    k_along = x * along[0] + y * along[1] + z * along[2]
    k_off = x * inwards[0] + y * inwards[1] + z * inwards[2]
    return bool(_dot(way, along) * k_off > _dot(way, inwards) * k_along)


@kernel
def _distance_to(
    vertices: Floats, at: _Vector, way: _Vector, a: int, b: int, along: _Vector, inwards: _Vector
) -> float:
    """How far it is on the way to the line through a and b; -1 if never."""
    ax, ay, az = vertices[a, 0] - at[0], vertices[a, 1] - at[1], vertices[a, 2] - at[2]
    dx, dy, dz = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
    a0, a1 = ax * along[0] + ay * along[1] + az * along[2], ax * inwards[0] + ay * inwards[1] + az * inwards[2]
    d0, d1 = dx * along[0] + dy * along[1] + dz * along[2], dx * inwards[0] + dy * inwards[1] + dz * inwards[2]
    w0, w1 = _dot(way, along), _dot(way, inwards)
    across: float = w0 * d1 - w1 * d0
    return (a0 * d1 - a1 * d0) / across if across != 0.0 else -1.0


@kernel
def _dot(a: _Vector, b: _Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def bend_between(surface: Faces, a: int, b: int, f: int, g: int) -> float:
    """The angle between face f, which has the side from a to b, and g beyond: above 0 if convex, 0 if degenerate."""
    vertices, faces = surface.vertices, surface.faces
    p, flat_p = sides_of(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
    q, flat_q = sides_of(vertices, faces[g, 0], faces[g, 1], faces[g, 2])
    if flat_p or flat_q:
        return 0.0
    x, y, z = p[10] * q[11] - p[11] * q[10], p[11] * q[9] - p[9] * q[11], p[9] * q[10] - p[10] * q[9]
    ex, ey, ez = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
    sine = math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(sine, p[9] * q[9] + p[10] * q[10] + p[11] * q[11])
    return angle if x * ex + y * ey + z * ez >= 0.0 else -angle


@kernel
def neighbour(rings: Rings, a: int, b: int, f: int) -> int:
    """The one face that has the side from b to a, beside f, which has it from a to b; -1 if none or several have."""
    found = -1
    for n in range(rings.starts[a], rings.starts[a + 1]):
        if rings.around[n, 1] == b:
            if found >= 0:
                return -1
            found = int(rings.face[n])
        elif rings.around[n, 0] == b and int(rings.face[n]) != f:
            return -1
    return found
