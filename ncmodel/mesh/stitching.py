"""Borders that touch without sharing vertices: found, and connected by splitting faces.

Two polygons that meet along an edge but not in the same vertices leave a crack that can't be seen, yet every line that
crosses it breaks and a boundary is drawn along it. Border edges that pass through another border vertex (a T-junction)
are split there.
"""

import numpy as np

from ncmodel.jit import kernel
from ncmodel.mesh.point_tree import PointTree, near_segment
from ncmodel.types import Floats, Ints

SHARE_OF_EDGE = 0.1
"""Vertices become one only if they are nearer than this share of the edges around them: fine detail is left alone."""

MAX_PASSES = 8
"""A split can make another one possible; slivers side by side need several passes."""


def touching(vertices: Floats, faces: Ints, ends: Ints, face: Ints, reach: Floats, margin: Floats) -> Ints:
    """Border vertices that lie on border edges which don't end there.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        ends: (n, 2) border edges, in the direction of their face.
        face: (n,) the face of each.
        reach: (n,) the largest distance of a vertex from each edge.
        margin: (n,) the least distance of a vertex from each edge's ends.

    Returns:
        (m, 2) rows: an edge, and a vertex strictly inside it that isn't a corner of its face, ascending by edge.
    """
    if len(ends) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    corners = np.unique(ends)
    points = vertices[corners]
    edge, vertex = _on_edges(points, np.searchsorted(corners, ends), reach, margin, PointTree.of(points)).T
    return _apart(faces, face, np.stack([edge, corners[vertex]], axis=1))


def split_faces(vertices: Floats, faces: Ints, ends: Ints, face: Ints, touches: Ints) -> Ints:
    """Split each touched face at the vertices on its edges.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        ends: (n, 2) border edges, in the direction of their face.
        face: (n,) the face of each.
        touches: (m, 2) rows: a border edge, and a vertex on it, as `touching` finds them.

    Returns:
        (F', 3), the parts of a face in its place.
    """
    while len(touches):
        touched, first = np.unique(face[touches[:, 0]], return_index=True)
        chosen = np.full(len(faces), -1)
        chosen[touched] = touches[first, 0]
        now = touches[:, 0] == chosen[face[touches[:, 0]]]
        parts, count = _fans(vertices, faces, ends, chosen, touches[now])
        # Of a face that is split, the edge that follows now belongs to the last part, the one before to the first.
        follows = (chosen[face] >= 0) & (ends[:, 0] == ends[chosen[face], 1])
        face = (np.cumsum(count) - count)[face] + np.where(follows, count[face] - 1, 0)
        faces, touches = parts, _apart(parts, face, touches[~now])
    return faces


def _apart(faces: Ints, face: Ints, touches: Ints) -> Ints:
    """The touches whose vertex isn't a corner of the edge's face."""
    apart = (faces[face[touches[:, 0]]] != touches[:, 1, None]).all(axis=1)
    return np.asarray(touches[apart])


def _fans(vertices: Floats, faces: Ints, ends: Ints, chosen: Ints, touches: Ints) -> tuple[Ints, Ints]:
    """Faces split into fans from the corner opposite one of their edges, at the vertices that touch it.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        ends: (n, 2) border edges.
        chosen: (F,) the edge of each face that is split, -1 for the others.
        touches: (m, 2) rows: a chosen edge, and a vertex on it.

    Returns:
        (F', 3) the faces, and (F,) how many each became.
    """
    split = np.flatnonzero(chosen >= 0)
    edges = chosen[split]
    start, end = ends[edges].T
    numbers = np.empty(len(ends), dtype=np.int64)
    numbers[edges] = np.arange(len(edges))
    fan, vertex = numbers[touches[:, 0]], touches[:, 1]
    along = ((vertices[vertex] - vertices[start][fan]) * (vertices[end] - vertices[start])[fan]).sum(axis=1)
    order = np.lexsort((along, fan))
    fan, vertex = fan[order], vertex[order]
    opens, closes = (np.searchsorted(fan, np.arange(len(split)), side) for side in ("left", "right"))
    count = np.ones(len(faces), dtype=np.int64)
    count[split] += closes - opens
    left, right = np.insert(vertex, opens, start), np.insert(vertex, closes, end)
    apex = np.repeat(faces[split].sum(axis=1) - start - end, count[split])
    parts = np.repeat(faces, count, axis=0)
    parts[np.repeat(chosen >= 0, count)] = np.stack([left, right, apex], axis=1)
    return parts, count


@kernel
def _on_edges(points: Floats, ends: Ints, reach: Floats, margin: Floats, tree: PointTree) -> Ints:
    """(m, 2) rows (edge, point) of points strictly inside edges.

    Args:
        points: (N, 3).
        ends: (n, 2) indices of points.
        reach: (n,) how far from each edge.
        margin: (n,) how far from its ends, at least.
        tree: Of the points.
    """
    found = []
    near = np.empty(len(points), np.int64)
    for e in range(len(ends)):
        a = points[ends[e, 0]]
        axis = points[ends[e, 1]] - a
        square = (axis * axis).sum()
        if square == 0.0:
            continue
        length = np.sqrt(square)
        for i in near[: near_segment(tree, a, axis, reach[e], near)]:
            if i == ends[e, 0] or i == ends[e, 1]:
                continue
            away = points[i] - a
            s = (away * axis).sum() / square
            off = away - s * axis
            if (off * off).sum() <= reach[e] ** 2 and min(s, 1.0 - s) * length > margin[e]:
                found.append((e, i))
    rows = np.empty((len(found), 2), np.int64)
    for m in range(len(found)):
        rows[m, 0], rows[m, 1] = found[m]
    return rows
