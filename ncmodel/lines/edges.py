"""Edges of a mesh: borders, creases, whether it is closed (docs/geometry.md 10)."""

import math
from dataclasses import dataclass

import numpy as np

from ncmodel.geometry.adjacency import Offsets, Rings
from ncmodel.geometry.coincident_faces import scrambled
from ncmodel.geometry.normals_areas import Indices, check_columns, sides_of
from ncmodel.geometry.view_vectors import toward
from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mask

MOST_ALIKE = 8
"""Of sides without a twin that run from one vertex to the same other one, as in faces that lie on each other or in a
book of many pages, this many are told, of the first faces: the rest would be drawn over them."""


@dataclass(frozen=True, eq=False)
class Edges:
    """Some edges of a mesh.

    Attributes:
        ends: (n, 2) vertex indices, in the direction of `face`.
        face: (n,) an adjacent face.
    """

    ends: Ints
    face: Ints

    def __len__(self) -> int:
        return len(self.ends)

    def take(self, kept: Mask | Ints) -> "Edges":
        """Those selected by a mask or by indices."""
        return Edges(self.ends[kept], self.face[kept])

    def joined(self, others: "Edges") -> "Edges":
        """These, and others after them."""
        return Edges(np.concatenate([self.ends, others.ends]), np.concatenate([self.face, others.face]))

    def lines(self, family: LineFamily, vertices: Floats) -> LineSet:
        """The edges as lines that no threshold filters."""
        ones = np.ones((len(self.ends), 2))
        return LineSet(family, vertices[self.ends], self.face, ones, ones)


def is_closed(faces: Indices) -> bool:
    """Whether the directed sides pair off with opposite ones: no border, no turned neighbour, no side too many.

    Sums a hash of every side less one of its reverse; a mesh that isn't closed passes in one of 2^64 cases.
    """
    return bool(_closed(faces))


def boundary_edges(rings: Rings) -> Edges:
    """Directed sides without an oppositely directed twin, in face order; `MOST_ALIKE` of each at most."""
    return _in_face_order(rings, *_unpaired(rings.starts, rings.around))


def creases(vertices: Floats, rings: Rings, angle: float) -> Edges:
    """Edges between oppositely directed sides whose faces' normals differ by more than `angle` radians, in face order.

    Where more than two faces meet, one sharp pair is enough; degenerate faces don't count.
    """
    return _in_face_order(rings, *_sharp(vertices, rings.starts, rings.around, math.cos(angle)))


def bent_to(edges: Edges, vertices: Floats, rings: Rings, viewpoint: Floats, angle: float) -> Edges:
    """The edges that an eye sees as such: of those with more than two faces, where those two bend that it sees.

    Where an inner wall meets a flat side, or another body touches it along an edge, faces bend sharply; but not those
    on either side of the room that the eye is in.

    Args:
        edges: Borders or creases.
        vertices: (V, 3).
        rings: The faces around each vertex.
        viewpoint: (4,) where they are seen from.
        angle: Radians that these two faces bend at least.
    """
    kept = _bent_to(edges.ends, vertices, rings.starts, rings.around, viewpoint, angle)
    return edges if kept.all() else Edges(edges.ends[kept], edges.face[kept])


def _in_face_order(rings: Rings, start: Indices, corner: Indices) -> Edges:
    """Sides from vertex `start` to the vertex that follows it at `corner` of the rings."""
    face, end = rings.face[corner], rings.around[corner, 0]
    order = np.argsort(face, kind="stable")
    return Edges(np.stack([start, end], axis=1)[order].astype(np.int64), face[order].astype(np.int64))


@kernel
def _closed(faces: Indices) -> bool:
    check_columns(faces, 3)
    total = np.uint64(0)
    for f in range(len(faces)):
        for c in range(3):
            i, j = np.uint64(faces[f, c]), np.uint64(faces[f, (c + 1) % 3])
            total += _mixed(i, j) - _mixed(j, i)
    return bool(total == np.uint64(0))


@kernel
def _mixed(i: np.uint64, j: np.uint64) -> np.uint64:
    """A 64-bit hash of an ordered pair."""
    return scrambled((i << np.uint64(32)) ^ j)


@kernel
def _unpaired(starts: Offsets, around: Indices) -> tuple[Indices, Indices]:
    """Sides (start vertex, ring corner) from a vertex to its next, whom no face has as the vertex's previous one."""
    vertex = np.empty(len(around), dtype=np.uint32)
    corner = np.empty(len(around), dtype=np.uint32)
    previous_of = np.full(len(starts), -1, dtype=np.int32)
    found = np.zeros(len(starts), dtype=np.int32)
    size = 0
    for v in range(len(starts) - 1):
        for n in range(starts[v], starts[v + 1]):
            previous_of[around[n, 1]] = v
            found[around[n, 0]] = 0
        for n in range(starts[v], starts[v + 1]):
            far = around[n, 0]
            vertex[size], corner[size] = v, n
            if previous_of[far] != v and found[far] < MOST_ALIKE:
                found[far] += 1
                size += 1
    return vertex[:size].copy(), corner[:size].copy()


