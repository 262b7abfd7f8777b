"""What is wrong with a mesh, counted: the same measures before and after its repair."""

from dataclasses import dataclass

import numpy as np

from dataset_tools.cleaning.half_edges import fans_of, half_edges, plain_pairs
from dataset_tools.cleaning.stitching import touching_vertices
from ncmodel.geometry.adjacency import components
from ncmodel.mesh.weld import coincident, merged
from ncmodel.types import Floats, Ints, Mask

DEGENERATE = 1e-7
"""Faces lower than this, in units of the longest side, have no direction: it is the rounding of single precision."""


@dataclass(frozen=True)
class Faults:
    """Counts of what keeps a mesh from being a surface that faces outwards.

    Attributes:
        vertices: All of them.
        faces: All of them.
        unusable_vertices: Coordinates that aren't numbers, or are absurdly far from all others.
        unused_vertices: No face uses them.
        coincident_vertices: Vertices so close to an earlier one that they are taken for the same.
        degenerate_faces: Faces with repeated corners, or no higher than `DEGENERATE`.
        repeated_faces: Faces with the corners of an earlier one, in any order.
        border_edges: Edges with one face.
        touching_vertices: Border vertices that lie on a border edge without belonging to it.
        non_manifold_edges: Edges with more than two faces.
        non_manifold_vertices: Vertices whose faces form more than one fan.
        inconsistent_edges: Edges whose two faces run along them in the same direction.
        components: Parts connected through shared vertices.
    """

    vertices: int
    faces: int
    unusable_vertices: int
    unused_vertices: int
    coincident_vertices: int
    degenerate_faces: int
    repeated_faces: int
    border_edges: int
    touching_vertices: int
    non_manifold_edges: int
    non_manifold_vertices: int
    inconsistent_edges: int
    components: int


def diagnose(
    vertices: Floats, faces: Ints, weld: float, snap: float, unusable_vertices: int = 0, by_index: bool = False
) -> Faults:
    """Count the faults of a mesh.

    Everything about edges is counted as if vertices at exactly equal positions were one, since formats that can't share
    vertices (STL) would otherwise show nothing but borders; with `by_index`, only the same vertex is the same.

    Args:
        vertices: (V, 3) finite.
        faces: (F, 3), at least one.
        weld: See `CleanSettings`.
        snap: See `CleanSettings`.
        unusable_vertices: Vertices already left out.
        by_index: Vertices that coincide were left apart on purpose.
    """
    points, triangles = (vertices, faces) if by_index else merged(vertices, faces, coincident(vertices))
    sides = half_edges(triangles)
    pairs = plain_pairs(sides)
    fan_vertex, _ = fans_of(triangles, sides, pairs)
    fans = np.bincount(fan_vertex, minlength=len(points))
    return Faults(
        vertices=len(vertices) + unusable_vertices,
        faces=len(faces),
        unusable_vertices=unusable_vertices,
        unused_vertices=len(vertices) - len(np.unique(faces)),
        coincident_vertices=0 if by_index else _repeats(coincident(vertices, weld)),
        degenerate_faces=int(sliver_faces(points, triangles).sum()),
        repeated_faces=len(triangles) - len(np.unique(np.sort(triangles, axis=1), axis=0)),
        border_edges=int((sides.count == 1).sum()),
        touching_vertices=touching_vertices(points, triangles, snap),
        non_manifold_edges=int((sides.count > 2).sum()),
        non_manifold_vertices=int((fans > 1).sum()),
        inconsistent_edges=int((sides.forward[pairs.first] == sides.forward[pairs.second]).sum()),
        components=len(np.unique(components(triangles, len(points))[triangles[:, 0]])),
    )


def sliver_faces(vertices: Floats, faces: Ints) -> Mask:
    """(F,) faces with a repeated corner, or whose smallest height is at most `DEGENERATE`."""
    corners = vertices[faces]
    edges = np.roll(corners, -1, axis=1) - corners
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    doubled_area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return np.asarray(doubled_area <= DEGENERATE * longest)


def _repeats(same: Ints) -> int:
    """How many points are one with an earlier one."""
    return int((same != np.arange(len(same))).sum())
