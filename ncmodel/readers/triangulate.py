"""Polygons -> triangles."""

import numpy as np

from ncmodel.jit import kernel
from ncmodel.readers.content import NotAMeshError
from ncmodel.readers.corner_tree import CornerTree, corner_tree, corners_within, take_away, turn_of
from ncmodel.types import Floats, Ints

_ANY, _SPIKE, _TOUCHED, _EAR = 0, 1, 2, 3
"""What may be cut off a polygon, from the last resort to what is cut as long as there is one."""
_ROUNDING = 2.0**-51
"""Of coordinates up to 1: a point on a side of its polygon lies no farther aside than this."""
_LOOKS, _LOOKS_A_CORNER = 1 << 26, 1 << 11
"""At corners and boxes, for one polygon: more are needed only where hundreds of sides cross or lie on each other."""


def triangulate(vertices: Floats, corners: Ints, sizes: Ints) -> Ints:
    """(F, 3) the triangles of polygons, in their order; polygons of fewer than three corners are left out.

    Quads are split along their shorter diagonal, the other one if that lies outside; larger convex polygons into a fan;
    from the others, ears are cut. A polygon may touch itself, as one with a hole that a bridge joins to its outline.

    Args:
        vertices: (V, 3).
        corners: (n,) vertex indices, polygon after polygon.
        sizes: (m,) corners of each polygon.

    Raises:
        NotAMeshError: No polygon has three corners.
        ValueError: A corner isn't a vertex.
    """
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(vertices):
        raise ValueError(f"faces use vertices {corners.min()}..{corners.max()}, the mesh has {len(vertices)}")
    if (sizes == 3).all():
        return corners.reshape(-1, 3)
    if (sizes < 3).all():
        raise NotAMeshError(f"{len(sizes)} faces of fewer than three corners: lines or points")
    # Squares of huge or tiny coordinates would overflow or vanish.
    vertices = np.ascontiguousarray(vertices / (np.abs(vertices).max() or 1.0))
    return _triangles(vertices, np.ascontiguousarray(corners), np.ascontiguousarray(sizes))


@kernel
def _triangles(vertices: Floats, corners: Ints, sizes: Ints) -> Ints:
    """(F, 3) the triangles of all polygons."""
    faces = np.empty((np.maximum(sizes - 2, 0).sum(), 3), dtype=np.int64)
    start = place = 0
    for size in sizes:
        ring = corners[start : start + size]
        if size == 3:
            faces[place] = ring
        elif size == 4:
            _split(vertices, ring, faces[place : place + 2])
        elif size > 4:
            faces[place : place + size - 2] = _cut(vertices, ring)
        start += size
        place += max(size - 2, 0)
    return faces


@kernel
def _split(vertices: Floats, quad: Ints, faces: Ints) -> None:
    """Fill in the two triangles of a quad."""
    p0, p1, p2, p3 = vertices[quad[0]], vertices[quad[1]], vertices[quad[2]], vertices[quad[3]]
    first = int(_squared(p0, p2) > _squared(p1, p3))
    # The diagonal of an arrowhead may be the shorter one, and outside: one triangle is turned over.
    chosen = _agreement(p1, p2, p3, p0) if first else _agreement(p0, p1, p2, p3)
    if chosen < 0 and (_agreement(p0, p1, p2, p3) if first else _agreement(p1, p2, p3, p0)) > 0:
        first = 1 - first
    for n in range(3):
        faces[0, n] = quad[(first + n) % 4]
    faces[1, 0], faces[1, 1], faces[1, 2] = quad[first], quad[(first + 2) % 4], quad[(first + 3) % 4]


