"""A surface parted at its creases, so that neither normals nor curvature are averaged across them.

On a cube with shared corners, interpolated normals make a ball of it: contours wander over its flat faces, and all
other lines with them. Parted at edges sharper than an angle, each side keeps its own normals and curvature, and lines
end at those edges. That suits drawings that show creases, too: where a part ends, the crease is the outline.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from ncmodel.geometry.adjacency import Rings
from ncmodel.geometry.normals_areas import Indices, sides_of
from ncmodel.geometry.planar_regions import flat_faces
from ncmodel.geometry.raycast import RayScene
from ncmodel.geometry.view_vectors import view_vectors
from ncmodel.jit import kernel
from ncmodel.lines.chaining import chain, connected
from ncmodel.lines.edges import Edges
from ncmodel.lines.rounded_edges import LEAST_BEND, edge_keys, rounded_edges
from ncmodel.mesh.union_find import root
from ncmodel.scene.surface import CREASE_ANGLE, Surface
from ncmodel.tracing import stage, timed
from ncmodel.types import FILTERED_FAMILIES, Floats, Ints, LineSet, Mask

CREASE_EDGES = 16
CREASE_LENGTH = 0.05
"""Connected creases of fewer edges than `CREASE_EDGES`, and shorter than this share of the object, are roughness."""
STRONG = 1.5
"""Creases sharper than this times the least angle are strong."""
STRONG_SHARE = 0.25
RAGGED = math.radians(20.0)
"""Connected creases of which a smaller share is strong, and whose turns change by more than this from edge to edge (the
median), are bits of a rounded edge."""


@dataclass(frozen=True, eq=False)
class CreaseLines:
    """The lines along which a surface is bent.

    Attributes:
        sharp: Edges that bend by more than the crease angle.
        rounded: Edges in the middle of rounded edges of few faces, one along each.
        flanks: (n, 2) for each of those, the faces before and after the rounded edge.
        strips: All edges of rounded edges.
    """

    sharp: Edges
    rounded: Edges
    flanks: Ints
    strips: Edges

    def seen_from(self, viewpoint: Floats, vertices: Floats, faces: Indices) -> Edges:
        """The lines that are drawn: where one flank looks away, a rounded edge has an outline, which isn't its middle.

        Args:
            viewpoint: (4,) where from.
            vertices: (V, 3).
            faces: (F, 3).
        """
        corners = vertices[faces[self.flanks]]
        normals = np.cross(corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :])
        facing = np.einsum("ijk,ijk->ij", normals, view_vectors(viewpoint, corners[..., 0, :])) > 0.0
        return self.sharp.joined(self.rounded.take(facing[:, 0] == facing[:, 1]))


def split_at_creases(surface: Surface, angle_degrees: float) -> Surface:
    """The surface parted at its `crease_lines`, and at all edges of rounded ones; `surface` itself if it has none.

    It is made once for each angle. A surface that is parted already is parted anew, from the whole one.
    """
    if _is_parted_at(surface, angle_degrees):
        return surface
    surface = surface.whole
    if angle_degrees not in surface.parted:
        creases, rings, normals = crease_lines(surface, angle_degrees), surface.rings, surface.normals
        with timed(surface.trace, "parted"):
            surface.parted[angle_degrees] = _parted_at(surface, creases, angle_degrees, rings, normals)
    return surface.parted[angle_degrees]


def crease_lines(surface: Surface, angle_degrees: float) -> CreaseLines:
    """The creases that are lines and neither rough spots nor bits of a rounded edge; and a line along rounded edges.

    Where few triangles span a rounded edge, some of their sides happen to bend by more than the angle: fragments that
    zigzag along it and are hardly anywhere bent by much more. Edges of a form are bent sharply, or run evenly.
    """
    if isinstance(surface, _Parted) and _is_parted_at(surface, angle_degrees):
        return surface.parted_at
    surface = surface.whole
    vertices, rings, creases = surface.mesh.vertices, surface.rings, surface.creases(angle_degrees)
    strongest = surface.creases(min(STRONG * angle_degrees, 180.0))
    bends = surface.creases(min(math.degrees(LEAST_BEND), angle_degrees))
    with timed(surface.trace, "crease_lines"):
        if len(creases):
            creases = creases.take(_are_lines(vertices, creases, strongest))
        strips = rounded_edges(vertices, surface.faces, rings, bends, math.radians(angle_degrees))
        middle = np.flatnonzero(strips.middle)
        middle = middle[_are_rounded(vertices[strips.edges.ends[middle]])]
        part = np.flatnonzero(np.isin(strips.across, middle).any(axis=1))
        return CreaseLines(creases, strips.edges.take(middle), strips.flanks[middle], strips.edges.take(part))


def off_flats(lines: LineSet, surface: Surface) -> LineSet:
    """Lines without those of curvature that lie on flats, if the surface is parted: planes have no curvature."""
    if lines.family not in FILTERED_FAMILIES or not isinstance(surface, _Parted) or len(lines) == 0:
        return lines
    return lines.take(~surface.flat_faces[lines.face])


def _is_parted_at(surface: Surface, angle_degrees: float) -> bool:
    return isinstance(surface, _Parted) and surface.angle_degrees == angle_degrees


def _are_lines(vertices: Floats, creases: Edges, strongest: Edges) -> Mask:
    """(n,) which of the creases are lines, given those that are strong."""
    points = vertices[creases.ends]
    run = connected(points)
    length = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    total = np.bincount(run, length)
    strong = np.isin(edge_keys(creases.ends, len(vertices)), edge_keys(strongest.ends, len(vertices)))
    large = (np.bincount(run) >= CREASE_EDGES) | (total >= CREASE_LENGTH)
    sharp = np.bincount(run, length * strong) >= STRONG_SHARE * total
    return np.asarray((large & (sharp | (_raggedness(points, run) <= RAGGED)))[run])


def _are_rounded(points: Floats) -> Mask:
    """(n,) which of the middles (n, 2, 3) of strips are lines: what is short or zigzags is roughness."""
    if len(points) == 0:
        return np.zeros(0, dtype=np.bool_)
    run = connected(points)
    long = np.bincount(run, np.linalg.norm(points[:, 1] - points[:, 0], axis=1)) >= CREASE_LENGTH
    return np.asarray((long & (_raggedness(points, run) <= RAGGED))[run])


def _raggedness(points: Floats, run: Ints) -> Floats:
    """(R,) how much the turn from one segment to the next changes along lines, radians: the median of each run.

    Straight lines, circles and polygons of many corners have none; corners here and there don't count.

    Args:
        points: (S, 2, 3) segments.
        run: (S,) the run of each, from 0.
    """
    chains = chain(points)
    way = np.where(chains.flipped, -1.0, 1.0)[:, None] * (points[chains.segment, 1] - points[chains.segment, 0])
    axis = np.cross(way[:-1], way[1:])
    sine, cosine = np.linalg.norm(axis, axis=1), np.einsum("ij,ij->i", way[:-1], way[1:])
    turn = axis * (np.arctan2(sine, cosine) / np.maximum(sine, 1e-300))[:, None]
    change = np.linalg.norm(np.diff(turn, axis=0), axis=1)
    inner = np.ones(len(way), dtype=np.bool_)
    inner[chains.first[:-1]] = inner[chains.first[1:] - 1] = False
    change, run_of = change[inner[1:-1]], run[chains.segment[inner]]
    ordered = change[np.lexsort((change, run_of))]
    number = np.bincount(run_of, minlength=run.max() + 1)
    middle = np.cumsum(number) - number + (number - 1) // 2
    median = np.zeros(len(number))
    median[number > 0] = ordered[middle[number > 0]]
    return median


def _parted_at(surface: Surface, lines: CreaseLines, angle_degrees: float, rings: Rings, normals: Floats) -> Surface:
    """The surface parted at its creases sharper than the angle that are lines, and at the edges of rounded edges."""
    edges = lines.sharp.joined(lines.strips)
    vertices, faces = surface.mesh.vertices, surface.faces
    creases = np.unique(edge_keys(edges.ends, len(vertices)))
    # Where a sheet's two sides share vertices, their normals cancel, and some face looks away from what is left.
    suspects = np.union1d(edges.ends, np.flatnonzero(_strays(vertices, faces, normals)))
    new_faces, doubled = _part(vertices, faces, rings, suspects, creases)
    if len(doubled) == 0:
        return surface
    return _Parted(surface, np.concatenate([vertices, vertices[doubled]]), new_faces, lines, angle_degrees)


class _Parted(Surface):
    """A surface with the vertices on creases doubled, one for each part that meets there; otherwise the `whole` one."""

    def __init__(
        self, whole: Surface, vertices: Floats, faces: Indices, parted_at: CreaseLines, angle_degrees: float
    ) -> None:
        mesh = replace(whole.mesh, vertices=vertices, faces=faces.astype(np.int64))
        super().__init__(mesh, whole.trace, whole.sizing)
        self._whole, self.parted_at, self.angle_degrees = whole, parted_at, angle_degrees

    @property
    def whole(self) -> Surface:
        return self._whole

    @property
    def is_closed(self) -> bool:
        return self.whole.is_closed

    @property
    def boundary_edges(self) -> Edges:
        return self.whole.boundary_edges

    @property
    def scene(self) -> RayScene:
        return self.whole.scene

    @property
    def shells(self) -> Ints:
        return self.whole.shells

    @property
    def intersections(self) -> LineSet:
        return self.whole.intersections

    def creases(self, angle_degrees: float = CREASE_ANGLE) -> Edges:
        return self.whole.creases(angle_degrees)

    @stage
    def flat_faces(self) -> Mask:
        """(F,) which faces lie on flats."""
        return flat_faces(self.mesh.vertices, self.faces, self.rings)


@kernel
def _strays(vertices: Floats, faces: Indices, normals: Floats) -> Mask:
    """(V,) True where a face looks away from the vertex normal."""
    found = np.zeros(len(vertices), dtype=np.bool_)
    for f in range(len(faces)):
        sides, flat = sides_of(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
        for c in range(3):
            v = faces[f, c]
            off = sides[9] * normals[v, 0] + sides[10] * normals[v, 1] + sides[11] * normals[v, 2]
            found[v] |= off < 0.0 and not flat
    return found


@kernel
def _part(vertices: Floats, faces: Indices, rings: Rings, suspects: Ints, creases: Ints) -> tuple[Indices, Ints]:
    """Part the corners around each of the vertices `suspects` into fans of faces joined by edges that are no creases.

    Faces that run along their edge in the same direction, faces and their copies turned over, and degenerate faces
    aren't joined either.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        rings: The faces around each vertex.
        suspects: The vertices.
        creases: Edges, lower end * V + higher end, in ascending order.

    Returns:
        The faces with new vertices for all fans but the first of a vertex, and the vertex that each new one doubles.
    """
    starts, around, face = rings
    parted = faces.copy()
    source = [np.int64(0) for _ in range(0)]
    fan, link = np.arange(len(face)), np.full(len(face), -1)
    arriving = np.full(len(vertices), -1)
    for v in suspects:
        for m in range(starts[v], starts[v + 1]):
            link[m], arriving[around[m, 1]] = arriving[around[m, 1]], m
        for m in range(starts[v], starts[v + 1]):
            # Corners n whose face has the edge to m's next vertex in the opposite direction.
            far = around[m, 0]
            key = min(v, far) * len(vertices) + max(v, far)
            place = np.searchsorted(creases, key)
            smooth = place == len(creases) or creases[place] != key
            n = arriving[far]
            while n >= 0:
                copy = around[n, 0] == around[m, 1]
                if smooth and not (copy or _is_flat(vertices, faces, face[m]) or _is_flat(vertices, faces, face[n])):
                    a, b = root(fan, m), root(fan, n)
                    fan[max(a, b)] = min(a, b)
                n = link[n]
        for m in range(starts[v], starts[v + 1]):
            arriving[around[m, 1]] = -1
            first = root(fan, m)
            if first == m and m > starts[v]:
                source.append(np.int64(v))
                link[m] = len(vertices) + len(source) - 1
            if first > starts[v]:
                _replace(parted, face[m], v, link[first])
    return parted, np.array(source)


@kernel
def _is_flat(vertices: Floats, faces: Indices, f: int) -> bool:
    """Whether a face is degenerate."""
    return sides_of(vertices, faces[f, 0], faces[f, 1], faces[f, 2])[1]


@kernel
def _replace(faces: Indices, f: int, old: int, new: int) -> None:
    for c in range(3):
        if faces[f, c] == old:
            faces[f, c] = new
