"""The outlines of the flat faces: what contours must lie on, and what stands for them where there are none.

Contours are found on the smooth surface that interpolated normals describe; the eye sees flat faces. Where those are
few and large, that surface turns from the eye far from where they do: in the middle of a cone's side, behind it, or
nowhere. Folds, the visible edges whose faces all lie on one side of them on the picture, are where the faces really end
before what is behind them. A contour that strays from all of them by more than a few pixels is none; and where beside a
fold the eye sees farther, and no drawn line runs along it, the fold takes the contour's place.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ncmodel.camera import DEFAULT_SIZE, Camera
from ncmodel.export.rasterize import row_span
from ncmodel.geometry.adjacency import Offsets, Rings
from ncmodel.geometry.normals_areas import Indices, check_columns, sides_of
from ncmodel.geometry.raycast import RayScene
from ncmodel.geometry.view_vectors import toward
from ncmodel.jit import kernel
from ncmodel.lines.chaining import connected, shared_ends
from ncmodel.lines.edges import Edges
from ncmodel.lines.occlusion import SEEN, Occlusion
from ncmodel.lines.visibility import in_frame
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mask

NEAR_PIXELS = 3.0
"""Contours lie within this of a fold, and a fold nearer to a drawn line has one. All pixels are those of a picture
whose shorter side is 768."""
SMALL_PIXELS = 6.0
"""On faces of this size, a contour and its fold are seen together or not at all."""
ROUNDING = 0.5
"""What a point may be off the centre of its pixel, in either direction, where distances are looked up in a picture."""
STEP = 0.015
"""A fold is an outline if just beside it the eye sees past the shape, or a part of it that is as many radii farther."""
ASIDE_PIXELS = 0.5
"""How far beside it, in pixels of any picture."""
TOUCH = 1e-4
"""Before another body this is enough: a cushion against the back of a sofa."""
SHORTEST_PIXELS = 60.0
"""Outlines before other parts of the shape are longer: where a contour ends in a cusp, faces go on as an outline for a
little, in one line or several."""
SHORTEST_BETWEEN_CREASES = 20.0
"""The same where creases part a shape: contours between them are short, too."""
CROSSING_PIXELS = 60.0
"""Where a stray line crosses an outline, this much of it is near at most."""


class Polygons(NamedTuple):
    """A shape's flat faces.

    Attributes:
        vertices: (V, 3).
        faces: (F, 3).
        rings: The faces around each vertex.
        scene: The same, for rays.
        shells: (F,) a number for each face, equal for connected ones.
    """

    vertices: Floats
    faces: Indices
    rings: Rings
    scene: RayScene
    shells: Ints


def folds(shape: Polygons, camera: Camera) -> LineSet:
    """The edges whose faces, two at least, all lie on one side of them on the picture, in short pieces.

    Those in the frame, hidden ones included.

    Args:
        shape: The faces.
        camera: Where they are seen from.
    """
    vertices, faces, rings, scene, _ = shape
    turned = _turned(vertices, faces, camera.viewpoint)
    start, end, face = _folds(rings.starts, rings.around, rings.face, turned)
    edges = Edges(np.stack([start, end], axis=1), face).lines(LineFamily.CONTOURS, vertices)
    framed = in_frame(edges, camera, scene)
    return framed.between(*_pieces(framed, camera, _near(camera)))


def along(
    lines: LineSet, folds: LineSet, boundaries: LineSet, scene: RayScene, camera: Camera
) -> tuple[LineSet, LineSet]:
    """The segments that are near where faces end from one end to the other; out of the picture all are.

    Args:
        lines: Visible contours.
        folds: Pieces of all.
        boundaries: The visible ones.
        scene: The faces.
        camera: Where they are seen from.

    Returns:
        Those that are contours; and short runs beside segments that aren't, as where a stray line crosses an outline.
    """
    within = max(_near(camera) - ROUNDING, 1.0)
    index, begin, stop = _pieces(lines, camera, within / 2)
    pieces = lines.between(index, begin, stop)
    # Beside a contour on a small face, a fold of that face needs no rays to tell that it is seen, too.
    bears = np.zeros(len(scene.faces), np.bool_)
    corners = camera.project(scene.vertices[scene.faces[lines.face]])[..., :2]
    small = (np.ptp(corners, axis=1) <= SMALL_PIXELS / NEAR_PIXELS * _near(camera)).all(axis=1)
    bears[lines.face[small]] = True
    far = _far(pieces, [folds.take(bears[folds.face]), boundaries], camera, within)
    rest = np.flatnonzero(far)
    around = folds.take(~_far(folds, [pieces.take(rest)], camera, 2.0 * _near(camera)))
    far[rest] = _far(pieces.take(rest), [_seen(around, camera, scene), boundaries], camera, within)
    astray = np.bincount(index, far, len(lines)) > 0
    if not astray.any():
        return lines, lines.take(astray)
    nodes, kept = shared_ends(lines.points), np.flatnonzero(~astray)
    pixels = camera.project(lines.points[kept])[..., :2]
    run = connected(lines.points[kept])
    length = np.bincount(run, np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1))
    cut_off = np.bincount(run, np.isin(nodes[kept], nodes[astray]).any(axis=1)) > 0
    short = (cut_off & (length < CROSSING_PIXELS / NEAR_PIXELS * _near(camera)))[run]
    return lines.take(kept[~short]), lines.take(kept[short])


def near_ends_of_faces(lines: LineSet, folds: LineSet, boundaries: LineSet, camera: Camera) -> LineSet:
    """The segments that are near a fold or a boundary from one end to the other, seen or hidden.

    Args:
        lines: Hidden contours.
        folds: Pieces of all.
        boundaries: All.
        camera: Where they are seen from.
    """
    within = max(_near(camera) - ROUNDING, 1.0)
    index, begin, stop = _pieces(lines, camera, within / 2)
    far = _far(lines.between(index, begin, stop), [folds, boundaries], camera, within)
    return lines.take(np.bincount(index, far, len(lines)) == 0)


def apart(lines: LineSet, others: LineSet, camera: Camera) -> LineSet:
    """The segments that no other line is near."""
    return lines.take(_far(lines, [others], camera, _near(camera)))


def missing_outlines(
    folds: LineSet,
    drawn: Sequence[LineSet],
    shape: Polygons,
    camera: Camera,
    shortest: float = SHORTEST_PIXELS,
) -> LineSet:
    """The folds, with their hidden parts, before something farther, or nothing, that are far from all lines drawn.

    Before another body they are lines however near it is: there is no going on from one to the other.

    Args:
        folds: Pieces of all.
        drawn: The visible lines drawn.
        shape: The faces.
        camera: Where they are seen from.
        shortest: What those before another part of the shape measure at least, in pixels at 768.
    """
    far = np.flatnonzero(_far(folds, drawn, camera, _near(camera)))
    step = _step(folds.take(far), shape, camera)
    missing, step = far[step >= STEP], step[step >= STEP]
    pixels = camera.project(folds.points[missing])[..., :2]
    length = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1)
    length[np.isinf(step)] = np.inf
    run = connected(folds.points[missing])
    long = missing[np.bincount(run, length)[run] >= shortest / NEAR_PIXELS * _near(camera)]
    return folds.take(_with_neighbours(folds.points, long) if len(long) else long)


def joined(one: LineSet, other: LineSet) -> LineSet:
    """The lines of two sets of one family without strength."""
    return replace(
        one,
        points=np.concatenate([one.points, other.points]),
        face=np.concatenate([one.face, other.face]),
        feature=np.concatenate([one.feature, other.feature]),
        denominator=np.concatenate([one.denominator, other.denominator]),
    )


def _near(camera: Camera) -> float:
    """`NEAR_PIXELS` in pixels of the picture, at least one."""
    return max(NEAR_PIXELS * min(camera.width, camera.height) / DEFAULT_SIZE, 1.0)


def _pieces(lines: LineSet, camera: Camera, longest: float) -> tuple[Ints, Floats, Floats]:
    """Pieces of segments, at most `longest` pixels long: segment, start, end."""
    pixels = camera.project(lines.points)[..., :2]
    length = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1)
    count = np.maximum(np.ceil(length / longest), 1.0).astype(np.int64)
    index = np.repeat(np.arange(len(lines)), count)
    place = np.arange(len(index)) - (np.cumsum(count) - count)[index]
    return index, place / count[index], (place + 1) / count[index]


def _seen(pieces: LineSet, camera: Camera, scene: RayScene) -> LineSet:
    """The pieces of mesh edges that are seen, each as a whole: they are hardly longer than lines' samples are apart."""
    state = Occlusion(pieces, camera, scene, None).state(np.arange(len(pieces)), np.full(len(pieces), 0.5))
    return pieces.take(state == SEEN)