@kernel
def _sharp(vertices: Floats, starts: Offsets, around: Indices, least_cosine: float) -> tuple[Indices, Indices]:
    """Sides (start vertex, ring corner) where the surface bends, each edge once, from its end of lower index."""
    vertex = np.empty(len(around), dtype=np.uint32)
    corner = np.empty(len(around), dtype=np.uint32)
    # For each neighbour, the last corner from which a side leaves to it, and at which one arrives from it. Entries of
    # other rings lie before the current one's begin. And how many sides of this ring there are to it.
    leaving = np.full(len(starts), -1, dtype=np.int32)
    arriving = np.full(len(starts), -1, dtype=np.int32)
    done = np.full(len(starts), -1, dtype=np.int32)
    sides = np.zeros(len(starts), dtype=np.int32)
    size = 0
    for v in range(len(starts) - 1):
        begin, end = starts[v], starts[v + 1]
        for n in range(begin, end):
            leaving[around[n, 0]] = n
            arriving[around[n, 1]] = n
            sides[around[n, 0]] += 1
            sides[around[n, 1]] += 1
        for n in range(begin, end):
            # The side to the next vertex; and that from the previous one, if it isn't the twin of every leaving side.
            following, previous = around[n, 0], around[n, 1]
            for far, a, b in ((following, n, arriving[following]), (previous, leaving[previous], n)):
                extra = far == following or arriving[far] != n
                if far <= v or not extra or done[far] == v or min(a, b) < begin:
                    continue
                if around[a, 1] == around[b, 0] and sides[far] > 2:
                    continue  # a face and its copy turned over bend nowhere but at the sheet's border
                if _cosine_between(vertices, v, far, around[a, 1], around[b, 0]) < least_cosine:
                    vertex[size], corner[size], done[far] = v, a, v
                    size += 1
        for n in range(begin, end):
            sides[around[n, 0]] = sides[around[n, 1]] = 0
    return vertex[:size].copy(), corner[:size].copy()


@kernel
def _sides_between(around: Indices, begin: int, end: int, far: int) -> int:
    """How many sides run between the vertex of ring corners [begin, end) and `far`."""
    count = 0
    for n in range(begin, end):
        count += int(around[n, 0] == far) + int(around[n, 1] == far)
    return count


@kernel
def _cosine_between(vertices: Floats, v: int, far: int, left: int, right: int) -> float:
    """Cosine of the angle between the normals of faces (v, far, left) and (v, right, far); 1 if one is degenerate."""
    a, flat_a = sides_of(vertices, v, far, left)
    b, flat_b = sides_of(vertices, v, right, far)
    if flat_a or flat_b:
        return 1.0
    dot = a[9] * b[9] + a[10] * b[10] + a[11] * b[11]
    return float(dot / math.sqrt((a[9] ** 2 + a[10] ** 2 + a[11] ** 2) * (b[9] ** 2 + b[10] ** 2 + b[11] ** 2)))


@kernel
def _bent_to(ends: Ints, vertices: Floats, starts: Offsets, around: Indices, viewpoint: Floats, angle: float) -> Mask:
    """(n,) which edges have two faces at most, or bend by more than `angle` between the faces beside the eye's room."""
    kept = np.ones(len(ends), dtype=np.bool_)
    for e in range(len(ends)):
        i, j = ends[e, 0], ends[e, 1]
        if starts[j + 1] - starts[j] < starts[i + 1] - starts[i]:
            i, j = j, i  # a hub's ring is walked for no spoke
        if _sides_between(around, starts[i], starts[i + 1], j) <= 2:
            continue
        axis = vertices[j] - vertices[i]
        x, y, z = toward(viewpoint, vertices[i, 0], vertices[i, 1], vertices[i, 2])
        sight = np.array([x, y, z])
        axis /= max(math.sqrt(np.sum(axis * axis)), 1e-300)
        sight -= np.sum(sight * axis) * axis
        # Angles around the edge, from the eye's direction on: the room ends at the first face and at the last one.
        first, last = 2 * math.pi, 0.0
        for n in range(starts[i], starts[i + 1]):
            for far, third in ((around[n, 0], around[n, 1]), (around[n, 1], around[n, 0])):
                if far != j:
                    continue
                away = vertices[third] - vertices[i]
                away -= np.sum(away * axis) * axis
                turn = math.atan2(np.sum(np.cross(sight, away) * axis), np.sum(sight * away)) % (2 * math.pi)
                first, last = min(first, turn), max(last, turn)
        kept[e] = abs(first + 2 * math.pi - last - math.pi) > angle
    return kept
