"""Parts so far from the rest of a shape that the rest is drawn as a dot: nobody would guess it from the picture."""

import numpy as np

from ncmodel.geometry.normals_areas import Indices, check_columns, sides_of
from ncmodel.jit import kernel
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Ints, Mask

GAP = 0.5
"""Parts with an empty space between them, wider than this share of their common extent, are far from each other."""
SMALL = 0.25
"""What is left, if it measures less than this share of the whole, is drawn too small."""


def stray_parts(surface: Surface) -> tuple[str, ...]:
    """A note if a few parts far away make the rest small; none for most shapes."""
    shells, faces = surface.shells, surface.faces
    count = int(shells.max()) + 1 if len(shells) else 0
    if count < 2:
        return ()
    box, area = _measured(surface.mesh.vertices, faces, shells, count)
    near = _without_strays(box, area)
    share = _size(box[near]) / _size(box)
    if near.all() or share > SMALL:
        return ()
    some, far = int(np.count_nonzero(~near[shells])), int(np.count_nonzero(~near))
    return (
        f"{far} of {count} parts, {some} of {len(faces)} faces, far away: the rest measures {100 * share:.2g} % of the "
        "shape; take them out (`ncontours dataset clean` removes stray triangles)",
    )


def _without_strays(box: Floats, area: Floats) -> Mask:
    """(n,) True for the parts that are left when all beyond wide gaps are left out, the lesser side of each gap."""
    near = np.ones(len(box), dtype=np.bool_)
    while np.count_nonzero(near) > 1:
        index = np.flatnonzero(near)
        least, beyond = GAP * _size(box[index]), index[:0]
        for axis in range(3):
            order = index[np.argsort(box[index, axis], kind="stable")]
            gap = box[order[1:], axis] - np.maximum.accumulate(box[order, 3 + axis])[:-1]
            widest = int(np.argmax(gap))
            if gap[widest] > least:
                least, sides = float(gap[widest]), (order[: widest + 1], order[widest + 1 :])
                beyond = min(sides, key=lambda side: float(area[side].sum()))
        if len(beyond) == 0:
            break
        near[beyond] = False
    return near


def _size(box: Floats) -> float:
    """The longest side of the box around boxes (n, 6)."""
    return float((box[:, 3:].max(axis=0) - box[:, :3].min(axis=0)).max())


@kernel
def _measured(vertices: Floats, faces: Indices, shells: Ints, count: int) -> tuple[Floats, Floats]:
    """The box (n, 6) around each shell, lowest coordinates first, and its area."""
    check_columns(vertices, 3)
    check_columns(faces, 3)
    box, area = np.empty((count, 6)), np.zeros(count)
    box[:, :3], box[:, 3:] = np.inf, -np.inf
    for f in range(len(faces)):
        s = shells[f]
        sides, _ = sides_of(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
        area[s] += np.sqrt(sides[9] ** 2 + sides[10] ** 2 + sides[11] ** 2) / 2
        for c in range(3):
            for axis in range(3):
                box[s, axis] = min(box[s, axis], vertices[faces[f, c], axis])
                box[s, 3 + axis] = max(box[s, 3 + axis], vertices[faces[f, c], axis])
    return box, area
