"""Rounded edges of few triangles: the strips that stand for an edge, and the one line that is drawn of each.

A designer rounds an edge with one to three rows of narrow faces; none of the bends between them is a crease, all of
them together are. Across each edge that bends a little, the surface is followed straight on, to both sides. If it bends
one way, by more than the crease angle, within a narrow strip, and hardly before or after it for the width of the strip,
the edge belongs to a rounded edge. Where rows follow each other for longer, the surface is curved.
"""

import math
from dataclasses import dataclass

import numpy as np

from ncmodel.geometry.adjacency import Rings
from ncmodel.geometry.normals_areas import Indices, check_columns, sides_of
from ncmodel.geometry.straight_ways import Faces, bend_between, neighbour, walk
from ncmodel.jit import kernel
from ncmodel.lines.chaining import chain
from ncmodel.lines.edges import Edges
from ncmodel.types import Floats, Ints, Mask

LEAST_BEND = math.radians(8.0)
"""Edges that bend less are none between the rows of a rounded edge; and all such bends beside it together, at most."""
ROWS = 3
"""A rounded edge has at most so many rows of faces."""
WIDEST = 0.015
"""And is at most so wide, in longest sides of the object."""
NARROW = 0.5
"""Beside each of its edges lies a face that is at most so high, in lengths of the edge: rows are longer than wide."""
FLANK = 2.0
"""The surface to both sides of a rounded edge hardly bends for so many of its widths."""
LEDGE = 1.0
"""The same where a crease ends the flank: what is bent sharply there isn't the rounded edge going on."""


@dataclass(frozen=True, eq=False)
class Strips:
    """The edges of rounded edges.

    Attributes:
        edges: All of them.
        across: (n, ROWS + 1) the edges on the way across at each of them, itself included; -1 where there are less.
        flanks: (n, 2) the faces just before and after the rounded edge.
        middle: (n,) which lie in the middle, one in each row of them: along those a line is drawn.
    """

    edges: Edges
    across: Ints
    flanks: Ints
    middle: Mask


def rounded_edges(vertices: Floats, faces: Indices, rings: Rings, bends: Edges, angle: float) -> Strips:
    """The strips that stand for an edge.

    Args:
        vertices: (V, 3) in object space.
        faces: (F, 3).
        rings: The faces around each vertex.
        bends: The edges that bend by more than `LEAST_BEND`.
        angle: The crease angle, radians: a rounded edge bends by more, each of its edges by less.
    """
    crossed, flanks, aside = _across(Faces(vertices, faces, rings), bends.ends, bends.face, angle)
    part = np.flatnonzero(np.isfinite(aside))
    edges = Edges(bends.ends[part], bends.face[part])
    if len(part) == 0:
        nothing = np.empty((0, ROWS + 1), dtype=np.int64)
        return Strips(edges, nothing, flanks[part], np.empty(0, dtype=np.bool_))
    keys, met = edge_keys(edges.ends, len(vertices)), edge_keys(crossed[part], len(vertices))
    order = np.argsort(keys)
    at = order[np.minimum(np.searchsorted(keys[order], met), len(keys) - 1)]
    across = np.where((keys[at] == met) & (crossed[part, :, 0] >= 0), at, -1)
    return Strips(edges, across, flanks[part], _middle(vertices[edges.ends], across, aside[part]))


def edge_keys(ends: Ints, count: int) -> Ints:
    """A number for each edge (..., 2) of a mesh with `count` vertices."""
    return np.asarray(ends.min(axis=-1) * count + ends.max(axis=-1))


def _middle(points: Floats, across: Ints, aside: Floats) -> Mask:
    """(n,) the edges of the row of edges in the middle of each rounded edge; of two rows, of one of them.

    Args:
        points: (n, 2, 3) the edges.
        across: As `Strips` has it.
        aside: (n,) how far each lies off the middle.
    """
    chains = chain(points)
    row = np.full(len(points), len(chains))
    row[chains.segment] = np.repeat(np.arange(len(chains)), np.diff(chains.first))
    length = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    off = np.bincount(row, length * aside) / np.maximum(np.bincount(row, length), 1e-300)
    # Where two rows are as far off the middle, rounding must not decide: the earlier one is taken.
    place = np.empty(len(off), dtype=np.int64)
    place[np.lexsort((np.arange(len(off)), np.round(off / (0.05 * WIDEST))))] = np.arange(len(off))
    met = np.where(across >= 0, place[row[across]], len(off))
    return np.asarray(place[row] <= met.min(axis=1))


