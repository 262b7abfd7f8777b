"""Strokes that continue each other, or end just before another one, joined over small gaps.

A line is cut where a threshold takes away a little of it, where rounding hides a pixel or two, and where two families
hand it on to each other. Two ends continue each other if each lies on the way that the other goes; and only if nothing
is nearer to the eye between them, and lines that lie on the surface find it there. Outlines and edges end on others:
where one of them gave way to a line beside it, or an edge is rounded, the other ends before.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ncmodel.camera import Camera
from ncmodel.drawing.packed import Packed
from ncmodel.geometry.raycast import RayScene
from ncmodel.lines.line_ends import ahead_of, continuing, crossings, inside, matched
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, Floats, Ints, LineFamily, Mask, Stroke

TANGENT = 0.75
"""The direction of a stroke's end is that of this many gaps' lengths of it."""
TOUCHING = 0.1
"""Ends nearer than this share of the longest gap touch: the way between them has no direction. So do ends and lines."""
STEEP = 4.0
"""Between two ends, depth changes by at most this many times their distance across the line of sight."""
OFF = 0.01
"""What the surface may lie off the straight way between two ends, in radii of the mesh."""
BESIDE = 0.17
"""Share of the longest gap that it is from an outline to the background beside it, at most."""
_EDGES = frozenset(family.value for family in LineFamily if family not in FILTERED_FAMILIES)
"""Families whose lines end on others: what carries them is bent there, or ends."""
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
    one, other, cost = continuing(
        ends.point, ends.way, ends.length, np.argsort(ends.point[:, 0]), pixels, TOUCHING * pixels
    )
    if len(one) == 0:
        return tuple(strokes)
    on_surface = ~(ends.rim[one] | ends.rim[other])
    whole = _goes_on(ends.point[one], ends.point[other], on_surface, view.camera, view.surface.scene)
    one, other, cost = one[whole], other[whole], cost[whole]
    order = np.lexsort((other, one, cost))
    partner = matched(one[order], other[order], len(ends.point))
    return _linked(strokes, partner)


def _ends_of(strokes: Sequence[Stroke], pixels: float) -> _Ends:
    packed = Packed.of(strokes)
    last = packed.first[1:] - 1
    place = np.stack([packed.first[:-1], last], axis=1).ravel()
    point = np.column_stack([packed.points, packed.depth])[place]
    way = point[:, :2] - inside(packed.points, packed.steps, packed.first, TANGENT * pixels)
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)
    rim = np.array([stroke.family in _RIMS for stroke in strokes])
    return _Ends(point, way, np.repeat(packed.length, 2), np.repeat(rim, 2))


def meet(strokes: Sequence[Stroke], pixels: float, view: View) -> tuple[Stroke, ...]:
    """Strokes of which outlines and edges that end just before another one, or before a corner of both, reach it.

    Args:
        strokes: With their depths.
        pixels: The longest gap.
        view: What they lie on, and where they are seen from.
    """
    found = list(strokes)
    edges = [number for number, stroke in enumerate(strokes) if stroke.family in _EDGES and stroke.depth is not None]
    for corners in (True, False):
        if not edges:
            break
        some = [found[number] for number in edges]
        packed, ends = Packed.of(some), _ends_of(some, pixels)
        free = np.arange(2 * len(some))
        free = free[~packed.meet_another(free, TOUCHING * pixels, after=pixels)]
        if corners:
            end, target = _corners(ends, free, pixels)
        else:
            end, target = ahead_of(
                ends.point, ends.way, ends.length, free, packed.points, packed.depth, packed.first, pixels
            )
        reached = _reaches(ends, end, target, BESIDE * pixels, view)
        if corners:  # both ends go there, or none
            half = len(end) // 2
            reached = np.tile(reached[:half] & reached[half:], 2)
        for at, point in zip(end[reached].tolist(), target[reached], strict=True):
            number = edges[at // 2]
            found[number] = _extended(found[number], at % 2 == 1, point)
    return tuple(found)


def _corners(ends: _Ends, free: Ints, pixels: float) -> tuple[Ints, Floats]:
    """The ends that meet another one if both go straight on, and where: (n,) and (n, 3)."""
    one, other, place, cost = crossings(ends.point, ends.way, ends.length, free, pixels)
    order = np.argsort(cost, kind="stable")
    partner = matched(one[order], other[order], len(ends.point))
    chosen = partner[one] == other
    return np.concatenate([one[chosen], other[chosen]]), np.concatenate([place[chosen], place[chosen]])


def _reaches(ends: _Ends, chosen: Ints, target: Floats, beside: float, view: View) -> Mask:
    """(n,) whether ends of strokes go on to a point: along the outline, or on the surface, if they don't bound it."""
    if len(chosen) == 0:
        return np.zeros(0, dtype=np.bool_)
    start = ends.point[chosen]
    aside = ends.way[chosen][:, ::-1] * [-beside, beside]
    rim = view.beyond(start[:, :2] + aside) != view.beyond(start[:, :2] - aside)
    for share in (0.25, 0.5, 0.75):
        between = start[:, :2] + share * (target - start)[:, :2]
        rim &= ~(view.beyond(between + aside) & view.beyond(between - aside))
    goes_on = _goes_on(start, target, np.ones(len(chosen), dtype=np.bool_), view.camera, view.surface.scene)
    return np.asarray(rim | (goes_on & ~ends.rim[chosen]))


def _extended(stroke: Stroke, last: bool, point: Floats) -> Stroke:
    """A stroke that goes on from its first point, or its last one, to one more: pixels and depth."""
    assert stroke.depth is not None, "only lines on the mesh reach others"
    at, end = (len(stroke.points), -1) if last else (0, 0)
    return replace(
        stroke,
        points=np.insert(stroke.points, at, point[:2], axis=0),
        alpha=np.insert(stroke.alpha, at, stroke.alpha[end]),
        depth=np.insert(stroke.depth, at, point[2]),
    )


def _goes_on(first: Floats, second: Floats, on_surface: Mask, camera: Camera, scene: RayScene) -> Mask:
    """(n,) whether the surface goes on between two points: (n, 3) pixels and depth.

    Args:
        first: The points.
        second: The others.
        on_surface: (n,) whether it must be there; where it may end, it is enough that nothing is nearer.
        camera: Where it is seen from.
        scene: The surface.
    """
    across = np.linalg.norm(second[:, :2] - first[:, :2], axis=1)
    across = across * camera.scale_distance(first[:, 2]) / camera.focal_pixels
    allowed = STEEP * across + OFF * scene.radius
    goes_on = np.abs(second[:, 2] - first[:, 2]) <= allowed
    for share in (0.25, 0.5, 0.75):
        between = first + share * (second - first)
        rays = camera.rays(between[:, :2])
        distance, _ = scene.first_hit(*rays)
        depth = distance / np.linalg.norm(rays.directions, axis=1)
        goes_on &= depth >= between[:, 2] - allowed
        goes_on &= ~on_surface | (depth <= between[:, 2] + allowed)
    return np.asarray(goes_on)


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
