"""What there is to draw of a view: outline, interior lines and shading, found once for all artists."""

from functools import cached_property
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from dataset_tools.artists.polylines import Polyline, joined, resampled, without
from ncmodel.camera import DEFAULT_SIZE
from ncmodel.chamfer import distance_to
from ncmodel.drawing.strokes import strokes
from ncmodel.drawing.thresholding import fade
from ncmodel.geometry import shading
from ncmodel.scene.view import View
from ncmodel.types import SUGGESTIVE_FADE, Floats, Image, LineFamily, Mask, Stroke, Threshold

FAINTEST = {
    LineFamily.APPARENT: 0.02,
    LineFamily.RIDGES: 0.02,
    LineFamily.VALLEYS: 0.02,
    LineFamily.SUGGESTIVE: 0.001,
}
"""Family -> threshold, in rtsc's units: an artist goes on with a line down to here, far below the default."""

TYPICAL = {
    LineFamily.APPARENT: 0.1,
    LineFamily.RIDGES: 0.1,
    LineFamily.VALLEYS: 0.1,
    LineFamily.SUGGESTIVE: 0.03,
}
"""Strengths of a salience of 1/2."""

Values = TypeVar("Values", Image, NDArray[np.uint8])

OUTLINE = (LineFamily.CONTOURS, LineFamily.BOUNDARIES)
GAP = 16.0
"""Pixels across which strokes that continue one another are one line."""
OUTLINE_SPECK = 14.0
"""Pixels; shorter contours are no part."""
SPECK = 8.0
"""Pixels; shorter strokes are nothing to draw."""
CREASE = 0.2
"""Creases whose strokes are at least this share of the picture's side on average (weighted by length) are edges of a
machine part; shorter ones are facets of a rough surface."""
CLEAR = 10.0
"""Pixels from the silhouette within which a line says the same as the silhouette."""
BAND = 6.0
"""Pixels on both sides of the silhouette that belong to it."""


class Motif:
    """A view as an artist finds it. All pixels are those of a picture whose shorter side is 768.

    Args:
        view: The view.
    """

    def __init__(self, view: View) -> None:
        self.view = view
        width, height = view.camera.width, view.camera.height
        self.scale = min(width, height) / DEFAULT_SIZE
        self.shape = (round(height / self.scale), round(width / self.scale))

    @cached_property
    def hit(self) -> Mask:
        """(H, W) the pixels that show the shape."""
        hit = self.view.buffers.hit.astype(np.uint8)
        return np.asarray(cv2.resize(hit, self.shape[::-1], interpolation=cv2.INTER_NEAREST) > 0)

    @cached_property
    def silhouette(self) -> Mask:
        """(H, W) the pixels of the shape's edge."""
        cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
        inner = cv2.erode(self.hit.astype(np.uint8), cross, borderType=cv2.BORDER_REPLICATE)
        return np.asarray(self.hit & (inner == 0))

    @cached_property
    def from_silhouette(self) -> Image:
        """(H, W) distance to the shape's edge."""
        return distance_to(self.silhouette)

    @cached_property
    def outline_length(self) -> float:
        """Pixels around the shape."""
        return max(float(np.count_nonzero(self.silhouette)), DEFAULT_SIZE / 2)

    @cached_property
    def outlines(self) -> list[Polyline]:
        """Contours and boundaries, those inside the shape too, without specks."""
        found = [line for family in OUTLINE for line in self._lines(family)]
        return [line for line in joined(found, GAP / 2) if line.length >= OUTLINE_SPECK]

    @cached_property
    def edges(self) -> list[Polyline]:
        """The creases of a machine part; none of a rough surface."""
        lines = self._lines(LineFamily.CREASES)
        lengths = np.array([line.length for line in lines])
        if not lines or (lengths**2).sum() < CREASE * DEFAULT_SIZE * lengths.sum():
            return []
        return joined(lines, GAP / 2)

    @cached_property
    def features(self) -> list[Polyline]:
        """Lines of curvature: long ones, far below the default thresholds."""
        found: list[Polyline] = []
        for family in FAINTEST:
            for line in joined(self._lines(family), GAP):
                found += without(line, at(self.from_silhouette, line.points) <= CLEAR, GAP, 2 * SPECK)
        return found

    @cached_property
    def normals(self) -> Image:
        """(H, W, 3) the seen surface's normals, right, up and towards the eye; 0 on the background."""
        view, faces = self.view, self.view.surface.faces
        turned = view.surface.normals @ view.camera.rotation.T
        layers = [shading.interpolate(view.buffers, faces, np.ascontiguousarray(axis)) for axis in turned.T]
        picture = np.stack(layers, axis=-1).astype(np.float32)
        return np.asarray(cv2.resize(picture, self.shape[::-1], interpolation=cv2.INTER_AREA))

    def inside(self, line: Polyline) -> Mask:
        """(n,) the points of a line that aren't on the silhouette."""
        return np.asarray(at(self.from_silhouette, line.points) > BAND)

    def _lines(self, family: LineFamily) -> list[Polyline]:
        lines = self.view.visible(family)
        segments = fade(lines, Threshold(FAINTEST.get(family, 0.0)))
        found = strokes(segments, self.view.camera, tolerance=0.25, shortest=3.0 * self.scale)
        return [resampled(one.points / self.scale, family.value, _salience(family, one)) for one in found]


def _salience(family: LineFamily, stroke: Stroke) -> Floats:
    """(n,) strength / (strength + the typical one), from the opacity that the faintest threshold gives."""
    if family not in FAINTEST:
        return np.full(len(stroke.alpha), 0.99)
    strength = np.minimum(strength_of(family, stroke.alpha), 1e6)
    return np.asarray(strength / (strength + TYPICAL[family]))


def strength_of(family: LineFamily, alpha: Floats) -> Floats:
    """The strength at which the family's fade at its faintest threshold gives an opacity."""
    clear = 1.0 - np.minimum(alpha, 1.0 - 1e-6)
    if family is LineFamily.SUGGESTIVE:
        return np.asarray(FAINTEST[family] + SUGGESTIVE_FADE * alpha / clear)
    return np.asarray(FAINTEST[family] / clear)


def at(image: Values, points: Floats) -> Values:
    """(n,) an image's values at points (n, 2)."""
    columns = np.clip(points[:, 0].astype(np.intp), 0, image.shape[1] - 1)
    rows = np.clip(points[:, 1].astype(np.intp), 0, image.shape[0] - 1)
    values: Values = image[rows, columns]
    return values