def _far(lines: LineSet, others: Sequence[LineSet], camera: Camera, pixels: float) -> Mask:
    """(S,) which segments have their middle in the picture and no other line within some pixels of it."""
    column, row = np.floor(camera.project(lines.points)[..., :2].mean(axis=1)).T
    far = (column >= 0.0) & (column < camera.width) & (row >= 0.0) & (row < camera.height)
    if others and far.any():
        ends = np.concatenate([camera.project(other.points)[..., :2] for other in others])
        near = _near_segments(ends, pixels, camera.height, camera.width)
        far[far] = ~near[row[far].astype(np.int64), column[far].astype(np.int64)]
    return np.asarray(far)


@kernel
def _near_segments(ends: Floats, pixels: float, height: int, width: int) -> Mask:
    """(H, W) which pixels have their centre within some pixels of one of (S, 2, 2) segments."""
    near = np.zeros((height, width), np.bool_)
    for s in range(len(ends)):
        # From the upper to the lower end.
        upper = 0 if ends[s, 0, 1] <= ends[s, 1, 1] else 1
        x, y = ends[s, upper]
        x1, y1 = ends[s, 1 - upper]
        square = max((x1 - x) ** 2 + (y1 - y) ** 2, 1e-300)
        for row in range(int(max(y - pixels, 0.0)), int(min(max(y1 + pixels + 1.0, 0.0), float(height)))):
            first, last = row_span(x, y, x1, y1, row + 0.5, pixels, width)
            for column in range(first, last):
                u, v = column + 0.5 - x, row + 0.5 - y
                along = min(max((u * (x1 - x) + v * (y1 - y)) / square, 0.0), 1.0)
                off = (u - along * (x1 - x)) ** 2 + (v - along * (y1 - y)) ** 2
                near[row, column] |= off <= pixels * pixels
    return near


