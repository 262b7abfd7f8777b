"""Support along hard edges: narrow strips that let a flat face be flat up to its edge.

A vertex on a hard edge has a normal between those of the faces that meet there. Over a large triangle that normal
fades into the flat normal all the way across, and zero sets (contours among them) wander over a face that should have
none. With vertices a small step away from the edge, as modellers put them, the turn happens within that step: an edge
bends like a narrow bevel, and everything else is as flat as it was. No point of the surface moves.
"""

import numpy as np
from numba import njit

from dataset_tools.cleaning.half_edges import HalfEdges, half_edges, patches_of, plain_pairs
from ncmodel.types import Floats, Ints, Mask

HARD_ANGLE = 35.0
"""Degrees between the normals of adjacent faces above which their edge is hard."""

SMOOTH_SHARE = 0.2
"""A face goes on smoothly from a hard edge when one of its other edges bends by less than this share of its bend."""

FLAT_ANGLE = 0.1
"""Degrees below which an edge lies inside a flat piece."""

FLAT_SHARE = 0.15
"""Of the edge length. Measured: 0.16 to 0.77 on models of machines, furniture and vehicles, below 0.15 on most of
animals, people and bones (above it only where hardly an edge is hard)."""

ROOM = 4.0
"""Edges shorter than this many steps get no new vertex, corners of faces narrower than half of it none inside."""


def support_hard_edges(vertices: Floats, faces: Ints, step: float) -> tuple[Floats, Ints]:
    """Put vertices a step away from hard edges.

    Args:
        vertices: (V, 3).
        faces: (F, 3) a surface: at most two faces at an edge.
        step: How far from a hard edge, along the other edges.

    Returns:
        The vertices, new ones last, and the faces: those away from hard edges in their old order, then the parts of
        those that were divided.
    """
    sides = half_edges(faces)
    hard = _hard_edges(vertices, faces, sides)
    if not hard.any():
        return vertices, faces
    on_hard = np.zeros(len(vertices), dtype=bool)
    at_hard = hard[sides.edge]
    on_hard[sides.start[at_hard]] = on_hard[sides.end[at_hard]] = True

    ends = np.empty((len(sides.count), 2), dtype=np.int64)
    ends[sides.edge] = np.sort(np.stack([sides.start, sides.end], axis=1), axis=1)
    points, number = _step_along(vertices, ends, on_hard[ends] & ~hard[:, None], step)
    edge_of = np.empty(faces.shape, dtype=np.int64)
    edge_of[sides.face, sides.corner] = sides.edge
    touched: Mask = np.asarray(on_hard[faces].any(axis=1))
    inside, parts, divided = _divide(points, faces, touched, edge_of, hard, ends, number, step)
    return np.concatenate([points, inside]), np.concatenate([faces[~divided], parts])


def _step_along(vertices: Floats, ends: Ints, wanted: Mask, step: float) -> tuple[Floats, Ints]:
    """New vertices on edges, a step from either end where `wanted` and where there is room.

    Returns:
        All vertices, and the (E, 2) number of the new one near each end of each edge, -1 for none.
    """
    along = vertices[ends[:, 1]] - vertices[ends[:, 0]]
    length = np.linalg.norm(along, axis=1)
    wanted = wanted & (length >= ROOM * step)[:, None]
    stride = (step / np.where(length > 0, length, 1.0))[:, None] * along
    near = np.stack([vertices[ends[:, 0]] + stride, vertices[ends[:, 1]] - stride], axis=1)
    number = np.full(wanted.shape, -1, dtype=np.int64)
    number[wanted] = len(vertices) + np.arange(int(wanted.sum()))
    return np.concatenate([vertices, near[wanted]]), number


def _hard_edges(vertices: Floats, faces: Ints, sides: HalfEdges) -> Mask:
    """(E,) edges that bend sharply between two faces that go on smoothly, in parts made of flat pieces.

    Rounded shapes that are meshed coarsely bend sharply here and there too; those bends mean nothing.
    """
    bend = _bends(vertices, faces, sides)
    across = np.empty(faces.shape)
    across[sides.face, sides.corner] = bend[sides.edge]
    smoothest = np.minimum(np.roll(across, -1, axis=1), np.roll(across, -2, axis=1))
    rough = np.zeros(len(bend))
    np.maximum.at(rough, sides.edge, smoothest[sides.face, sides.corner])
    sharp = (bend > np.radians(HARD_ANGLE)) & (rough < SMOOTH_SHARE * bend)
    return np.asarray(sharp & _in_flat_parts(vertices, faces, sides, bend))


def _in_flat_parts(vertices: Floats, faces: Ints, sides: HalfEdges, bend: Floats) -> Mask:
    """(E,) edges of connected parts of which at least `FLAT_SHARE` of the edge length doesn't bend at all."""
    part = patches_of(len(faces), sides, plain_pairs(sides)).label[sides.face]
    length = np.linalg.norm(vertices[sides.end] - vertices[sides.start], axis=1)
    flat = (bend < np.radians(FLAT_ANGLE))[sides.edge] & ~sides.border
    made_of_flats = np.bincount(part, length * flat) >= FLAT_SHARE * np.bincount(part, length)
    chosen = np.zeros(len(bend), dtype=bool)
    chosen[sides.edge] = made_of_flats[part]
    return chosen


