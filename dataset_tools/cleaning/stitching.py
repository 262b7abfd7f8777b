"""Borders that touch without sharing vertices: found and connected.

Two polygons that meet along an edge but not in the same vertices leave a crack that can't be seen, yet every line that
crosses it breaks and a boundary is drawn along it. Border vertices closer than a tolerance become one, and border edges
that pass through another border vertex are split there.
"""

import numpy as np
from numba import njit

from dataset_tools.cleaning.half_edges import half_edges
from ncmodel.mesh.weld import coincident
from ncmodel.types import Floats, Ints

SHARE_OF_EDGE = 0.1
"""Nothing moves by more than this share of the edges around it, whatever the tolerance: fine detail is left alone."""

MAX_PASSES = 8
"""A split can make another one possible; slivers side by side need several passes."""


def merge_border_vertices(vertices: Floats, faces: Ints, tolerance: float) -> tuple[Ints, int]:
    """Renumber faces so that border vertices that nearly coincide become the first of them.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        tolerance: Largest distance between vertices that become one.

    Returns:
        The renumbered (F, 3) faces and how many vertices were merged into others.
    """
    sides = half_edges(faces)
    border = np.unique(np.concatenate([sides.start[sides.border], sides.end[sides.border]]))
    reach = np.minimum(tolerance, SHARE_OF_EDGE * _shortest_edges(vertices, faces))
    same = coincident(vertices, reach, among=border)
    return same[faces], int((same != np.arange(len(same))).sum())


def split_at_touching_vertices(vertices: Floats, faces: Ints, tolerance: float) -> tuple[Ints, int]:
    """Split faces whose border edge passes through another border vertex (a T-junction) at that vertex.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        tolerance: Largest distance of the vertex from the edge.

    Returns:
        The faces, each split one replaced by its parts in place, and how many vertices were taken into edges.
    """
    taken = 0
    for _ in range(MAX_PASSES):
        touches = touching_vertices(vertices, faces, tolerance)
        if len(touches) == 0:
            break
        faces, used = _split_once(vertices, faces, touches)
        taken += used
    return faces, taken


def touching_vertices(vertices: Floats, faces: Ints, tolerance: float) -> Ints:
    """(n, 3) rows: a border edge's face, the corner it starts at, and a border vertex that lies on it."""
    sides = half_edges(faces)
    border = sides.border
    corners = np.unique(sides.start[border])
    corners = corners[np.argsort(vertices[corners, 0], kind="stable")]
    edge, vertex = _on_edges(vertices, sides.start[border], sides.end[border], corners, tolerance).T
    face = sides.face[border][edge]
    apart = (faces[face] != vertex[:, None]).all(axis=1)
    return np.asarray(np.stack([face, sides.corner[border][edge], vertex], axis=1)[apart])


def _split_once(vertices: Floats, faces: Ints, touches: Ints) -> tuple[Ints, int]:
    """Split each touched face along one of its edges, the first touched one."""
    by_face: dict[int, tuple[int, list[int]]] = {}
    for face, corner, vertex in touches.tolist():
        known = by_face.setdefault(face, (corner, []))
        if known[0] == corner:
            known[1].append(vertex)
    parts = {face: _fan(vertices, faces[face], *touched) for face, touched in by_face.items()}
    count = np.ones(len(faces), dtype=np.int64)
    count[list(parts)] = [len(part) for part in parts.values()]
    first = np.cumsum(count) - count
    split = np.repeat(faces, count, axis=0)
    for face, part in parts.items():
        split[first[face] : first[face] + len(part)] = part
    return split, len(split) - len(faces)


def _fan(vertices: Floats, face: Ints, corner: int, on_edge: list[int]) -> Ints:
    """The face split at vertices on the edge that starts at `corner`: a fan from the corner opposite it."""
    start, end, apex = face[corner], face[(corner + 1) % 3], face[(corner + 2) % 3]
    along = vertices[on_edge] @ (vertices[end] - vertices[start])
    chain = np.concatenate([[start], np.array(on_edge, dtype=np.int64)[np.argsort(along, kind="stable")], [end]])
    return np.stack([chain[:-1], chain[1:], np.full(len(chain) - 1, apex)], axis=1)


def _shortest_edges(vertices: Floats, faces: Ints) -> Floats:
    """(V,) length of the shortest edge at each vertex, infinite for unused ones."""
    shortest = np.full(len(vertices), np.inf)
    for k in range(3):
        a, b = faces[:, k], faces[:, (k + 1) % 3]
        length = np.linalg.norm(vertices[a] - vertices[b], axis=1)
        np.minimum.at(shortest, a, length)
        np.minimum.at(shortest, b, length)
    return shortest


@njit(cache=True)
def _on_edges(vertices: Floats, start: Ints, end: Ints, corners: Ints, tolerance: float) -> Ints:
    """(n, 2) rows (edge, vertex) of the `corners`, sorted by x, that lie strictly inside an edge."""
    found = []
    x = vertices[corners, 0]
    for e in range(len(start)):
        a, b = vertices[start[e]], vertices[end[e]]
        axis = b - a
        square = axis @ axis
        if square == 0.0:
            continue
        reach = min(tolerance, SHARE_OF_EDGE * np.sqrt(square))
        lowest = np.searchsorted(x, min(a[0], b[0]) - reach)
        highest = np.searchsorted(x, max(a[0], b[0]) + reach)
        for i in range(lowest, highest):
            away = vertices[corners[i]] - a
            s = (away @ axis) / square
            if s <= 0.0 or s >= 1.0 or corners[i] == start[e] or corners[i] == end[e]:
                continue
            off = away - s * axis
            if off @ off <= reach * reach and min(s, 1.0 - s) * np.sqrt(square) > reach:
                found.append((e, corners[i]))
    rows = np.empty((len(found), 2), np.int64)
    for i in range(len(found)):
        rows[i, 0], rows[i, 1] = found[i]
    return rows
