"""Contours of a surface of flat faces: those along the faces' outlines, and outlines in place of others."""

from dataclasses import dataclass

from ncmodel.camera import Camera
from ncmodel.lines import polygonal_outlines as outlines
from ncmodel.lines.visibility import hidden_pieces, visible_pieces
from ncmodel.scene.surface import Surface
from ncmodel.types import LineSet


@dataclass(frozen=True, eq=False)
class FaceOutlines:
    """The contours of a view.

    Attributes:
        visible: Those that are seen.
        folds: Where the faces end on the picture, seen or hidden.
        in_place: The folds that stand for contours where the smooth surface has none, with their hidden parts.
    """

    visible: LineSet
    folds: LineSet
    in_place: LineSet


def face_outlines(
    contours: LineSet,
    boundaries: LineSet,
    creases: LineSet | None,
    whole: Surface,
    camera: Camera,
    sample_pixels: float,
) -> FaceOutlines:
    """Visible contours without those that aren't near any fold of the faces, and with the outlines they miss.

    Args:
        contours: The visible ones of the smooth surface.
        boundaries: The visible ones.
        creases: The visible ones of a surface that is parted there.
        whole: The surface, not parted.
        camera: Where it is seen from.
        sample_pixels: Distance along the picture of the points at which visibility is decided.
    """
    shape = outlines.Polygons(whole.mesh.vertices, whole.faces, whole.rings, whole.scene, whole.shells)
    folds = outlines.folds(shape, camera)
    contours, doubtful = outlines.along(contours, folds, boundaries, shape.scene, camera)
    drawn = [contours, boundaries] if creases is None else [contours, boundaries, creases]
    shortest = outlines.SHORTEST_PIXELS if creases is None else outlines.SHORTEST_BETWEEN_CREASES
    in_place = outlines.missing_outlines(folds, drawn, shape, camera, shortest)
    missing = visible_pieces(in_place, camera, shape.scene, None, sample_pixels)
    doubtful = outlines.apart(doubtful, missing, camera)
    return FaceOutlines(outlines.joined(outlines.joined(contours, doubtful), missing), folds, in_place)


def hidden_contours(
    contours: LineSet, boundaries: LineSet, found: FaceOutlines, whole: Surface, camera: Camera, sample_pixels: float
) -> LineSet:
    """Hidden contours that are near the ends of faces, and the hidden parts of outlines that stand for others.

    Args:
        contours: The hidden ones of the smooth surface.
        boundaries: All of them.
        found: The visible ones.
        whole: The surface, not parted.
        camera: Where it is seen from.
        sample_pixels: Distance along the picture of the points at which visibility is decided.
    """
    kept = outlines.near_ends_of_faces(contours, found.folds, boundaries, camera)
    return outlines.joined(kept, hidden_pieces(found.in_place, camera, whole.scene, None, sample_pixels))
