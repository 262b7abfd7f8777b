"""The outlines of the flat faces, where no drawn line runs along them.

Contours are found on the smooth surface that interpolated normals describe. Where few large faces bend by less than a
crease, that surface turns from the eye far from where the faces do, behind their outline, or doesn't turn at all, and a
part of the shape's outline, or of one limb before another, would have no line. There, the edges whose faces all lie on
one side of them on the picture take the place of the contour, provided that beside them the eye sees farther.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ncmodel.camera import DEFAULT_SIZE, Camera
from ncmodel.export.rasterize import draw_segments
from ncmodel.geometry.adjacency import Offsets
from ncmodel.geometry.normals_areas import Indices, check_columns, sides_of
from ncmodel.jit import kernel
from ncmodel.lines.chaining import connected, shared_ends
from ncmodel.lines.edges import Edges
from ncmodel.lines.visibility import visible_pieces
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mask, Segments, Stroke

NEAR_PIXELS = 3.0
"""An outline nearer to a drawn line than this has one. All pixels are those of a picture whose shorter side is 768."""
STEP = 0.015
"""An edge is an outline if just beside it the eye sees past the shape, or a part of it that is farther by this..."""
ASIDE_PIXELS = 0.5
"""...on so short a way, in pixels of any picture, that a surface seen at a grazing angle hardly recedes as much."""
SHORTEST_PIXELS = 20.0
"""Outlines before other parts of the shape are longer: where a contour ends in a cusp, faces go on as an outline for a
little, in one line or several."""


def missing_outlines(surface: Surface, camera: Camera, drawn: Sequence[Stroke], sample_pixels: float) -> Segments:
    """The visible parts of a shape's outlines, as its faces have them, that are far from all strokes drawn so far.

    Args:
        surface: The shape, not parted.
        camera: Where it is seen from.
        drawn: On the picture plane.
        sample_pixels: Distance along the picture of the points at which visibility is decided.
    """
    vertices, rings, scene = surface.mesh.vertices, surface.rings, surface.scene
    pixel = max(min(camera.width, camera.height) / DEFAULT_SIZE, 1.0 / NEAR_PIXELS)
    turned = _turned(vertices, surface.faces, np.asarray(camera.eye, dtype=np.float64))
    start, end, face = _folds(rings.starts, rings.around, rings.face, turned)
    folds = Edges(np.stack([start, end], axis=1), face).lines(LineFamily.CONTOURS, vertices)
    if len(folds):
        folds = visible_pieces(_pieces(folds, camera, NEAR_PIXELS * pixel), camera, scene, None, sample_pixels)
    if len(folds):
        pixels, step = camera.project(folds.points)[..., :2], _step(folds, surface, camera)
        missing = np.flatnonzero(_far(pixels, drawn, NEAR_PIXELS * pixel, camera) & (step >= STEP))
        length = np.linalg.norm(pixels[missing, 1] - pixels[missing, 0], axis=1)
        length[np.isinf(step[missing])] = np.inf
        run = connected(folds.points[missing])
        long = np.bincount(run, length)[run] >= SHORTEST_PIXELS * pixel
        folds = folds.take(_with_neighbours(folds.points, missing[long]))
    return Segments(LineFamily.CONTOURS, folds.points, np.ones((len(folds), 2)), folds.face)


def _pieces(lines: LineSet, camera: Camera, longest: float) -> LineSet:
    """Lines cut into pieces of at most `longest` pixels on the picture, but for those partly behind the camera."""
    depth = -((lines.points - np.asarray(camera.eye)) @ camera.rotation.T)[..., 2]
    ahead = (depth > 0.0).all(axis=1)
    length = np.zeros(len(lines))
    pixels = camera.project(lines.points[ahead])[..., :2]
    length[ahead] = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1)
    most = 4.0 * np.hypot(camera.width, camera.height)
    count = np.maximum(np.ceil(np.minimum(length, most) / longest), 1.0).astype(np.int64)
    index = np.repeat(np.arange(len(lines)), count)
    place = np.arange(len(index)) - (np.cumsum(count) - count)[index]
    return lines.between(index, place / count[index], (place + 1) / count[index])


def _far(pixels: Floats, drawn: Sequence[Stroke], near: float, camera: Camera) -> Mask:
    """(S,) which segments (S, 2, 2) have their middle in the picture and no stroke near it."""
    column, row = np.floor(pixels.mean(axis=1)).T
    far = (column >= 0.0) & (column < camera.width) & (row >= 0.0) & (row < camera.height)
    if drawn and far.any():
        ends = np.concatenate([np.stack([s.points[:-1], s.points[1:]], axis=1) for s in drawn])
        broad = draw_segments(ends, np.ones((len(ends), 2)), 2.0 * near, (camera.height, camera.width))
        far[far] = broad[row[far].astype(np.int64), column[far].astype(np.int64)] < 0.5
    return np.asarray(far)


def _step(lines: LineSet, surface: Surface, camera: Camera) -> Floats:
    """(S,) how much farther than segments the eye sees just beside them, in radii of the mesh."""
    eye, middle = np.asarray(camera.eye), lines.points.mean(axis=1)
    away = middle - eye
    distance = np.linalg.norm(away, axis=1)
    aside = np.cross(away, lines.points[:, 1] - lines.points[:, 0])
    aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-300)
    aside *= (ASIDE_PIXELS * distance / camera.focal_pixels)[:, None]
    left, right = (surface.scene.first_hit(eye, away + side)[0] for side in (aside, -aside))
    return np.asarray((np.maximum(left, right) - distance) / surface.scene.radius)


def _with_neighbours(points: Floats, chosen: Ints) -> Mask:
    """(S,) the chosen segments (S, 2, 3), and those that share an end with one: they lead on to strokes."""
    nodes = shared_ends(points)
    return np.asarray(np.isin(nodes, nodes[chosen]).any(axis=1))


@kernel
def _turned(vertices: Floats, faces: Indices, eye: Floats) -> NDArray[np.int8]:
    """(F,) 1 for faces turned to the eye, -1 for those turned away, 0 for those seen edge-on and degenerate ones."""
    check_columns(vertices, 3)
    check_columns(faces, 3)
    turned = np.zeros(len(faces), dtype=np.int8)
    for f in range(len(faces)):
        i = faces[f, 0]
        sides, flat = sides_of(vertices, i, faces[f, 1], faces[f, 2])
        x, y, z = eye[0] - vertices[i, 0], eye[1] - vertices[i, 1], eye[2] - vertices[i, 2]
        toward = sides[9] * x + sides[10] * y + sides[11] * z
        if not flat and toward != 0.0:
            turned[f] = 1 if toward > 0.0 else -1
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
