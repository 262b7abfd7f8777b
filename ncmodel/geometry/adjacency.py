"""Which faces meet at each vertex, and the neighbours along their sides."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ncmodel.geometry.normals_areas import Indices, check_columns
from ncmodel.jit import kernel

Offsets = NDArray[np.int32]
"""Where the rows of each vertex start in a list."""


class Rings(NamedTuple):
    """The corners that meet at each vertex, in face order: those of vertex v are `starts[v] : starts[v + 1]`.

    Attributes:
        starts: (V + 1,).
        around: (3 F, 2) the next and the previous vertex of the corner's face.
        face: (3 F,) the corner's face.
    """

    starts: Offsets
    around: Indices
    face: Indices


def rings_of(faces: Indices, vertex_count: int) -> Rings:
    """Gather the corners of faces (F, 3) by vertex."""
    return Rings(*_gathered(faces, vertex_count))


@kernel
def _gathered(faces: Indices, vertex_count: int) -> tuple[Offsets, Indices, Indices]:
    check_columns(faces, 3)
    starts = np.zeros(vertex_count + 1, dtype=np.int32)
    for f in range(len(faces)):
        for c in range(3):
            starts[faces[f, c] + 1] += 1
    for v in range(vertex_count):
        starts[v + 1] += starts[v]
    around = np.empty((3 * len(faces), 2), dtype=np.uint32)
    face = np.empty(3 * len(faces), dtype=np.uint32)
    place = starts[:-1].copy()
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        for v, following, previous in ((i, j, k), (j, k, i), (k, i, j)):
            n = place[v]
            around[n, 0], around[n, 1], face[n] = following, previous, f
            place[v] = n + 1
    return starts, around, face