@kernel
def _across(surface: Faces, ends: Ints, face: Ints, angle: float) -> tuple[Ints, Ints, Floats]:
    """For each edge, the edges on the way across the rounded edge, its flanks, and how far it is off the middle.

    That is infinite for edges of no rounded edge.
    """
    check_columns(surface.vertices, 3)
    check_columns(surface.faces, 3)
    across = np.full((len(ends), ROWS + 1, 2), -1)
    flanks = np.full((len(ends), 2), -1)
    aside = np.full(len(ends), np.inf)
    # The bends on the way, their places (below 0 to one side, above it to the other), their edges
    # and the faces beyond them.
    size = 2 * (ROWS + 1) + 1
    bend, place, edge = np.empty(size), np.empty(size), np.empty((size, 3), np.int64)
    for e in range(len(ends)):
        own, count = _way(surface, ends[e, 0], ends[e, 1], face[e], bend, place, edge)
        first, last = _strip(bend, place, own, count, angle)
        if first < 0:
            continue
        total, centre = 0.0, 0.0
        for n in range(first, last + 1):
            total += bend[n]
            centre += bend[n] * place[n]
            across[e, n - first, 0], across[e, n - first, 1] = edge[n, 0], edge[n, 1]
        aside[e] = abs(centre / total)
        flanks[e, 0] = edge[first, 2] if first < own else face[e]
        flanks[e, 1] = edge[last, 2]
    return across, flanks, aside


@kernel
def _strip(bend: Floats, place: Floats, own: int, count: int, angle: float) -> tuple[int, int]:
    """The first and the last of the bends, in the order of their places, that make up a rounded edge; -1 for none."""
    if count == 0 or abs(bend[own]) >= angle:
        return -1, -1
    first, last, total = own, own, bend[own]
    while True:
        width = place[last] - place[first]
        before = place[first] - place[first - 1] if first > 0 else np.inf
        after = place[last + 1] - place[last] if last + 1 < count else np.inf
        least_before = (LEDGE if first > 0 and abs(bend[first - 1]) >= angle else FLANK) * width
        least_after = (LEDGE if last + 1 < count and abs(bend[last + 1]) >= angle else FLANK) * width
        if last > first and abs(total) > angle and before > least_before and after > least_after:
            return first, last
        if last - first == ROWS or min(before, after) == np.inf:
            return -1, -1
        if before < after:
            first -= 1
        else:
            last += 1
        new = bend[first] if before < after else bend[last]
        total += new
        if new * bend[own] <= 0.0 or abs(new) >= angle or place[last] - place[first] > WIDEST:
            return -1, -1


@kernel
def _way(surface: Faces, i: int, j: int, f: int, bend: Floats, place: Floats, edge: Ints) -> tuple[int, int]:
    """The bends on the way across an edge's middle, in the order of their places: which is its own, how many there are.

    Small bends are left out unless they add up. Where the surface ends before the way does, so that nobody knows how it
    would go on, an end counts as a bend of 0.
    """
    vertices = surface.vertices
    g = neighbour(surface.rings, i, j, f)
    if g < 0 or min(_slimness(surface, i, j, f), _slimness(surface, i, j, g)) > NARROW:
        return 0, 0
    middle = (
        (vertices[i, 0] + vertices[j, 0]) / 2.0,
        (vertices[i, 1] + vertices[j, 1]) / 2.0,
        (vertices[i, 2] + vertices[j, 2]) / 2.0,
    )
    reach = (1.0 + FLANK) * WIDEST
    count = walk(surface, (i, j, f), middle, -1.0, reach, LEAST_BEND, ROWS + 1, bend, place, edge, 0)
    for n in range(count // 2):
        m = count - 1 - n
        bend[n], bend[m] = bend[m], bend[n]
        place[n], place[m] = place[m], place[n]
        for side in range(3):
            edge[n, side], edge[m, side] = edge[m, side], edge[n, side]
    bend[count], place[count] = bend_between(surface, i, j, f, g), 0.0
    edge[count, 0], edge[count, 1], edge[count, 2] = i, j, g
    return count, walk(surface, (j, i, g), middle, 1.0, reach, LEAST_BEND, ROWS + 1, bend, place, edge, count + 1)


@kernel
def _slimness(surface: Faces, i: int, j: int, f: int) -> float:
    """The height of a face above its side between i and j, in lengths of the side."""
    vertices, faces = surface.vertices, surface.faces
    sides, _ = sides_of(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
    x, y, z = vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1], vertices[j, 2] - vertices[i, 2]
    area = math.sqrt(sides[9] ** 2 + sides[10] ** 2 + sides[11] ** 2)
    return area / max(float(x * x + y * y + z * z), 1e-300)