def _bends(vertices: Floats, faces: Ints, sides: HalfEdges) -> Floats:
    """(E,) angle between the normals of the faces at each edge, radians; 0 at borders."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    first = np.cumsum(sides.count) - sides.count
    second = first + np.minimum(sides.count, 2) - 1
    one, other = normal[sides.face[first]], normal[sides.face[second]]
    sine = np.linalg.norm(np.cross(one, other), axis=1)
    return np.asarray(np.arctan2(sine, np.einsum("nd,nd->n", one, other)))


@njit(cache=True)
def _divide(
    vertices: Floats, faces: Ints, touched: Mask, edge_of: Ints, hard: Mask, ends: Ints, number: Ints, step: float
) -> tuple[Floats, Ints, Mask]:
    """Divide the faces that touch hard edges: the vertices put inside of them, the parts, and which faces they were."""
    inside = np.empty((3 * len(faces), 3))
    parts = np.empty((16 * len(faces), 3), np.int64)
    divided = np.zeros(len(faces), np.bool_)
    n_inside, n_parts, first_inside = 0, 0, len(vertices)
    ring, corners = np.empty(6, np.int64), np.empty((6, 3))
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    for f in range(len(faces)):
        if not touched[f]:
            continue
        size, before = 0, n_parts
        for k in range(3):
            v, edge, previous = faces[f, k], edge_of[f, k], edge_of[f, (k + 2) % 3]
            came = number[previous, 0 if ends[previous, 0] == v else 1]
            goes = number[edge, 0 if ends[edge, 0] == v else 1]
            if hard[edge] and hard[previous] and _has_room(vertices, faces[f], step):
                inside[n_inside] = _inset(vertices, faces[f], k, step)
                came = goes = first_inside + n_inside
                n_inside += 1
            elif hard[edge]:
                goes = came
            elif hard[previous]:
                came = goes
            first[k], last[k] = (came if came >= 0 else v), (goes if goes >= 0 else v)
            ring[size] = first[k]
            size += 1
            if last[k] != first[k]:
                ring[size] = last[k]
                size += 1
                n_parts = _add(parts, n_parts, v, last[k], first[k])
        for k in range(3):
            after = (k + 1) % 3
            if hard[edge_of[f, k]]:
                n_parts = _add(parts, n_parts, faces[f, k], faces[f, after], first[after])
                n_parts = _add(parts, n_parts, faces[f, k], first[after], last[k])
        if n_parts == before and size == 3:
            continue
        divided[f] = True
        for j in range(size):
            corners[j] = vertices[ring[j]] if ring[j] < first_inside else inside[ring[j] - first_inside]
        apex = _best_apex(corners[:size])
        for j in range(1, size - 1):
            n_parts = _add(parts, n_parts, ring[apex], ring[(apex + j) % size], ring[(apex + j + 1) % size])
    return inside[:n_inside].copy(), parts[:n_parts].copy(), divided


@njit(cache=True)
def _best_apex(corners: Floats) -> int:
    """The corner of a polygon from which a fan has the largest smallest triangle: some corners lie on one line."""
    size, best, largest = len(corners), 0, -1.0
    for apex in range(size):
        smallest = np.inf
        for j in range(1, size - 1):
            one = corners[(apex + j) % size] - corners[apex]
            other = corners[(apex + j + 1) % size] - corners[apex]
            area = float(np.linalg.norm(np.cross(one, other)))
            smallest = area if area < smallest else smallest
        if smallest > largest:
            best, largest = apex, smallest
    return best


@njit(cache=True)
def _add(parts: Ints, count: int, a: int, b: int, c: int) -> int:
    """Append a triangle unless it has no area by its corners; returns the new count."""
    if a == b or b == c or c == a:
        return count
    parts[count, 0], parts[count, 1], parts[count, 2] = a, b, c
    return count + 1


@njit(cache=True)
def _has_room(vertices: Floats, face: Ints, step: float) -> bool:
    """Whether the circle inside the triangle is wide enough for a strip on each side."""
    a, b, c = vertices[face[0]], vertices[face[1]], vertices[face[2]]
    around = np.linalg.norm(b - a) + np.linalg.norm(c - b) + np.linalg.norm(a - c)
    return bool(np.linalg.norm(np.cross(b - a, c - a)) > ROOM / 2 * step * around)


@njit(cache=True)
def _inset(vertices: Floats, face: Ints, k: int, step: float) -> Floats:
    """The point a step away from both sides of the triangle that meet at corner k."""
    corner = vertices[face[k]]
    one, other = vertices[face[(k + 1) % 3]] - corner, vertices[face[(k + 2) % 3]] - corner
    one, other = one / np.linalg.norm(one), other / np.linalg.norm(other)
    inset: Floats = corner + step / np.linalg.norm(np.cross(one, other)) * (one + other)
    return inset
