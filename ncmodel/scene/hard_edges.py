"""Whether a surface is one of hard edges, as machines and boxes are, or a sculpted one that happens to bend sharply.

On a scan or a coarse animal some sides of triangles bend by more than any angle that creases are told by, but so do, by
half of it, those around them: no person sees an edge there. An edge that was meant stands alone: what lies beside it is
flat, or bends far less.
"""

import math

import numpy as np

from ncmodel.geometry.straight_ways import Faces, bend_between, neighbour
from ncmodel.jit import kernel
from ncmodel.scene.surface import Surface
from ncmodel.tracing import timed
from ncmodel.types import Floats, Ints

STANDS_OUT = 4.0
"""A hard edge bends by more than this times what the other sides of its faces bend on average."""
HARD_SHARE = 0.9
"""Of the length of a surface's creases, at least so much is hard if it is a surface of hard edges. Real meshes of
machines, furniture and cars have 0.94 and more, scans and sculpted animals 0.87 and less."""


def has_hard_edges(surface: Surface, angle_degrees: float) -> bool:
    """Whether the surface has creases, and they are hard edges.

    Args:
        surface: The surface, parted or whole.
        angle_degrees: By which creases are told.
    """
    surface = surface.whole
    creases = surface.creases(angle_degrees)
    if len(creases) == 0:
        return False
    faces = Faces(surface.mesh.vertices, surface.faces, surface.rings)
    with timed(surface.trace, "hard_edges"):
        hard, length = _hard(faces, creases.ends, creases.face, math.radians(angle_degrees))
        return bool((length * hard).sum() >= HARD_SHARE * length.sum())


@kernel
def _hard(surface: Faces, ends: Ints, face: Ints, angle: float) -> tuple[Ints, Floats]:
    """(n,) 1 for creases that stand out of what is around them, else 0; and (n,) the lengths of those of two faces."""
    vertices = surface.vertices
    hard, length = np.zeros(len(ends), np.int64), np.zeros(len(ends))
    for e in range(len(ends)):
        i, j, f = ends[e, 0], ends[e, 1], face[e]
        g = neighbour(surface.rings, i, j, f)
        if g < 0:
            continue
        step = vertices[j] - vertices[i]
        length[e] = math.sqrt(np.sum(step * step))
        own, total, count = abs(bend_between(surface, i, j, f, g)), 0.0, 0
        for side in (f, g):
            for corner in range(3):
                a, b = surface.faces[side, corner], surface.faces[side, (corner + 1) % 3]
                beyond = neighbour(surface.rings, a, b, side)
                if beyond < 0 or beyond in (f, g):
                    continue
                bend = abs(bend_between(surface, a, b, side, beyond))
                if bend < angle:
                    total += bend
                    count += 1
        hard[e] = total * STANDS_OUT < own * max(count, 1)
    return hard, length
