"""Hidden-line removal: the parts of lines that the eye sees, decided by rays.

Every segment is sampled about once a pixel along the picture, a ray is cast from the eye to each sample, and a change
between two samples is located to a quarter of a pixel. A sample is hidden where its ray meets a face clearly before it,
on either side of the face. Two kinds of faces are no occluders:

* A face that contains the sample. The sample's distance to the face decides and not the depth along the ray, which
  explodes on faces seen at a grazing angle. Shells that touch or coincide are covered by the same rule.
* A face of the same fold. Lines are found on the smooth surface that interpolated normals describe, but rays meet flat
  faces. Where that surface turns from the eye, about half of a contour lies on faces that look away and that their
  neighbours hide. Such a neighbour is near, by the size of the face, turned the same way, and near the turn itself.

An edge of the mesh may run a fraction of a pixel inside the outline that it belongs to, behind the next face: it is seen
if it would be when moved that far to one of its sides.

What is left of the faces' roughness is smoothed along the chained lines: a gap of few pixels that something near makes
is closed, and a speck of line in the middle of a hidden part is dropped.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ncmodel.camera import Camera
from ncmodel.geometry.areas import Indices
from ncmodel.geometry.raycast import RayScene
from ncmodel.geometry.strokes import Chains, chain
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mask

MESH_EDGES = (LineFamily.BOUNDARIES, LineFamily.CREASES)
"""Families that lie on the flat faces' own edges and not on the smooth surface."""

SAMPLE_PIXELS = 1.0
"""Distance of samples along the picture, unless told otherwise."""
HALVINGS = 2
"""Halvings of the interval between two samples in which visibility changes."""
FRAME_MARGIN = 8.0
"""Lines are kept this many pixels beyond the frame, so that wide strokes reach its edge."""
NEAR_PLANE = 1e-6
"""Lines nearer to the camera plane than this, in radii of the mesh, are cut off."""
TOUCH = 1e-5
"""A point nearer to a face than this, in radii of the mesh, lies on it."""
ROUGHNESS = 2.0
"""A face is near a fold if it could look away after turning this many times as far as it is off the smooth normals."""
REACH = 3.0
"""Faces of the same fold are at most this many face sizes, along the line of sight, before the sample."""
SAME_WAY = 0.5
"""Faces of the same fold have normals with a cosine above this."""
GRACE_PIXELS = 0.75
"""A mesh edge that would be seen if it ran this far beside itself on the picture is part of an outline."""
GAP_PIXELS = 3.0
"""Shorter gaps in a line are closed if what makes them is within `GAP_REACH` of it."""
GAP_REACH = 10.0
"""As `REACH`, for gaps."""
SPECK_PIXELS = 1.5
"""Shorter parts of a line between hidden ones are dropped."""

_HIDDEN, _HIDDEN_NEARBY, _SEEN = 0, 1, 2
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


def visible_pieces(
    lines: LineSet,
    camera: Camera,
    scene: RayScene,
    smooth: Smooth | None = None,
    sample_pixels: float = SAMPLE_PIXELS,
) -> LineSet:
    """The parts of lines that the camera sees: in front of it, in the frame, and before all faces.

    Args:
        lines: Lines on the scene's mesh.
        camera: Where they are seen from.
        scene: The mesh.
        smooth: The surface whose lines they are, for lines inside faces; boundaries and creases need none.
        sample_pixels: Distance along the picture of the points at which visibility is decided.

    Returns:
        Pieces of the lines, in their order.
    """
    start, end = _in_frame(lines.points, camera, NEAR_PLANE * scene.radius)
    framed = np.flatnonzero(start < end)
    lines = lines.between(framed, start[framed], end[framed])
    if len(lines) == 0:
        return lines
    samples = _sample(lines.points, camera, sample_pixels)
    occlusion = _Occlusion(lines, camera, scene, smooth)
    state = occlusion.state(samples.segment, samples.at)
    seen = _smooth(state, samples, chain(lines.points))
    return lines.between(*_seen_intervals(seen, samples, occlusion))


