"""Seams sewn: borders that lie on each other, so that the surface falls apart only in the file.

A vertex on a texture's seam, or between two smoothing groups, is stored once for each side; solids cut by others have
vertices on the edges of their neighbours (T-junctions); patches of CAD exports and tiles of terrain follow the same
curve in steps of their own. Each would be drawn as a border, and no contour would cross it. Only borders are sewn, so
closed shells that touch stay two.
"""

import math
from dataclasses import replace

import numpy as np

from ncmodel.geometry.adjacency import Rings
from ncmodel.jit import kernel
from ncmodel.lines.edges import Edges
from ncmodel.mesh.stitching import MAX_PASSES, SHARE_OF_EDGE, split_faces, touching
from ncmodel.mesh.weld import ROUNDING, coincident, merged
from ncmodel.scene.surface import Surface
from ncmodel.tracing import timed
from ncmodel.types import Floats, Ints, Mask, Mesh

SNAP = 2e-4
"""Of the mesh's size: borders closer than this are one line in any drawing, where it is a sixth of a pixel."""

SAGS = 2.0
"""Two borders that follow a curve part by its sag over an edge; as it is estimated from the turns, this many times."""

SHARPEST = math.radians(50.0)
"""A border that turns by more than this has a corner there, and isn't part of a curve."""

STRAY = 0.25
"""Of an edge's length: as far a finer border may stray from it that leads from one of its ends to the other."""

LARGEST_SAG = 0.012
"""Of the mesh's size: borders farther apart than this are two."""


def sew_seams(surface: Surface) -> Surface:
    """The surface with borders that lie on each other connected; `surface` itself if there are none.

    Vertices on borders are merged where they are equal, or nearer to each other than the rounding, `SNAP` and the sag
    of the borders' curves explain; border edges that pass through another border's vertex are split there.
    """
    if surface.is_closed:
        return surface
    boundary = surface.boundary_edges
    with timed(surface.trace, "sewn"):
        mesh = _stitched(surface, boundary)
    return surface if mesh is surface.mesh else Surface(mesh, surface.trace, surface.sizing)


def _stitched(surface: Surface, boundary: Edges) -> Mesh:
    """The surface's mesh with borders connected that touch; the mesh itself if there are none."""
    mesh, notes = surface.mesh, []
    vertices, faces = mesh.vertices, mesh.faces
    meeting = np.zeros(len(vertices), dtype=bool)  # vertices where two borders met

    same = coincident(vertices, among=np.unique(boundary.ends))
    equal = _count(same)
    if equal:
        vertices, faces, meeting = _merge(vertices, faces, meeting, same)
        notes.append(f"sewed seams: {equal} vertices merged with others on borders at equal positions")
        surface = Surface(Mesh(vertices, faces))
    size = max(float(np.ptp(column)) for column in vertices.T)
    near = split = 0
    curves = False  # what touches goes first: only what is left may be as far apart as a curve's sag
    for _ in range(MAX_PASSES):
        if surface.is_closed:
            break
        border = _open_edges(surface.boundary_edges)
        meeting |= np.bincount(border.ends[:, 0], minlength=len(vertices)) > 1
        reach = _reaches(vertices, border.ends, meeting, size, curves)
        same = _near(vertices, surface.rings, border.ends, reach, ROUNDING * size)
        count = _count(same)
        if count:
            vertices, faces, meeting = _merge(vertices, faces, meeting, same)
            faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
            near += count
            if len(faces) == 0:
                return mesh  # all of it lies within what is taken for one line
        else:
            margin = np.full(len(border), ROUNDING * size)  # what is near an end was merged with it
            touches = touching(vertices, faces, border.ends, border.face, reach, margin)
            if len(touches):
                meeting[touches[:, 1]] = True
                split -= len(faces)
                faces = split_faces(vertices, faces, border.ends, border.face, touches)
                split += len(faces)
            elif curves:
                break
            else:
                curves = True
                continue
        surface = Surface(Mesh(vertices, faces))
    if near:
        notes.append(f"sewed seams: {near} vertices merged with others close by on borders")
    if split:
        notes.append(f"sewed seams: border edges split at {split} vertices that touch them")
    return replace(mesh, vertices=vertices, faces=faces, notes=(*mesh.notes, *notes)) if notes else mesh


def _merge(vertices: Floats, faces: Ints, meeting: Mask, same: Ints) -> tuple[Floats, Ints, Mask]:
    """Vertices merged; borders meet where they are."""
    meeting[same[same != np.arange(len(same))]] = True
    kept = same == np.arange(len(same))
    return *merged(vertices, faces, same), meeting[kept]


def _count(same: Ints) -> int:
    """How many vertices are one with an earlier one."""
    return int((same != np.arange(len(same))).sum())


