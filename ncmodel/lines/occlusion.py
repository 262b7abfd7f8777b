"""What hides points of lines from the eye, decided by one ray each.

A point is hidden where its ray meets a face clearly before it, on either side of the face. Two kinds of faces are no
occluders:

* A face that contains the point. The point's distance to the face decides and not the depth along the ray, which
  explodes on faces seen at a grazing angle. Shells that touch or coincide are covered by the same rule. But a border
  whose own face lies behind such a face is that of an inner wall, and ends there unseen.
* A face of the same fold. Lines are found on the smooth surface that interpolated normals describe, but rays meet flat
  faces. Where that surface turns from the eye, about half of a contour lies on faces that look away and that their
  neighbours hide. Such a neighbour is near, by the size of the face, turned alike, and near the turn itself; and
  the point would be seen when moved a few pixels aside, past the outline that its line belongs to. Where the outline is
  farther, at the sharp rim of an ear or on a cone of few sides, `polygonal_outlines` draws it.

An edge of the mesh may run a fraction of a pixel inside the outline that it belongs to, behind the next face: it is
seen if it would be when moved that far to one of its sides.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ncmodel.camera import DEFAULT_SIZE, Camera
from ncmodel.geometry.normals_areas import Indices
from ncmodel.geometry.raycast import RayScene
from ncmodel.geometry.view_vectors import toward
from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mask

TOUCH = 1e-5
"""A point nearer to a face than this lies on it: in radii of the mesh, or in distances from an eye nearer than that."""
INWARDS = 4.0
"""Borders are looked at this many times as far within their own faces: where these end at the back of others, they are
then clearly behind them."""
ROUGHNESS = 2.0
"""A face is near a fold if it could look away after turning this many times as far as it is off the smooth normals."""
REACH = 3.0
"""Faces of the same fold are at most this many face sizes, along the line of sight, before the sample."""
SAME_WAY = 0.5
"""Faces of the same fold have normals with a cosine of at least this size; its sign tells how they are wound, and some
files hold every face twice, once for each side."""
GRACE_PIXELS = 0.75
"""A mesh edge that would be seen if it ran this far beside itself on the picture is part of an outline."""
FOLD_PIXELS = 3.0
"""So is a line whose own fold hides it, for this, in pixels of a picture whose shorter side is 768."""
GAP_REACH = 10.0
"""As `REACH`, for what is near enough to be roughness of the surface itself."""

HIDDEN, HIDDEN_NEARBY, SEEN, FOLDED, BEHIND = 0, 1, 2, 3, 4
_Vector = tuple[float, float, float]


class Smooth(NamedTuple):
    """A smooth surface: the scene's faces, with normals to interpolate.

    Attributes:
        vertices: (V, 3).
        faces: (F, 3) in the scene's order.
        normals: (V, 3).
    """

    vertices: Floats
    faces: Indices
    normals: Floats


class Occlusion:
    """Tells which points of lines are hidden.

    Args:
        lines: Lines in front of the camera.
        camera: Where they are seen from.
        scene: What hides them.
        smooth: As `visible_pieces` takes it.
    """

    def __init__(self, lines: LineSet, camera: Camera, scene: RayScene, smooth: Smooth | None) -> None:
        self.points, self.face, self.scene = lines.points, lines.face, scene
        self.camera, self.on_edges = camera, smooth is None
        pixels = GRACE_PIXELS if smooth is None else FOLD_PIXELS * min(camera.width, camera.height) / DEFAULT_SIZE
        self.grace = pixels / camera.focal_pixels
        self.surface = smooth or Smooth(scene.vertices, scene.faces, np.zeros((0, 3)))
        self.inwards = _inwards(lines, self.surface) if lines.family is LineFamily.BOUNDARIES else None
        self.reach = _fold_reach(self.face, self.surface, camera.viewpoint) if smooth else np.zeros(len(lines))

    def state(self, segment: Ints, at: Floats) -> NDArray[np.int8]:
        """(N,) hidden, hidden by something near, or seen, for the points `at` along segments."""
        share = at[:, None]
        points = self.points[segment, 0] * (1 - share) + self.points[segment, 1] * share
        rays = self.camera.rays_to(points)
        hits = self.scene.hits(*rays)
        distance = np.linalg.norm(rays.directions, axis=1)
        before, touch = distance - hits.distance, self._touch(distance)
        face, reach = self.face[segment], self.reach[segment]
        state = _judge(points, face, reach, hits.face, before, self.surface, self.camera.viewpoint, touch)
        if self.inwards is not None:
            middle = np.sign(0.5 - at)[:, None] * self.inwards[segment, 1]
            inner = points + (INWARDS * touch)[:, None] * (self.inwards[segment, 0] + middle)
            _, hit = self.scene.first_hit(*self.camera.rays_to(inner))
            state[_behind(points, face, hit, self.surface, self.camera.viewpoint, touch)] = BEHIND
        unseen = (state != SEEN) & (state != BEHIND)
        doubtful = np.flatnonzero(unseen if self.on_edges else state == FOLDED)
        free = self._beside_is_free(points[doubtful], segment[doubtful])
        state[doubtful[free]] = SEEN
        state[state == FOLDED] = HIDDEN_NEARBY
        state[state == BEHIND] = HIDDEN
        return state

    def _touch(self, distance: Floats) -> Floats:
        """(N,) how near to faces points at some distances from the eye lie on them."""
        return TOUCH * np.minimum(distance, self.scene.radius)

    def _beside_is_free(self, points: Floats, segment: Ints) -> Mask:
        """Whether nothing is met before points where they are moved a little to either side of their lines."""
        rays = self.camera.rays_to(points)
        distance = np.linalg.norm(rays.directions, axis=1)
        aside = np.cross(rays.directions, self.points[segment, 1] - self.points[segment, 0])
        reach = self.grace * self.camera.scale_distance(distance)
        aside *= (reach / np.maximum(np.linalg.norm(aside, axis=1), 1e-300))[:, None]
        near = distance - self._touch(distance)
        free = self.scene.first_hit(*rays.aside(aside))[0] >= near
        rest = np.flatnonzero(~free)
        free[rest] = self.scene.first_hit(*rays.aside(-aside).take(rest))[0] >= near[rest]
        return np.asarray(free)


@kernel
def _fold_reach(face: Ints, surface: Smooth, viewpoint: Floats) -> Floats:
    """(S,) how far before a line on each `face` its own fold may be met; 0 where there is none."""
    reach = np.zeros(len(face))
    for s in range(len(face)):
        if _near_fold(surface, face[s], viewpoint, ROUGHNESS):
            i, j, k = surface.faces[face[s], 0], surface.faces[face[s], 1], surface.faces[face[s], 2]
            a, b, c = _row(surface.vertices, i), _row(surface.vertices, j), _row(surface.vertices, k)
            flat, sight = _unit(_cross(_minus(b, a), _minus(c, a))), _unit(toward(viewpoint, *a))
            lean = _dot(flat, sight)
            along = _unit((sight[0] - lean * flat[0], sight[1] - lean * flat[1], sight[2] - lean * flat[2]))
            at_b, at_c = _dot(_minus(b, a), along), _dot(_minus(c, a), along)
            reach[s] = REACH * (max(0.0, at_b, at_c) - min(0.0, at_b, at_c))
    return reach


@kernel
def _near_fold(surface: Smooth, face: int, viewpoint: Floats, roughness: float) -> bool:
    """Whether the smooth surface may turn from the eye within a face or two.

    The flat face is off the smooth surface by the angles between its normal and its corners'. If the surface faces the
    eye, or turns from it, by more than a few of these, it doesn't.
    """
    vertices, faces, normals = surface
    i, j, k = faces[face, 0], faces[face, 1], faces[face, 2]
    a, b, c = _row(vertices, i), _row(vertices, j), _row(vertices, k)
    sight = _unit(toward(viewpoint, *a))
    lean = _dot(_unit(_cross(_minus(b, a), _minus(c, a))), sight)
    low, high, off = np.inf, -np.inf, 0.0
    for corner in (i, j, k):
        facing = _dot(_row(normals, corner), sight)
        low, high, off = min(low, facing), max(high, facing), max(off, abs(facing - lean))
    return bool(max(low, -high) <= roughness * off)


@kernel
def _judge(
    points: Floats,
    face: Ints,
    reach: Floats,
    hit: Ints,
    before: Floats,
    surface: Smooth,
    viewpoint: Floats,
    touch: Floats,
) -> NDArray[np.int8]:
    """States of (N, 3) points on faces, given which faces their rays hit and how far before them.

    Points hidden by their own fold are `FOLDED`.
    """
    vertices, faces, _ = surface
    state = np.full(len(points), SEEN, np.int8)
    for n in range(len(points)):
        if before[n] <= touch[n]:
            continue
        point = _row(points, n)
        i, j, k = faces[hit[n], 0], faces[hit[n], 1], faces[hit[n], 2]
        if _distance_to_triangle(point, _row(vertices, i), _row(vertices, j), _row(vertices, k)) <= touch[n]:
            continue
        if before[n] > reach[n]:
            state[n] = HIDDEN_NEARBY if before[n] <= reach[n] * GAP_REACH / REACH else HIDDEN
        elif _turned_alike(surface, face[n], hit[n]) and _near_fold(surface, hit[n], viewpoint, 2 * ROUGHNESS):
            state[n] = FOLDED
        else:
            state[n] = HIDDEN_NEARBY
    return state


def _inwards(lines: LineSet, surface: Smooth) -> Floats:
    """(S, 2, 3) unit vectors from borders into their own faces, and along them."""
    start, along = lines.points[:, 0], lines.points[:, 1] - lines.points[:, 0]
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    inner = surface.vertices[surface.faces[lines.face]].mean(axis=1) - start
    inner = inner - np.einsum("ij,ij->i", inner, along)[:, None] * along
    return np.stack([inner / np.maximum(np.linalg.norm(inner, axis=1, keepdims=True), 1e-300), along], axis=1)


@kernel
def _behind(points: Floats, face: Ints, hit: Ints, surface: Smooth, viewpoint: Floats, touch: Floats) -> Mask:
    """(N,) which points on borders of faces lie on another face hit before these, one apart from them, at its back."""
    vertices, faces, _ = surface
    found = np.zeros(len(points), np.bool_)
    for n in range(len(points)):
        if hit[n] < 0 or hit[n] == face[n]:
            continue
        i, j, k = faces[hit[n], 0], faces[hit[n], 1], faces[hit[n], 2]
        a = _row(vertices, i)
        across = _unit(_cross(_minus(_row(vertices, j), a), _minus(_row(vertices, k), a)))
        side = 1.0 if _dot(across, toward(viewpoint, *a)) > 0.0 else -1.0
        found[n] = abs(_dot(across, _minus(_row(points, n), a))) <= touch[n]
        lowest = 0.0
        for c in range(3):
            above = side * _dot(across, _minus(_row(vertices, faces[face[n], c]), a))
            found[n] &= (
                above <= touch[n] and faces[face[n], c] != i and faces[face[n], c] != j and faces[face[n], c] != k
            )
            lowest = min(lowest, above)
        found[n] &= lowest < -INWARDS * touch[n]
    return found


@kernel
def _turned_alike(surface: Smooth, one: int, other: int) -> bool:
    """Whether the mean normals at two faces' corners are within the angle allowed for faces of one fold."""
    normals = surface.normals
    ax, ay, az, bx, by, bz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        a, b = surface.faces[one, k], surface.faces[other, k]
        ax, ay, az = ax + normals[a, 0], ay + normals[a, 1], az + normals[a, 2]
        bx, by, bz = bx + normals[b, 0], by + normals[b, 1], bz + normals[b, 2]
    squares = (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz)
    return bool(abs(ax * bx + ay * by + az * bz) > SAME_WAY * math.sqrt(squares))