@dataclass(frozen=True, eq=False)
class _Samples:
    """Points on S segments, those of a segment in order; the first and last are its ends, unless it has only one.

    Attributes:
        segment: (N,) the segment of each sample.
        at: (N,) where along it, in 0..1.
        pixels: (N,) how much of the picture each sample stands for.
        first: (S + 1,) where the samples of each segment start.
    """

    segment: Ints
    at: Floats
    pixels: Floats
    first: Ints


class _Occlusion:
    """Tells which points of lines are hidden.

    Args:
        lines: Lines in front of the camera.
        camera: Where the eye is.
        scene: What hides them.
        smooth: As `visible_pieces` takes it.
    """

    def __init__(self, lines: LineSet, camera: Camera, scene: RayScene, smooth: Smooth | None) -> None:
        self.points, self.face, self.scene = lines.points, lines.face, scene
        self.eye, self.pixel = np.asarray(camera.eye, dtype=np.float64), 1.0 / camera.focal_pixels
        self.on_edges = smooth is None
        self.surface = smooth or Smooth(scene.vertices, scene.faces, np.zeros((0, 3)))
        self.reach = _fold_reach(self.face, self.surface, self.eye) if smooth else np.zeros(len(lines))

    def state(self, segment: Ints, at: Floats) -> NDArray[np.int8]:
        """(N,) hidden, hidden by something near, or seen, for the points `at` along segments."""
        share = at[:, None]
        points = self.points[segment, 0] * (1 - share) + self.points[segment, 1] * share
        hits = self.scene.hits(self.eye, points - self.eye)
        before = np.linalg.norm(points - self.eye, axis=1) - hits.distance
        touch = TOUCH * self.scene.radius
        state = _judge(
            points, self.face[segment], self.reach[segment], hits.face, before, self.surface, self.eye, touch
        )
        if self.on_edges:
            hidden = np.flatnonzero(state != _SEEN)
            state[hidden[self._beside_is_free(points[hidden], segment[hidden])]] = _SEEN
        return state

    def _beside_is_free(self, points: Floats, segment: Ints) -> Mask:
        """Whether nothing is met before points where they are moved a little to either side of their lines."""
        away = points - self.eye
        distance = np.linalg.norm(away, axis=1, keepdims=True)
        aside = np.cross(away, self.points[segment, 1] - self.points[segment, 0])
        aside *= self.pixel * GRACE_PIXELS * distance / np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-300)
        free = np.zeros(len(points), dtype=np.bool_)
        for side in (aside, -aside):
            free |= self.scene.first_hit(self.eye, away + side)[0] >= distance[:, 0] - TOUCH * self.scene.radius
        return free


def _in_frame(points: Floats, camera: Camera, near: float) -> tuple[Floats, Floats]:
    """(S,) start and end in 0..1 of the part of each segment in front of the camera and in the frame; else start > end.

    A point is inside if it is on the inner side of five planes through or before the eye (Liang and Barsky's clipping).
    """
    local = (points - np.asarray(camera.eye)) @ camera.rotation.T
    x, y, depth = camera.focal_pixels * local[..., 0], camera.focal_pixels * local[..., 1], -local[..., 2]
    right = (camera.width / 2 + FRAME_MARGIN) * depth
    top = (camera.height / 2 + FRAME_MARGIN) * depth
    start, end = np.zeros(len(points)), np.ones(len(points))
    for inside in (depth - near, right - x, right + x, top - y, top + y):
        first, last = inside[:, 0], inside[:, 1]
        crossing = first / np.where(first == last, 1.0, first - last)
        start = np.where(first < 0, np.where(last < 0, 2.0, np.maximum(start, crossing)), start)
        end = np.where((last < 0) & (first >= 0), np.minimum(end, crossing), end)
    return start, end


def _sample(points: Floats, camera: Camera, spacing: float) -> _Samples:
    """Samples at even steps on the picture."""
    projected = camera.project(points)
    length = np.linalg.norm(projected[:, 1, :2] - projected[:, 0, :2], axis=1)
    steps = np.ceil(length / spacing).astype(np.int64)
    # What is far below the spacing is decided as a whole, in its middle.
    count = np.where(length <= spacing / 2, 1, steps + 1)
    first = np.concatenate([[0], np.cumsum(count)])
    segment = np.repeat(np.arange(len(points)), count)
    share = (np.arange(first[-1]) - first[segment]) / np.maximum(count - 1, 1)[segment]
    share[count[segment] == 1] = 0.5
    # Even steps on the picture are uneven ones on the line, in perspective.
    near, far = projected[segment, 0, 2], projected[segment, 1, 2]
    at = share * near / (share * near + (1 - share) * far)
    return _Samples(segment, at, (length / count)[segment], first)


