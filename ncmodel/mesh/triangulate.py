"""Polygons -> triangles."""

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints


def triangulate(vertices: Floats, corners: Ints, sizes: Ints) -> Ints:
    """(F, 3) the triangles of polygons, in their order; polygons of fewer than three corners are left out.

    Quads are split along their shorter diagonal, larger convex polygons into a fan; from the others, ears are cut.

    Args:
        vertices: (V, 3).
        corners: (n,) vertex indices, polygon after polygon.
        sizes: (m,) corners of each polygon.

    Raises:
        ValueError: A corner isn't a vertex.
    """
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(vertices):
        raise ValueError(f"faces use vertices {corners.min()}..{corners.max()}, the mesh has {len(vertices)}")
    if (sizes == 3).all():
        return corners.reshape(-1, 3)
    # Squares of huge or tiny coordinates would overflow or vanish.
    vertices = vertices / (np.abs(vertices).max() or 1.0)
    starts = np.cumsum(sizes) - sizes
    counts = np.maximum(sizes - 2, 0)
    places = np.cumsum(counts) - counts
    faces = np.empty((int(counts.sum()), 3), dtype=np.int64)
    triangles = np.flatnonzero(sizes == 3)
    faces[places[triangles]] = corners[starts[triangles][:, None] + np.arange(3)]
    quads = np.flatnonzero(sizes == 4)
    if len(quads):
        halves = _split(vertices, corners[starts[quads][:, None] + np.arange(4)])
        faces[places[quads][:, None] + np.arange(2)] = halves
    for polygon in np.flatnonzero(sizes > 4):
        ring = corners[starts[polygon] : starts[polygon] + sizes[polygon]]
        faces[places[polygon] : places[polygon] + counts[polygon]] = ring[_ears(vertices[ring])]
    return faces


def _split(vertices: Floats, quads: Ints) -> Ints:
    """(n, 2, 3) the two triangles of each quad (n, 4)."""
    p = vertices[quads]
    other = np.square(p[:, 0] - p[:, 2]).sum(axis=1) > np.square(p[:, 1] - p[:, 3]).sum(axis=1)
    turned = np.where(other[:, None], np.roll(quads, -1, axis=1), quads)
    return np.stack([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]], axis=1)


def _ears(points: Floats) -> Ints:
    """(n - 2, 3) triangles of a polygon (n, 3), as indices of its corners."""
    count = len(points)
    fan = np.stack([np.zeros(count - 2, dtype=np.int64), np.arange(1, count - 1), np.arange(2, count)], axis=1)
    flat = _flattened(points)
    side = np.roll(flat, -1, axis=0) - flat
    last = np.roll(side, 1, axis=0)
    if (last[:, 0] * side[:, 1] >= last[:, 1] * side[:, 0]).all():
        return fan
    return _cut_ears(np.ascontiguousarray(flat))


@kernel
def _cut_ears(flat: Floats) -> Ints:
    """(n - 2, 3) triangles of a polygon (n, 2) on the plane: the first corner that sticks out is cut, and so on."""
    count = len(flat)
    after, before = (np.arange(count) + 1) % count, (np.arange(count) - 1) % count
    faces = np.empty((count - 2, 3), dtype=np.int64)
    place, tried, cut = 0, 0, 0
    while cut < count - 2:
        # Where nothing sticks out, as in polygons that cross themselves, any corner will do.
        if tried > count - cut or _is_ear(flat, before, after, place):
            faces[cut] = before[place], place, after[place]
            cut += 1
            after[before[place]], before[after[place]] = after[place], before[place]
            tried = 0
            place = before[place]
        else:
            tried += 1
            place = after[place]
    return faces


def _flattened(points: Floats) -> Floats:
    """(n, 2) a polygon on the coordinate plane that shows it largest, counter-clockwise."""
    following = np.roll(points, -1, axis=0)
    normal = np.cross(points - points[0], following - points[0]).sum(axis=0)
    axis = int(np.abs(normal).argmax())
    flat = points[:, [(axis + 1) % 3, (axis + 2) % 3]]
    return flat if normal[axis] >= 0 else flat * np.array([1.0, -1.0])


@kernel
def _is_ear(flat: Floats, before: Ints, after: Ints, place: int) -> bool:
    """Whether the corner at `place` sticks out and no other corner that is left lies in its triangle."""
    i, k = before[place], after[place]
    a, b, c = flat[i], flat[place], flat[k]
    if _turn(a, b, c) <= 0:
        return False
    n = after[k]
    while n != i:
        p = flat[n]
        if _turn(a, b, p) >= 0 and _turn(b, c, p) >= 0 and _turn(c, a, p) >= 0:
            return False
        n = after[n]
    return True


@kernel
def _turn(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the signed area of triangle abc, positive when counter-clockwise."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
