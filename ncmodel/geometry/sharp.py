"""A surface parted at its creases, so that neither normals nor curvature are averaged across them.

On a cube with shared corners, interpolated normals make a ball of it: contours wander over its flat faces, and all
other lines with them. Parted at edges sharper than an angle, each side keeps its own normals and curvature, and lines
end at those edges. That suits drawings that show creases, too: where a part ends, the crease is the outline.
"""

import math

import numpy as np
from numba import njit

from ncmodel.geometry.areas import Indices, sides_of
from ncmodel.geometry.edges import Edges
from ncmodel.geometry.raycast import RayScene
from ncmodel.geometry.rings import Rings
from ncmodel.geometry.surface import CREASE_ANGLE, Surface
from ncmodel.geometry.union_find import root
from ncmodel.stages import timed
from ncmodel.types import Floats, Ints, Mask, Mesh


def parted(surface: Surface, angle_degrees: float) -> Surface:
    """The surface parted at edges sharper than `angle_degrees`; `surface` itself if it has none."""
    vertices, faces, normals = surface.mesh.vertices, surface.faces, surface.normals
    angle = math.radians(angle_degrees)
    with timed(surface.trace, "parted"):
        # The faces at such an edge can't both be within half the angle of the normal at its ends.
        suspects = np.flatnonzero(_strays(vertices, faces, normals, math.cos(angle / 2)))
    if len(suspects) == 0:
        return surface
    rings = surface.rings
    with timed(surface.trace, "parted"):
        new_faces, doubled = _part(vertices, faces, rings, suspects, math.cos(angle))
        return _Parted(surface, np.concatenate([vertices, vertices[doubled]]), new_faces)


class _Parted(Surface):
    """A surface with the vertices on creases doubled, one for each part that meets there; otherwise the `whole` one."""

    def __init__(self, whole: Surface, vertices: Floats, faces: Indices) -> None:
        mesh = Mesh(vertices, faces.astype(np.int64), whole.mesh.name, whole.mesh.notes)
        super().__init__(mesh, whole.trace)
        self.whole = whole

    @property
    def is_closed(self) -> bool:
        return self.whole.is_closed

    @property
    def boundary_edges(self) -> Edges:
        return self.whole.boundary_edges

    @property
    def scene(self) -> RayScene:
        return self.whole.scene

    def creases(self, angle_degrees: float = CREASE_ANGLE) -> Edges:
        return self.whole.creases(angle_degrees)


@njit(cache=True, nogil=True, error_model="numpy")
def _strays(vertices: Floats, faces: Indices, normals: Floats, least_cosine: float) -> Mask:
    """(V,) True where a face's normal is off the vertex normal by more than the angle of that cosine."""
    found = np.zeros(len(vertices), dtype=np.bool_)
    for f in range(len(faces)):
        (x, y, z), flat = _flat_normal(vertices, faces, f)
        if flat:
            continue
        for c in range(3):
            v = faces[f, c]
            found[v] |= x * normals[v, 0] + y * normals[v, 1] + z * normals[v, 2] < least_cosine
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _flat_normal(vertices: Floats, faces: Indices, f: int) -> tuple[tuple[float, float, float], bool]:
    """The unit normal of a face, and whether it is degenerate and has none."""
    sides, flat = sides_of(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
    length = 1.0 if flat else math.sqrt(sides[9] ** 2 + sides[10] ** 2 + sides[11] ** 2)
    return (sides[9] / length, sides[10] / length, sides[11] / length), flat


@njit(cache=True, nogil=True, error_model="numpy")
def _part(vertices: Floats, faces: Indices, rings: Rings, suspects: Ints, least_cosine: float) -> tuple[Indices, Ints]:
    """Part the corners around each of `suspects` into fans of faces joined by edges that aren't sharp.

    Faces that run along their edge in the same direction, as copies turned over do, aren't joined.

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
            n = arriving[around[m, 0]]
            while n >= 0:
                if _cosine(vertices, faces, face[m], face[n]) >= least_cosine:
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


@njit(cache=True, nogil=True, error_model="numpy")
def _cosine(vertices: Floats, faces: Indices, one: int, other: int) -> float:
    """Cosine of the angle between two faces' normals; -1 if one is degenerate."""
    (ax, ay, az), flat_a = _flat_normal(vertices, faces, one)
    (bx, by, bz), flat_b = _flat_normal(vertices, faces, other)
    return -1.0 if flat_a or flat_b else ax * bx + ay * by + az * bz


@njit(cache=True, nogil=True, error_model="numpy")
def _replace(faces: Indices, f: int, old: int, new: int) -> None:
    for c in range(3):
        if faces[f, c] == old:
            faces[f, c] = new
