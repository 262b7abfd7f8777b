"""Strokes that continue each other, joined over small gaps where the surface goes on between them.

A line is cut where a threshold takes away a little of it, where rounding hides a pixel or two, and where two families
hand it on to each other. Two ends continue each other if each lies on the way that the other goes; and only if nothing
is nearer to the eye between them, and lines that lie on the surface find it there.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ncmodel.camera import Camera
from ncmodel.drawing.packed import Packed
from ncmodel.geometry.raycast import RayScene
from ncmodel.jit import kernel
from ncmodel.scene.view import View
from ncmodel.types import Floats, Ints, LineFamily, Mask, Stroke

TANGENT = 0.75
"""The direction of a stroke's end is that of this many gaps' lengths of it."""
STRAIGHT = 0.9
"""Least cosine between the ways of two ends, and between each and the gap."""
TOUCHING = 0.1
"""Ends nearer than this share of the longest gap touch: the way between them has no direction."""
STEEP = 4.0
"""Between two ends, depth changes by at most this many times their distance across the line of sight."""
OFF = 0.01
"""What the surface may lie off the straight way between two ends, in radii of the mesh."""
_RIMS = (LineFamily.CONTOURS.value, LineFamily.BOUNDARIES.value)
"""Families beside which the surface may end."""


@dataclass(frozen=True, eq=False)
class _Ends:
    """Both ends of strokes: end 2s is the first point of stroke s, end 2s + 1 its last one.

    Attributes:
        point: (2S, 3) pixels and depth.
        way: (2S, 2) direction in which the stroke would go on.
        length: (2S,) of the stroke, pixels.
        rim: (2S,) whether the surface may end beside the stroke.
    """

    point: Floats
    way: Floats
    length: Floats
    rim: Mask


def join(strokes: Sequence[Stroke], pixels: float, view: View) -> tuple[Stroke, ...]:
    """Strokes of which those that continue each other are one, or meet if they are of two families.

    Args:
        strokes: With their depths.
        pixels: The longest gap.
        view: What they lie on, and where they are seen from.
    """
    if not strokes:
        return ()
    ends = _ends_of(strokes, pixels)
    one, other, cost = _near(ends.point, ends.way, ends.length, np.argsort(ends.point[:, 0]), pixels, TOUCHING * pixels)
    if len(one) == 0:
        return tuple(strokes)
    whole = _goes_on(ends, one, other, view.camera, view.surface.scene)
    one, other, cost = one[whole], other[whole], cost[whole]
    order = np.lexsort((other, one, cost))
    partner = _matched(one[order], other[order], len(ends.point))
    return _linked(strokes, partner)


def _ends_of(strokes: Sequence[Stroke], pixels: float) -> _Ends:
    packed = Packed.of(strokes)
    last = packed.first[1:] - 1
    place = np.stack([packed.first[:-1], last], axis=1).ravel()
    point = np.column_stack([packed.points, packed.depth])[place]
    way = point[:, :2] - _inside(packed.points, packed.steps, packed.first, TANGENT * pixels)
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)
    rim = np.array([stroke.family in _RIMS for stroke in strokes])
    return _Ends(point, way, np.repeat(packed.length, 2), np.repeat(rim, 2))


@kernel
def _inside(points: Floats, steps: Floats, first: Ints, reach: float) -> Floats:
    """(2C, 2) the points that lie some pixels from both ends of each stroke, or at its other end."""
    found = np.empty((2 * (len(first) - 1), 2))
    for end in range(len(found)):
        begin, last = first[end // 2], first[end // 2 + 1] - 1
        at, inwards = (begin, 1) if end % 2 == 0 else (last, -1)
        left = reach
        for _ in range(last - begin - 1):
            step = steps[max(at, at + inwards)]
            if step >= left:
                break
            left -= step
            at += inwards
        share = min(left / max(steps[max(at, at + inwards)], 1e-12), 1.0)
        for axis in range(2):
            found[end, axis] = points[at, axis] + share * (points[at + inwards, axis] - points[at, axis])
    return found


@kernel
def _near(
    point: Floats, way: Floats, length: Floats, order: Ints, pixels: float, touching: float
) -> tuple[Ints, Ints, Floats]:
    """Pairs of ends that continue each other on the picture, and how far apart they are.

    Args:
        point: (E, 3) ends of strokes.
        way: (E, 2) where they go on.
        length: (E,) of their strokes.
        order: The ends from left to right.
        pixels: The longest gap; a stroke bridges none that is longer than itself.
        touching: Ends that are nearer have no way between them.
    """
    one, other, cost = [np.int64(0) for _ in range(0)], [np.int64(0) for _ in range(0)], [0.0 for _ in range(0)]
    for m in range(len(order)):
        i = order[m]
        for n in range(m + 1, len(order)):
            j = order[n]
            x, y = point[j, 0] - point[i, 0], point[j, 1] - point[i, 1]
            if x > pixels:
                break
            gap = np.hypot(x, y)
            if gap > pixels or gap > min(length[i], length[j]) / (2.0 if i // 2 == j // 2 else 1.0):
                continue
            if way[i, 0] * way[j, 0] + way[i, 1] * way[j, 1] > -STRAIGHT:
                continue
            if gap > touching:
                ahead = min(x * way[i, 0] + y * way[i, 1], -x * way[j, 0] - y * way[j, 1])
                if ahead < STRAIGHT * gap:
                    continue
            one.append(i)
            other.append(j)
            cost.append(gap)
    return np.array(one), np.array(other), np.array(cost)


def _goes_on(ends: _Ends, one: Ints, other: Ints, camera: Camera, scene: RayScene) -> Mask:
    """(n,) whether the surface goes on from one end to the other."""
    first, second = ends.point[one], ends.point[other]
    across = np.linalg.norm(second[:, :2] - first[:, :2], axis=1)
    across = across * camera.scale_distance(first[:, 2]) / camera.focal_pixels
    allowed = STEEP * across + OFF * scene.radius
    goes_on = np.abs(second[:, 2] - first[:, 2]) <= allowed
    on_surface = ~(ends.rim[one] | ends.rim[other])
    for share in (0.25, 0.5, 0.75):
        between = first + share * (second - first)
        rays = camera.rays(between[:, :2])
        distance, _ = scene.first_hit(*rays)
        depth = distance / np.linalg.norm(rays.directions, axis=1)
        goes_on &= depth >= between[:, 2] - allowed
        goes_on &= ~on_surface | (depth <= between[:, 2] + allowed)
    return np.asarray(goes_on)


@kernel
def _matched(one: Ints, other: Ints, count: int) -> Ints:
    """(count,) for each end the one it is joined to, or -1: pairs are taken in their order, each end once."""
    partner = np.full(count, -1)
    for k in range(len(one)):
        if partner[one[k]] < 0 and partner[other[k]] < 0:
            partner[one[k]], partner[other[k]] = other[k], one[k]
    return partner


def _linked(strokes: Sequence[Stroke], partner: Ints) -> tuple[Stroke, ...]:
    """Strokes joined at partners: into one in the first one's place, or by a way between two families."""
    family = [stroke.family for stroke in strokes]
    same = np.array([end < 0 or family[end // 2] == family[k // 2] for k, end in enumerate(partner.tolist())])
    link = np.where(same, partner, -1).tolist()
    meeting = np.where(same, -1, partner).tolist()
    done, joined = [False] * len(strokes), []
    # From free ends first: what is left then are loops.
    starts = [end for end in range(len(link)) if link[end] < 0] + list(range(0, len(link), 2))
    chains: dict[int, list[int]] = {}
    for start in starts:
        entry, chain = start, []
        while not done[entry // 2]:
            done[entry // 2] = True
            chain.append(entry)
            leaving = link[entry ^ 1]
            if leaving < 0:
                break
            entry = leaving
        if chain:
            chains[min(entry // 2 for entry in chain)] = chain
    for place in sorted(chains):
        chain = chains[place]
        parts = [_directed(strokes[entry // 2], entry % 2 == 1) for entry in chain]
        first, last = chain[0], chain[-1] ^ 1
        if link[first] >= 0:
            parts.append(_point(parts[0], 0))  # a loop
        # Where two families meet, the later one goes on to the other.
        if meeting[first] > first:
            parts.insert(0, _bridge(strokes, first, meeting[first]))
        if meeting[last] > last:
            parts.append(_bridge(strokes, last, meeting[last]))
        joined.append(parts[0] if len(parts) == 1 else _concatenated(strokes[place].family, parts))
    return tuple(joined)


def _directed(stroke: Stroke, backwards: bool) -> Stroke:
    return stroke.reversed() if backwards else stroke


def _point(stroke: Stroke, index: int) -> Stroke:
    """One point of a stroke."""
    part = slice(index, index + 1) if index >= 0 else slice(index, None)
    return Stroke(
        stroke.family, stroke.points[part], stroke.alpha[part], None if stroke.depth is None else stroke.depth[part]
    )


def _bridge(strokes: Sequence[Stroke], end: int, other: int) -> Stroke:
    """The point of another stroke to which one goes on from its end, in its own shade."""
    own, far = _point(strokes[end // 2], -(end % 2)), _point(strokes[other // 2], -(other % 2))
    return Stroke(own.family, far.points, own.alpha, far.depth)


def _concatenated(family: str, parts: Sequence[Stroke]) -> Stroke:
    depths = [part.depth for part in parts if part.depth is not None]
    return Stroke(
        family,
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.alpha for part in parts]),
        np.concatenate(depths) if len(depths) == len(parts) else None,
    )