def _open_edges(boundary: Edges) -> Edges:
    """Boundary edges with no other face: not those between faces that are wound differently."""
    low, high = boundary.ends.min(axis=1), boundary.ends.max(axis=1)
    _, place, count = np.unique(low << 32 | high, return_inverse=True, return_counts=True)
    alone = count[place] == 1
    return Edges(boundary.ends[alone], boundary.face[alone])


def _reaches(vertices: Floats, ends: Ints, meeting: Mask, size: float, curves: bool) -> Floats:
    """(n,) how far from each border edge another border is taken for the same line, or the same of its `curves`."""
    along = vertices[ends[:, 1]] - vertices[ends[:, 0]]
    length = np.linalg.norm(along, axis=1)
    within = np.minimum(SNAP * size, SHARE_OF_EDGE * length)
    if not curves:
        return np.asarray(within)
    order = np.argsort(ends[:, 0], kind="stable")
    starts = ends[order, 0]
    turn = _turns(along / np.maximum(length, 1e-300)[:, None], ends, order, starts)
    sag = np.minimum(SAGS * length * np.tan(turn / 4.0) / 2.0, LARGEST_SAG * size)
    return np.asarray(np.maximum(np.maximum(within, sag), _spanned(vertices, ends, meeting, order, starts)))


def _near(vertices: Floats, rings: Rings, ends: Ints, reach: Floats, least: float) -> Ints:
    """(V,) for each vertex the first border vertex that it is one with."""
    border = np.unique(ends)
    within = np.zeros(len(vertices))
    np.maximum.at(within, ends, reach[:, None])
    shortest = _shortest_edges(vertices, rings, border, least)
    within[border] = np.maximum(np.minimum(within[border], SHARE_OF_EDGE * shortest), least)
    return coincident(vertices, within, among=border)


@kernel
def _turns(directions: Floats, ends: Ints, order: Ints, starts: Ints) -> Floats:
    """(n,) the larger of the turns at an edge's ends, each to the edge that goes on the straightest; in radians.

    A turn by more than `SHARPEST` is a corner and says nothing of the curve.

    Args:
        directions: (n, 3) unit vectors of the edges.
        ends: (n, 2) their vertices.
        order: (n,) the edges by their first vertex.
        starts: (n,) that vertex, in that order.
    """
    closest = np.full((len(ends), 2), -1.0)  # cosines: at the edge's start, at its end
    for e in range(len(ends)):
        n = np.searchsorted(starts, ends[e, 1])
        while n < len(starts) and starts[n] == ends[e, 1]:
            following = order[n]
            cosine = min(1.0, (directions[e] * directions[following]).sum())
            closest[e, 1] = max(closest[e, 1], cosine)
            closest[following, 0] = max(closest[following, 0], cosine)
            n += 1
    turns = np.zeros(len(ends))
    for e in range(len(ends)):
        for k in range(2):
            turn = math.acos(closest[e, k])
            if turn <= SHARPEST:
                turns[e] = max(turns[e], turn)
    return turns


@kernel
def _spanned(vertices: Floats, ends: Ints, meeting: Mask, order: Ints, starts: Ints) -> Floats:
    """(n,) how far other borders stray from the edges that they lead back along, from end to end; 0 where none does.

    At both ends two borders must have met: so a slit or a mouth, which is one border, isn't closed.
    """
    strays = np.zeros(len(ends))
    for e in range(len(ends)):
        a, b = ends[e]
        if not (meeting[a] and meeting[b]):
            continue
        axis = vertices[b] - vertices[a]
        square = (axis * axis).sum()
        at, place, stray = b, 1.0, 0.0
        while at != a and at >= 0:
            n, here, before = np.searchsorted(starts, at), at, place
            at, least = -1, STRAY**2 * square
            while n < len(starts) and starts[n] == here:
                following = ends[order[n], 1]
                away = vertices[following] - vertices[a]
                s = (away * axis).sum() / square
                off = away - s * axis
                if s < before and (s > 0.0 or following == a) and (off * off).sum() <= least:
                    at, place, least = following, s, (off * off).sum()
                n += 1
            stray = max(stray, least)
        if at == a:
            strays[e] = math.sqrt(stray) * (1.0 + 1e-9)
    return strays


@kernel
def _shortest_edges(vertices: Floats, rings: Rings, some: Ints, least: float) -> Floats:
    """(n,) length of the shortest edge at each of some vertices that is longer than `least`; infinite if none is."""
    shortest = np.full(len(some), np.inf)
    for i in range(len(some)):
        v = some[i]
        for n in range(rings.starts[v], rings.starts[v + 1]):
            for k in range(2):
                away = vertices[rings.around[n, k]] - vertices[v]
                length = math.sqrt((away * away).sum())
                if length > least:
                    shortest[i] = min(shortest[i], length)
    return shortest
