"""How the faces of a mesh hang together: edges, borders, and the repair of what isn't a surface.

A surface has one or two faces at every edge and one fan of faces at every vertex. Any set of faces becomes one by
deciding, edge by edge, which faces are joined (`Pairs`); where they aren't, their vertices are split.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

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
    first, second = sides.face[pairs.first], sides.face[pairs.second]
    # Two faces agree when they run along their common edge in opposite directions.
    disagree = sides.forward[pairs.first] == sides.forward[pairs.second]
    tree = minimum_spanning_tree(_adjacency(face_count, first, second)).tocoo()
    in_tree = _lookup(face_count, first, second, tree.row, tree.col)
    flipped = _parity(face_count, first[in_tree], second[in_tree], disagree[in_tree])
    whole = (flipped[first] ^ flipped[second]) == disagree
    _, label = connected_components(_adjacency(face_count, first, second), directed=False)
    return Patches(label.astype(np.int64), flipped, pairs.take(whole), int((~whole).sum()))


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
    joins = (
        np.concatenate([at_start[a], at_end[a]]),
        np.concatenate([np.where(same, at_start[b], at_end[b]), np.where(same, at_end[b], at_start[b])]),
    )
    count, fan = connected_components(_adjacency(faces.size, *joins), directed=False)
    fan_vertex = np.empty(count, dtype=np.int64)
    fan_vertex[fan] = faces.ravel()
    return fan_vertex, fan.reshape(-1, 3)


def _adjacency(count: int, first: Ints, second: Ints) -> csr_array:
    return coo_array((np.ones(len(first)), (first, second)), shape=(count, count)).tocsr()


def _lookup(count: int, first: Ints, second: Ints, row: Ints, col: Ints) -> Mask:
    """Which (first, second) are among the tree's edges (row, col); of repeated pairs, only the first."""
    keys = np.minimum(first, second) * count + np.maximum(first, second)
    wanted = np.minimum(row, col).astype(np.int64) * count + np.maximum(row, col)
    _, positions = np.unique(keys, return_index=True)
    chosen = np.zeros(len(keys), dtype=bool)
    chosen[positions] = True
    return np.asarray(chosen & np.isin(keys, wanted))


def _parity(count: int, first: Ints, second: Ints, odd: Mask) -> Mask:
    """Two-colour a forest: nodes joined by an odd edge differ; the lowest node of each tree is False.

    Every node is doubled (as it is, turned over); the components of the doubled forest are the consistent choices.
    """
    other = second + np.where(odd, count, 0)
    mirrored = second + np.where(odd, 0, count)
    doubled = _adjacency(2 * count, np.concatenate([first, first + count]), np.concatenate([other, mirrored]))
    _, label = connected_components(doubled, directed=False)
    plain, turned = label[:count], label[count:]
    # Components are numbered by their lowest node, so the choice that leaves a tree's lowest node alone comes first.
    return np.asarray(plain > turned)
