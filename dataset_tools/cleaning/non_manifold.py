"""Edges at which more than two faces meet: which of them continue the surface, and how they are told apart."""

import numpy as np

from dataset_tools.cleaning.half_edges import HalfEdges, Pairs, half_edges, plain_pairs, split_vertices
from ncmodel.types import Floats, Ints

MAX_PASSES = 8
"""Edges that share a face are halved in different passes."""


def pair_faces(vertices: Floats, faces: Ints, sides: HalfEdges, exposure: Floats, origin: Ints) -> Pairs:
    """Decide which faces are joined at each edge.

    Two faces at an edge are joined. Where there are more, the faces around the edge enclose wedges; the two faces that
    bound a wedge are joined through it, the wedge most open to the outside first, so that what is seen from outside
    stays one surface and inner walls are cut off from it.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        sides: Their half-edges.
        exposure: (F, 2) how much of the outside the front and the back of each face see; only the order matters, and
            wedges with a side at 0 are not joined through.
        origin: (F,) orders faces that lie in the same plane, which the angle can't.
    """
    first = np.cumsum(sides.count) - sides.count
    joined = [plain_pairs(sides)]
    for edge in np.flatnonzero(sides.count > 2):
        group = np.arange(first[edge], first[edge] + sides.count[edge])
        joined.append(_pair_around(vertices, faces, sides, exposure, origin, group))
    return Pairs(np.concatenate([pair.first for pair in joined]), np.concatenate([pair.second for pair in joined]))


def halve_tangled_edges(vertices: Floats, faces: Ints, exposure: Floats) -> tuple[Floats, Ints, Ints]:
    """Halve the edges that would still have more than two faces after their vertices are split.

    Two pairs of faces at one edge that belong to the same fan at both ends share its vertices whatever is split.
    Halfway along the edge they are apart, so there each pair can get a vertex of its own.

    Returns:
        The vertices, the faces, and for each face the one that it came from.
    """
    origin = np.arange(len(faces))
    for _ in range(MAX_PASSES):
        sides = half_edges(faces)
        pairs = pair_faces(vertices, faces, sides, exposure[origin], origin)
        _, apart = split_vertices(vertices, faces, sides, pairs)
        after = half_edges(apart)
        tangled = np.unique(_edge_of(sides, after.face, after.corner)[after.count[after.edge] > 2])
        if len(tangled) == 0:
            break
        vertices, faces, parent = _halve(vertices, faces, sides, _independent(sides, tangled))
        origin = origin[parent]
    return vertices, faces, origin


def _pair_around(vertices: Floats, faces: Ints, sides: HalfEdges, exposure: Floats, origin: Ints, group: Ints) -> Pairs:
    """Join the faces `group` (half-edges of one edge) through their most exposed wedges."""
    low, high = sorted((sides.start[group[0]], sides.end[group[0]]), key=lambda v: tuple(vertices[v]))
    opposite = vertices[faces[sides.face[group], (sides.corner[group] + 2) % 3]]
    group = group[np.lexsort((origin[sides.face[group]], _angles_about(vertices[low], vertices[high], opposite)))]
    face, forward = sides.face[group], sides.start[group] == low
    # Counter-clockwise about the edge comes the front of a face that runs along it, the back of one that runs against
    # it.
    ahead = np.where(forward, exposure[face, 0], exposure[face, 1])
    behind = np.where(forward, exposure[face, 1], exposure[face, 0])
    following = np.roll(np.arange(len(group)), -1)
    openness = np.minimum(ahead, behind[following])
    free = np.ones(len(group), dtype=bool)
    pairs = []
    for wedge in np.argsort(-openness, kind="stable"):
        a, b = wedge, following[wedge]
        if openness[wedge] > 0 and free[a] and free[b]:
            free[[a, b]] = False
            pairs.append((group[a], group[b]))
    first, second = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return Pairs(first, second)


def _angles_about(low: Floats, high: Floats, points: Floats) -> Floats:
    """(n,) angle of each point about the axis from `low` to `high`, radians, counter-clockwise seen from `high`.

    Rounded, so that faces in one plane tie, and both halves of an edge see the same order.
    """
    axis = high - low
    axis = axis / np.linalg.norm(axis)
    reference = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    away = points - low
    angle: Floats = np.arctan2(away @ np.cross(axis, reference), away @ reference)
    return angle.round(9)


def _edge_of(sides: HalfEdges, face: Ints, corner: Ints) -> Ints:
    """The edge that the side of `face` starting at `corner` lies along."""
    table = np.empty((int(sides.face.max()) + 1, 3), dtype=np.int64)
    table[sides.face, sides.corner] = sides.edge
    return np.asarray(table[face, corner])


def _independent(sides: HalfEdges, edges: Ints) -> Ints:
    """As many of the edges as can be taken without two that share a face."""
    first = np.cumsum(sides.count) - sides.count
    taken: set[int] = set()
    chosen = []
    for edge in edges:
        around = sides.face[first[edge] : first[edge] + sides.count[edge]].tolist()
        if taken.isdisjoint(around):
            taken.update(around)
            chosen.append(edge)
    return np.array(chosen, dtype=np.int64)


def _halve(vertices: Floats, faces: Ints, sides: HalfEdges, edges: Ints) -> tuple[Floats, Ints, Ints]:
    """Put a vertex halfway along edges that share no face and split the faces there; the second halves come last."""
    at = np.flatnonzero(np.isin(sides.edge, edges))
    middle = len(vertices) + np.searchsorted(edges, sides.edge[at])
    _, one_side = np.unique(sides.edge[at], return_index=True)
    ends = at[one_side]
    middles = (vertices[sides.start[ends]] + vertices[sides.end[ends]]) / 2
    face, corner = sides.face[at], sides.corner[at]
    second_half = faces[face].copy()
    second_half[np.arange(len(at)), corner] = middle
    first_half = faces.copy()
    first_half[face, (corner + 1) % 3] = middle
    origin = np.concatenate([np.arange(len(faces)), face])
    return np.concatenate([vertices, middles]), np.concatenate([first_half, second_half]), origin