@njit(cache=True, nogil=True)
def _fold_reach(face: Ints, surface: Smooth, eye: Floats) -> Floats:
    """(S,) how far before a line on each `face` its own fold may be met; 0 where there is none."""
    reach = np.zeros(len(face))
    for s in range(len(face)):
        if _near_fold(surface, face[s], eye, ROUGHNESS):
            i, j, k = surface.faces[face[s], 0], surface.faces[face[s], 1], surface.faces[face[s], 2]
            a, b, c = _row(surface.vertices, i), _row(surface.vertices, j), _row(surface.vertices, k)
            flat, toward = _unit(_cross(_minus(b, a), _minus(c, a))), _unit(_minus((eye[0], eye[1], eye[2]), a))
            lean = _dot(flat, toward)
            along = _unit((toward[0] - lean * flat[0], toward[1] - lean * flat[1], toward[2] - lean * flat[2]))
            at_b, at_c = _dot(_minus(b, a), along), _dot(_minus(c, a), along)
            reach[s] = REACH * (max(0.0, at_b, at_c) - min(0.0, at_b, at_c))
    return reach


@njit(cache=True, nogil=True)
def _near_fold(surface: Smooth, face: int, eye: Floats, roughness: float) -> bool:
    """Whether the smooth surface may turn from the eye within a face or two.

    The flat face is off the smooth surface by the angles between its normal and its corners'. If the surface faces the
    eye, or turns from it, by more than a few of these, it doesn't.
    """
    vertices, faces, normals = surface
    i, j, k = faces[face, 0], faces[face, 1], faces[face, 2]
    a, b, c = _row(vertices, i), _row(vertices, j), _row(vertices, k)
    toward = _unit(_minus((eye[0], eye[1], eye[2]), a))
    lean = _dot(_unit(_cross(_minus(b, a), _minus(c, a))), toward)
    low, high, off = np.inf, -np.inf, 0.0
    for corner in (i, j, k):
        facing = _dot(_row(normals, corner), toward)
        low, high, off = min(low, facing), max(high, facing), max(off, abs(facing - lean))
    return bool(max(low, -high) <= roughness * off)


@njit(cache=True, nogil=True)
def _judge(
    points: Floats, face: Ints, reach: Floats, hit: Ints, before: Floats, surface: Smooth, eye: Floats, touch: float
) -> NDArray[np.int8]:
    """States of (N, 3) points on faces, given which faces their rays hit and how far before them."""
    vertices, faces, _ = surface
    state = np.full(len(points), _SEEN, np.int8)
    for n in range(len(points)):
        if before[n] <= touch:
            continue
        point = _row(points, n)
        i, j, k = faces[hit[n], 0], faces[hit[n], 1], faces[hit[n], 2]
        if _distance_to_triangle(point, _row(vertices, i), _row(vertices, j), _row(vertices, k)) <= touch:
            continue
        if (
            before[n] <= reach[n]
            and _turned_alike(surface, face[n], hit[n])
            and _near_fold(surface, hit[n], eye, 2 * ROUGHNESS)
        ):
            continue
        state[n] = _HIDDEN_NEARBY if before[n] <= reach[n] * GAP_REACH / REACH else _HIDDEN
    return state


@njit(cache=True, nogil=True)
def _turned_alike(surface: Smooth, one: int, other: int) -> bool:
    """Whether the mean normals at two faces' corners are within the angle allowed for faces of one fold."""
    normals = surface.normals
    ax, ay, az, bx, by, bz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        a, b = surface.faces[one, k], surface.faces[other, k]
        ax, ay, az = ax + normals[a, 0], ay + normals[a, 1], az + normals[a, 2]
        bx, by, bz = bx + normals[b, 0], by + normals[b, 1], bz + normals[b, 2]
    squares = (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz)
    return bool(ax * bx + ay * by + az * bz > SAME_WAY * math.sqrt(squares))


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def _row(rows: Floats, i: int) -> _Vector:
    return rows[i, 0], rows[i, 1], rows[i, 2]