@kernel
def _squared(a: Floats, b: Floats) -> float:
    return float((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@kernel
def _agreement(a: Floats, b: Floats, c: Floats, d: Floats) -> float:
    """The product of the normals of the triangles abc and acd, negative where one is turned over."""
    total = 0.0
    for n in range(3):
        i, j = (n + 1) % 3, (n + 2) % 3
        u, v, w = b[i] - a[i], c[i] - a[i], d[i] - a[i]
        x, y, z = b[j] - a[j], c[j] - a[j], d[j] - a[j]
        total += (u * y - x * v) * (v * z - y * w)
    return total


@kernel
def _cut(vertices: Floats, ring: Ints) -> Ints:
    """(n - 2, 3) the triangles of a polygon of more than four corners."""
    count = len(ring)
    flat = _flattened(vertices, ring)
    for n in range(count):
        a, b, c = flat[n - 1], flat[n], flat[(n + 1) % count]
        ahead, aside = (b[0] - a[0]) * (c[1] - b[1]), (b[1] - a[1]) * (c[0] - b[0])
        # An outline that goes back the way it came turns neither way there.
        back = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) < 0
        if not (ahead > aside or (ahead == aside and not back)):
            return _cut_ears(flat, ring)
    faces = np.empty((count - 2, 3), dtype=np.int64)
    for n in range(count - 2):
        faces[n, 0], faces[n, 1], faces[n, 2] = ring[0], ring[n + 1], ring[n + 2]
    return faces


@kernel
def _cut_ears(flat: Floats, ring: Ints) -> Ints:
    """(n - 2, 3) triangles of a polygon (n, 2) on the plane: the first corner that sticks out is cut, and so on."""
    count = len(flat)
    after, before = (np.arange(count) + 1) % count, (np.arange(count) - 1) % count
    faces = np.empty((count - 2, 3), dtype=np.int64)
    slack = _ROUNDING * max(np.ptp(flat[:, 0]), np.ptp(flat[:, 1]))
    tree, looks = corner_tree(flat), np.zeros(1, np.int64)
    place, tried, cut, wanted, collapsed = 0, 0, 0, _EAR, False
    while cut < count - 2:
        if tried > count - cut:
            # Where nothing sticks out, as in polygons that touch or cross themselves, less will do.
            tried, wanted = 0, wanted - 1
        if looks[0] > _LOOKS + _LOOKS_A_CORNER * count:
            wanted = _ANY
        if collapsed or _may_be_cut(flat, before, after, place, wanted, slack, tree, looks):
            i, k = before[place], after[place]
            faces[cut, 0], faces[cut, 1], faces[cut, 2] = ring[i], ring[place], ring[k]
            cut += 1
            take_away(tree, place)
            after[i], before[k] = k, i
            tried, wanted = 0, _EAR
            # What is left of a part that hangs together with the rest in one point has no area.
            at_next = _has_collapsed(flat, before, after, k)
            collapsed = at_next or _has_collapsed(flat, before, after, i)
            place = k if at_next else i
        else:
            tried += 1
            place = after[place]
    return faces


@kernel
def _flattened(vertices: Floats, ring: Ints) -> Floats:
    """(n, 2) a polygon on the coordinate plane that shows it largest, counter-clockwise."""
    normal = np.zeros(3)
    origin = vertices[ring[0]]
    for n in range(len(ring)):
        p, q = vertices[ring[n]] - origin, vertices[ring[(n + 1) % len(ring)]] - origin
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            normal[k] += p[i] * q[j] - p[j] * q[i]
    axis = np.abs(normal).argmax()
    flat = np.empty((len(ring), 2))
    for n in range(len(ring)):
        p = vertices[ring[n]]
        flat[n, 0], flat[n, 1] = p[(axis + 1) % 3], p[(axis + 2) % 3] if normal[axis] >= 0 else -p[(axis + 2) % 3]
    return flat


@kernel
def _may_be_cut(
    flat: Floats, before: Ints, after: Ints, place: int, wanted: int, slack: float, tree: CornerTree, looks: Ints
) -> bool:
    """Whether the corner at `place` is what is wanted; adds to the number of `looks` that it takes.

    An ear sticks out, and no other corner that is left lies in its triangle, but at one of its three corners, where a
    bridge to a hole begins or ends. A touched one may have others on its sides, where no edge leads inside. A spike has
    no area.
    """
    i, k = before[place], after[place]
    a, b, c = flat[i], flat[place], flat[k]
    turn = turn_of(a, b, c)
    if wanted in (_ANY, _SPIKE):
        return wanted == _ANY or abs(turn) <= slack
    if not turn > 0:
        return False
    if wanted == _EAR:
        return not corners_within(tree, flat, a, b, c, slack, looks)
    n = k
    while n != i:
        looks[0] += 1
        if _leads_inside(a, b, c, flat[n], flat[after[n]], slack):
            return False
        n = after[n]
    return True


@kernel
def _has_collapsed(flat: Floats, before: Ints, after: Ints, place: int) -> bool:
    """Whether two of a corner and its neighbours are at one place."""
    a, b, c = flat[before[place]], flat[place], flat[after[place]]
    return _same(a, b) or _same(b, c) or _same(c, a)


@kernel
def _leads_inside(a: Floats, b: Floats, c: Floats, p: Floats, q: Floats, slack: float) -> bool:
    """Whether a part of the edge pq lies inside the triangle abc, not just on its sides."""
    first, last = 0.0, 1.0
    for u, v in ((a, b), (b, c), (c, a)):
        begin, end = turn_of(u, v, p), turn_of(u, v, q)
        if begin <= slack and end <= slack:
            return False
        if begin < 0:
            first = max(first, begin / (begin - end))
        elif end < 0:
            last = min(last, begin / (begin - end))
    return first < last


@kernel
def _same(a: Floats, b: Floats) -> bool:
    return bool(a[0] == b[0] and a[1] == b[1])
