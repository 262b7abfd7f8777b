"""How the faces of a mesh hang together: edges, borders, and the repair of what isn't a surface.

A surface has one or two faces at every edge and one fan of faces at every vertex. Any set of faces becomes one by
deciding, edge by edge, which faces are joined (`Pairs`); where they aren't, their vertices are split.
"""

from dataclasses import dataclass

import numpy as np

from ncmodel.geometry.adjacency import components, wound_alike
from ncmodel.types import Floats, Ints, Mask


@dataclass(frozen=True, eq=False)
class HalfEdges:
    """The 3F sides of faces, sorted so that the sides along the same edge are neighbours.

    Attributes:
        face: (3F,) the face that each side belongs to.
        corner: (3F,) the corner 0..2 that the side starts at; it ends at the next one.
        start: (3F,) the vertex that it starts at.
        end: (3F,) the vertex that it ends at.
        edge: (3F,) number of the undirected edge, ascending.
        count: (E,) faces at each edge.
    """

    face: Ints
    corner: Ints
    start: Ints
    end: Ints
    edge: Ints
    count: Ints

    @property
    def forward(self) -> Mask:
        """(3F,) True where the side runs from the lower vertex index to the higher one."""
        return np.asarray(self.start < self.end)

    @property
    def border(self) -> Mask:
        """(3F,) True where no other face has this edge."""
        return np.asarray(self.count[self.edge] == 1)


def half_edges(faces: Ints) -> HalfEdges:
    """The sides of (F, 3) faces, grouped by edge."""
    start = faces.ravel()
    end = np.roll(faces, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.lexsort((high, low))
    low, high = low[order], high[order]
    opens = np.ones(len(order), dtype=bool)
    opens[1:] = (low[1:] != low[:-1]) | (high[1:] != high[:-1])
    edge = np.cumsum(opens) - 1
    return HalfEdges(order // 3, order % 3, start[order], end[order], edge, np.bincount(edge))


@dataclass(frozen=True, eq=False)
class Pairs:
    """Faces joined along an edge.

    Attributes:
        first: (P,) indices into the half-edges.
        second: (P,) indices into the half-edges.
    """

    first: Ints
    second: Ints

    def take(self, keep: Mask) -> "Pairs":
        """The pairs selected by a mask."""
        return Pairs(self.first[keep], self.second[keep])


def plain_pairs(sides: HalfEdges) -> Pairs:
    """The faces at edges that have exactly two."""
    first = np.flatnonzero((sides.count[sides.edge] == 2) & (np.diff(sides.edge, prepend=-1) > 0))
    return Pairs(first, first + 1)


@dataclass(frozen=True, eq=False)
class Patches:
    """Joined faces, wound alike.

    Attributes:
        label: (F,) the patch that each face belongs to.
        flipped: (F,) which faces had to be turned over to agree with the first face of their patch.
        pairs: The pairs still joined; those that would make a patch one-sided (a Moebius strip) are cut.
        cut: How many were cut.
    """

    label: Ints
    flipped: Mask
    pairs: Pairs
    cut: int


def patches_of(face_count: int, sides: HalfEdges, pairs: Pairs) -> Patches:
    """Connected patches of faces and the flips that make each patch wind consistently."""
    faces = np.stack([sides.face[pairs.first], sides.face[pairs.second]], axis=1)
    # Two faces agree when they run along their common edge in opposite directions.
    disagree = sides.forward[pairs.first] == sides.forward[pairs.second]
    label, flipped = wound_alike(face_count, faces, disagree)
    whole = (flipped[faces[:, 0]] ^ flipped[faces[:, 1]]) == disagree
    return Patches(label, flipped, pairs.take(whole), int((~whole).sum()))


def split_vertices(vertices: Floats, faces: Ints, sides: HalfEdges, pairs: Pairs) -> tuple[Floats, Ints]:
    """Give every fan of joined faces its own vertex.

    The first fan at a vertex keeps it; copies for the others come after the last vertex, so nothing is renumbered.
    """
    fan_vertex, fan = fans_of(faces, sides, pairs)
    _, keeper = np.unique(fan_vertex, return_index=True)
    extra = np.ones(len(fan_vertex), dtype=bool)
    extra[keeper] = False
    number = fan_vertex.copy()
    number[extra] = len(vertices) + np.arange(int(extra.sum()))
    return np.concatenate([vertices, vertices[fan_vertex[extra]]]), number[fan]


def fans_of(faces: Ints, sides: HalfEdges, pairs: Pairs) -> tuple[Ints, Ints]:
    """The fans of joined faces around vertices.

    Returns:
        The vertex of each fan, and the (F, 3) fan of each corner.
    """
    at_start, at_end = 3 * sides.face + sides.corner, 3 * sides.face + (sides.corner + 1) % 3
    a, b = pairs.first, pairs.second
    same = sides.start[a] == sides.start[b]
    joins = np.concatenate(
        [
            np.stack([at_start[a], np.where(same, at_start[b], at_end[b])], axis=1),
            np.stack([at_end[a], np.where(same, at_end[b], at_start[b])], axis=1),
        ]
    )
    fan = components(joins, faces.size)
    fan_vertex = np.empty(int(fan.max()) + 1, dtype=np.int64)
    fan_vertex[fan] = faces.ravel()
    return fan_vertex, fan.reshape(-1, 3)
