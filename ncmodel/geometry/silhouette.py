"""The outline of the flat faces, where no drawn line runs along it.

Contours are found on the smooth surface that interpolated normals describe. Where few large faces bend by less than a
crease, that surface turns from the eye far from where the faces do, behind their outline, and a part of the shape's
outline would have no line at all. There, the edges between a face that is turned to the eye and one that isn't take
the place of the contour: before the background alone, where nothing else can be meant.
"""

from collections.abc import Sequence

import numpy as np

from ncmodel.camera import Camera
from ncmodel.geometry.areas import Indices, check_columns, sides_of
from ncmodel.geometry.edges import Edges
from ncmodel.geometry.rings import Offsets
from ncmodel.geometry.surface import Surface
from ncmodel.geometry.visibility import visible_pieces
from ncmodel.kernels import kernel
from ncmodel.raster import draw_segments
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mask, Segments, Stroke

NEAR_PIXELS = 3.0
"""An outline nearer to a drawn line than this, in pixels, has one."""
ASIDE_PIXELS = 2.0
"""An edge is an outline if, this far beside it, the eye sees past the shape."""


def missing_outlines(surface: Surface, camera: Camera, drawn: Sequence[Stroke], sample_pixels: float) -> Segments:
    """The visible parts of a shape's outline, as its faces have it, that are far from all strokes drawn so far.

    Args:
        surface: The shape, not parted.
        camera: Where it is seen from.
        drawn: On the picture plane.
        sample_pixels: Distance along the picture of the points at which visibility is decided.
    """
    vertices, rings, scene = surface.mesh.vertices, surface.rings, surface.scene
    eye = np.asarray(camera.eye, dtype=np.float64)
    start, corner = _folds(rings.starts, rings.around, rings.face, _turned_to(vertices, surface.faces, eye))
    ends = np.stack([start, rings.around[corner, 0]], axis=1).astype(np.int64)
    folds = Edges(ends, rings.face[corner].astype(np.int64)).lines(LineFamily.CONTOURS, vertices)
    if len(folds):
        folds = visible_pieces(_pieces(folds, camera), camera, scene, None, sample_pixels)
    if len(folds):
        folds = folds.take(_far(camera.project(folds.points)[..., :2], drawn, camera))
    if len(folds):
        folds = folds.take(_is_outline(folds, surface, camera))
    return Segments(LineFamily.CONTOURS, folds.points, np.ones((len(folds), 2)), folds.face)


def _pieces(lines: LineSet, camera: Camera) -> LineSet:
    """Lines cut into pieces of at most `NEAR_PIXELS` on the picture, but for those partly behind the camera."""
    depth = -((lines.points - np.asarray(camera.eye)) @ camera.rotation.T)[..., 2]
    ahead = (depth > 0.0).all(axis=1)
    length = np.zeros(len(lines))
    pixels = camera.project(lines.points[ahead])[..., :2]
    length[ahead] = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1)
    most = 4.0 * np.hypot(camera.width, camera.height)
    count = np.maximum(np.ceil(np.minimum(length, most) / NEAR_PIXELS), 1.0).astype(np.int64)
    index = np.repeat(np.arange(len(lines)), count)
    place = np.arange(len(index)) - (np.cumsum(count) - count)[index]
    return lines.between(index, place / count[index], (place + 1) / count[index])


def _far(pixels: Floats, drawn: Sequence[Stroke], camera: Camera) -> Mask:
    """(S,) which segments (S, 2, 2) have their middle in the picture and no stroke near it."""
    column, row = np.floor(pixels.mean(axis=1)).T
    far = (column >= 0.0) & (column < camera.width) & (row >= 0.0) & (row < camera.height)
    if drawn and far.any():
        ends = np.concatenate([np.stack([s.points[:-1], s.points[1:]], axis=1) for s in drawn])
        broad = draw_segments(ends, np.ones((len(ends), 2)), 2.0 * NEAR_PIXELS, (camera.height, camera.width))
        far[far] = broad[row[far].astype(np.int64), column[far].astype(np.int64)] < 0.5
    return np.asarray(far)


def _is_outline(lines: LineSet, surface: Surface, camera: Camera) -> Mask:
    """(S,) beside which segments the eye sees past the shape."""
    eye, middle = np.asarray(camera.eye), lines.points.mean(axis=1)
    away = middle - eye
    distance = np.linalg.norm(away, axis=1)
    aside = np.cross(away, lines.points[:, 1] - lines.points[:, 0])
    aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-300)
    aside *= (ASIDE_PIXELS * distance / camera.focal_pixels)[:, None]
    return np.logical_or(*(surface.scene.first_hit(eye, away + side)[1] < 0 for side in (aside, -aside)))


@kernel
def _turned_to(vertices: Floats, faces: Indices, eye: Floats) -> Mask:
    """(F,) which faces are turned to the eye; degenerate ones aren't."""
    check_columns(vertices, 3)
    check_columns(faces, 3)
    turned = np.empty(len(faces), dtype=np.bool_)
    for f in range(len(faces)):
        i = faces[f, 0]
        sides, flat = sides_of(vertices, i, faces[f, 1], faces[f, 2])
        x, y, z = eye[0] - vertices[i, 0], eye[1] - vertices[i, 1], eye[2] - vertices[i, 2]
        turned[f] = sides[9] * x + sides[10] * y + sides[11] * z > 0.0 and not flat
    return turned


@kernel
def _folds(starts: Offsets, around: Indices, face: Indices, turned: Mask) -> tuple[Ints, Ints]:
    """Sides (start vertex, ring corner) of faces turned to the eye whose twins' faces aren't."""
    vertex = np.empty(len(around), dtype=np.int64)
    corner = np.empty(len(around), dtype=np.int64)
    size = 0
    for v in range(len(starts) - 1):
        count = 0
        for n in range(starts[v], starts[v + 1]):
            count += turned[face[n]]
        if count == 0 or count == starts[v + 1] - starts[v]:
            continue
        for n in range(starts[v], starts[v + 1]):
            for m in range(starts[v], starts[v + 1]):
                if turned[face[n]] and around[m, 1] == around[n, 0] and not turned[face[m]]:
                    vertex[size], corner[size] = v, n
                    size += 1
                    break
    return vertex[:size].copy(), corner[:size].copy()
