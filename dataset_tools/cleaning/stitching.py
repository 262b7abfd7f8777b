"""Borders that touch without sharing vertices, within a tolerance that is the same everywhere: found and connected.

Border vertices closer than the tolerance become one, and border edges that pass through another border vertex are split
there. Drawings sew seams likewise (`ncmodel.scene.seams`); there the tolerance follows the borders' curves.
"""

import numpy as np

from dataset_tools.cleaning.half_edges import half_edges
from ncmodel.mesh.stitching import MAX_PASSES, SHARE_OF_EDGE, split_faces, touching
from ncmodel.mesh.weld import coincident
from ncmodel.types import Floats, Ints


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
    before = len(faces)
    for _ in range(MAX_PASSES):
        ends, face, touches = _touches(vertices, faces, tolerance)
        if len(touches) == 0:
            break
        faces = split_faces(vertices, faces, ends, face, touches)
    return faces, len(faces) - before


def touching_vertices(vertices: Floats, faces: Ints, tolerance: float) -> int:
    """How often a border vertex lies on a border edge that doesn't end there."""
    return len(_touches(vertices, faces, tolerance)[2])


def _touches(vertices: Floats, faces: Ints, tolerance: float) -> tuple[Ints, Ints, Ints]:
    """The border edges (n, 2), the face of each, and which vertices touch which of them."""
    sides = half_edges(faces)
    ends = np.stack([sides.start, sides.end], axis=1)[sides.border]
    face = sides.face[sides.border]
    length = np.linalg.norm(vertices[ends[:, 1]] - vertices[ends[:, 0]], axis=1)
    reach = np.minimum(tolerance, SHARE_OF_EDGE * length)
    return ends, face, touching(vertices, faces, ends, face, reach, margin=reach)


def _shortest_edges(vertices: Floats, faces: Ints) -> Floats:
    """(V,) length of the shortest edge at each vertex, infinite for unused ones."""
    shortest = np.full(len(vertices), np.inf)
    for k in range(3):
        a, b = faces[:, k], faces[:, (k + 1) % 3]
        length = np.linalg.norm(vertices[a] - vertices[b], axis=1)
        np.minimum.at(shortest, a, length)
        np.minimum.at(shortest, b, length)
    return shortest