def _step(lines: LineSet, shape: Polygons, camera: Camera) -> Floats:
    """(S,) how much farther than segments the eye sees where they end, in radii of the mesh.

    What is seen beside a segment is followed back to it, as a surface seen at a grazing angle recedes much in a pixel.
    Another body counts as `STEP` at least.
    """
    rays = camera.rays_to(lines.points.mean(axis=1))
    distance = np.linalg.norm(rays.directions, axis=1)
    aside = np.cross(rays.directions, lines.points[:, 1] - lines.points[:, 0])
    aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-300)
    aside *= (ASIDE_PIXELS * camera.scale_distance(distance) / camera.focal_pixels)[:, None]
    step, radius = np.zeros(len(lines)), shape.scene.radius
    for side in (aside, -aside):
        beside, face = shape.scene.first_hit(*rays.aside(side))
        receding = np.zeros(len(lines))
        deep = np.flatnonzero(np.isfinite(beside) & (beside - distance > TOUCH * radius))
        beyond = shape.scene.first_hit(*rays.aside(2.0 * side).take(deep))[0]
        receding[deep] = np.where(np.isfinite(beyond), np.maximum(beyond - beside[deep], 0.0), 0.0)
        farther = (beside - receding - distance) / radius
        other = (farther > TOUCH) & (face >= 0) & (shape.shells[face] != shape.shells[lines.face])
        step = np.maximum(step, np.where(other, np.maximum(farther, STEP), farther))
    return step


def _with_neighbours(points: Floats, chosen: Ints) -> Mask:
    """(S,) the chosen segments (S, 2, 3), and those that share an end with one: they lead on to strokes."""
    nodes = shared_ends(points)
    return np.asarray(np.isin(nodes, nodes[chosen]).any(axis=1))


@kernel
def _turned(vertices: Floats, faces: Indices, viewpoint: Floats) -> NDArray[np.int8]:
    """(F,) 1 for faces turned to the eye, -1 for all others.

    However degenerate faces and those seen edge-on count, the edges between both kinds are closed lines.
    """
    check_columns(vertices, 3)
    check_columns(faces, 3)
    turned = np.empty(len(faces), dtype=np.int8)
    for f in range(len(faces)):
        i = faces[f, 0]
        sides, flat = sides_of(vertices, i, faces[f, 1], faces[f, 2])
        x, y, z = toward(viewpoint, vertices[i, 0], vertices[i, 1], vertices[i, 2])
        turned[f] = 1 if sides[9] * x + sides[10] * y + sides[11] * z > 0.0 and not flat else -1
    return turned


@kernel
def _folds(starts: Offsets, around: Indices, face: Indices, turned: NDArray[np.int8]) -> tuple[Ints, Ints, Ints]:
    """Edges whose faces, two at least, are all seen on the same side of them: both ends, and one of the faces.

    However the faces are oriented: one that has an edge in the opposite direction lies on its other side where it is
    turned the same way.
    """
    start = np.empty(len(around), dtype=np.int64)
    end = np.empty(len(around), dtype=np.int64)
    owner = np.empty(len(around), dtype=np.int64)
    # How many faces of the edge to each neighbour of the current vertex are seen on its left and right.
    left, right = np.zeros(len(starts), dtype=np.int32), np.zeros(len(starts), dtype=np.int32)
    size = 0
    for v in range(len(starts) - 1):
        for n in range(starts[v], starts[v + 1]):
            following, previous, toward = around[n, 0], around[n, 1], turned[face[n]]
            left[following] += toward > 0
            right[following] += toward < 0
            left[previous] += toward < 0
            right[previous] += toward > 0
        for n in range(starts[v], starts[v + 1]):
            for far in around[n]:
                if far > v and max(left[far], right[far]) > 1 and min(left[far], right[far]) == 0:
                    start[size], end[size], owner[size] = v, far, face[n]
                    size += 1
                left[far] = right[far] = 0
    return start[:size].copy(), end[:size].copy(), owner[:size].copy()
