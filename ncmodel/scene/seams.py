"""Seams sewn: borders that lie exactly on each other, where a file holds a vertex once for each of its textures.

A vertex on a texture's seam, or between two smoothing groups, is stored once for each side, and the surface falls apart
there: the seam would be drawn as a border, and no contour would cross it. Only vertices on borders are merged, so
closed shells that touch stay two.
"""

import numpy as np

from ncmodel.mesh.weld import coincident, merged
from ncmodel.scene.surface import Surface
from ncmodel.tracing import timed
from ncmodel.types import Mesh


def sew_seams(surface: Surface) -> Surface:
    """The surface with vertices on borders merged where their positions are equal; `surface` itself if none are."""
    if surface.is_closed:
        return surface
    borders = np.unique(surface.boundary_edges.ends)
    with timed(surface.trace, "sewn"):
        same = coincident(surface.mesh.vertices, among=borders)
        count = int((same != np.arange(len(same))).sum())
        if count == 0:
            return surface
        vertices, faces = merged(surface.mesh.vertices, surface.mesh.faces, same)
        note = f"sewed seams: {count} vertices merged with others on borders at equal positions"
        mesh = Mesh(vertices, faces, surface.mesh.name, (*surface.mesh.notes, note))
    return Surface(mesh, surface.trace, surface.sizing)