@njit(cache=True, nogil=True)
def _minus(a: _Vector, b: _Vector) -> _Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(cache=True, nogil=True)
def _dot(a: _Vector, b: _Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True)
def _cross(a: _Vector, b: _Vector) -> _Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, nogil=True)
def _unit(a: _Vector) -> _Vector:
    length = max(math.sqrt(_dot(a, a)), 1e-300)
    return a[0] / length, a[1] / length, a[2] / length


def _smooth(state: NDArray[np.int8], samples: _Samples, chains: Chains) -> Mask:
    """(N,) which samples count as seen, with short gaps closed and specks dropped along chains."""
    seen = np.asarray(state == _SEEN)
    order, bounds = _along_chains(chains.segment, chains.flipped, chains.first, samples.first)
    seen[order] = _without_flicker(state[order], samples.pixels[order], bounds)
    return seen


@njit(cache=True, nogil=True)
def _along_chains(segment: Ints, flipped: Mask, first: Ints, first_sample: Ints) -> tuple[Ints, Ints]:
    """The samples of chained segments in the order in which chains pass them, and where each chain starts."""
    order = np.empty(first_sample[-1], np.int64)
    bounds = np.zeros(len(first), np.int64)
    filled = 0
    for c in range(len(first) - 1):
        for k in range(first[c], first[c + 1]):
            begin, end = first_sample[segment[k]], first_sample[segment[k] + 1]
            for i in range(end - begin):
                order[filled] = end - 1 - i if flipped[k] else begin + i
                filled += 1
        bounds[c + 1] = filled
    return order[:filled], bounds


@njit(cache=True, nogil=True)
def _without_flicker(state: NDArray[np.int8], pixels: Floats, bounds: Ints) -> Mask:
    """Which samples count as seen: gaps are closed first, then specks dropped."""
    seen = state >= _SEEN
    for closing in (True, False):
        for c in range(len(bounds) - 1):
            start = bounds[c]
            while start < bounds[c + 1]:
                stop, length, faint = start, 0.0, True
                while stop < bounds[c + 1] and seen[stop] == seen[start]:
                    length += pixels[stop]
                    faint = faint and state[stop] != _HIDDEN
                    stop += 1
                inner = start > bounds[c] and stop < bounds[c + 1]
                if inner and closing and not seen[start] and faint and length < GAP_PIXELS:
                    seen[start:stop] = True
                if inner and not closing and seen[start] and length < SPECK_PIXELS:
                    seen[start:stop] = False
                start = stop
    return seen


def _seen_intervals(seen: Mask, samples: _Samples, occlusion: _Occlusion) -> tuple[Ints, Floats, Floats]:
    """The parts of segments that are seen: segment, start and end in 0..1 of each."""
    first, last = np.zeros(len(seen), dtype=np.bool_), np.zeros(len(seen), dtype=np.bool_)
    first[samples.first[:-1]] = last[samples.first[1:] - 1] = True
    before = np.flatnonzero(~last[:-1] & (seen[:-1] != seen[1:]))
    # Where visibility changes between a sample and the next one of the same segment.
    change = np.full(len(seen), np.nan)
    change[before] = _locate(
        occlusion, samples.segment[before], samples.at[before], samples.at[before + 1], seen[before]
    )
    begins = np.flatnonzero(seen & (first | ~np.roll(seen, 1)))
    ends = np.flatnonzero(seen & (last | ~np.roll(seen, -1)))
    start = np.where(first[begins], 0.0, change[begins - 1])
    end = np.where(last[ends], 1.0, change[ends])
    return samples.segment[begins], start, end


def _locate(occlusion: _Occlusion, segment: Ints, low: Floats, high: Floats, seen: Mask) -> Floats:
    """Where between `low`, at which a segment is `seen` or not, and `high`, at which it is the other, that changes."""
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        same = (occlusion.state(segment, middle) == _SEEN) == seen
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray((low + high) / 2)