@kernel
def _distance_to_triangle(p: _Vector, a: _Vector, b: _Vector, c: _Vector) -> float:
    """Distance of a point to a triangle, which may be degenerate."""
    normal = _cross(_minus(b, a), _minus(c, a))
    length = math.sqrt(_dot(normal, normal))
    inside, nearest = length > 0.0, np.inf
    for start, stop in ((a, b), (b, c), (c, a)):
        side, way = _minus(stop, start), _minus(p, start)
        inside = inside and _dot(_cross(side, way), normal) >= 0.0
        along = min(max(_dot(way, side) / max(_dot(side, side), 1e-300), 0.0), 1.0)
        off = (way[0] - along * side[0], way[1] - along * side[1], way[2] - along * side[2])
        nearest = min(nearest, math.sqrt(_dot(off, off)))
    return abs(_dot(_minus(p, a), normal)) / length if inside else nearest


@kernel
def _row(rows: Floats, i: int) -> _Vector:
    return rows[i, 0], rows[i, 1], rows[i, 2]


@kernel
def _minus(a: _Vector, b: _Vector) -> _Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel
def _dot(a: _Vector, b: _Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def _cross(a: _Vector, b: _Vector) -> _Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def _unit(a: _Vector) -> _Vector:
    length = max(math.sqrt(_dot(a, a)), 1e-300)
    return a[0] / length, a[1] / length, a[2] / length
