"""The outline of what a drawing shows, and of what a camera sees of a mesh: the same kind of thing, to be compared.

An outline is the rim of a filled region without its holes: lines inside a drawing can't be told from the rim of a hole.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter1d

from eval.measures.thinning import thin_lines
from ncmodel.camera import Camera
from ncmodel.chamfer import diagonal, distance_to
from ncmodel.geometry.raycast import RayScene
from ncmodel.types import Floats, Image, Ints, Mask

WIDEST_GAP = 0.02
"""Share of the picture's diagonal: wider gaps in a drawn outline aren't closed."""

_GAPS = (0.0, 0.002, 0.004, 0.008, 0.014, WIDEST_GAP)
_WHOLE = 0.85
"""A region with this share of the area that the widest closing gives leaks nowhere."""

_LEAST_INSIDE = 0.08
"""Share of the lines' bounding box that lies inside the outline; less is lines that enclose nothing."""

_PALEST = 0.1
"""Ink below this is paper."""
_CONNECTED = 0.35
"""Share of the ink of a drawing's lines at which they are cut out."""

_SMOOTHING = 1.5
"""Standard deviation, in points, of what the steps of pixels are smoothed by."""

_HALVINGS = 6
"""Of the step between a pixel that sees the mesh and its neighbour that doesn't."""


class OpenOutlineError(ValueError):
    """Lines that enclose no region."""


@dataclass(frozen=True, eq=False)
class DrawnOutline:
    """The outline of a drawing.

    Attributes:
        region: (H, W) what it encloses, itself included, holes filled.
        points: (N, 2) u, v on it, a pixel apart.
        normals: (N, 2) unit, outwards.
        distance: (H, W) signed distance of each pixel to it, negative inside; pixels.
        closed: Width of the widest gap that had to be closed, pixels.
    """

    region: Mask
    points: Floats
    normals: Floats
    distance: Image
    closed: float

    @staticmethod
    def of(region: Mask, closed: float = 0.0) -> "DrawnOutline":
        """The outline of a region without holes; through the centres of its outermost pixels."""
        rims = _rims(region)
        points = np.concatenate([_smoothed(rim) + 0.5 for rim in rims])
        normals = np.concatenate([_normals(rim) for rim in rims])
        line = np.zeros_like(region)
        for rim in rims:
            line[rim[:, 1], rim[:, 0]] = True
        away = distance_to(line)
        return DrawnOutline(region, points, normals, np.where(region, -away, away), closed)

    def shrunk(self, width: int, height: int) -> "DrawnOutline":
        """The same outline in a smaller picture."""
        small = cv2.resize(self.region.astype(np.float32), (width, height), interpolation=cv2.INTER_AREA)
        return DrawnOutline.of(small >= 0.5, self.closed)


def drawn_outline(ink: Image) -> DrawnOutline:
    """The outline of what a drawing shows.

    Gaps are closed, as far as need be and up to `WIDEST_GAP`; thin lines that stand out of the outline are left aside.

    Args:
        ink: (H, W) the drawing, 1 = line.

    Raises:
        OpenOutlineError: Nothing is drawn, or lines enclose no region.
    """
    lines = thin_lines(ink, _counting(ink))
    if not lines.any():
        raise OpenOutlineError("nothing is drawn in it")
    reaches = [share * diagonal(lines) / 2 for share in _GAPS]
    whole = int(_enclosed(lines, reaches[-1]).sum())
    rows, columns = np.flatnonzero(lines.any(axis=1)), np.flatnonzero(lines.any(axis=0))
    box = (rows[-1] - rows[0] + 1) * (columns[-1] - columns[0] + 1)
    if whole < _LEAST_INSIDE * box or whole == 0:
        raise OpenOutlineError(f"its outline isn't closed: its lines enclose {whole / box:.0%} of the area they span")
    for reach in reaches:
        region = _enclosed(lines, reach)
        if region.sum() >= _WHOLE * whole:
            return DrawnOutline.of(region, 2 * reach)
    raise AssertionError("the widest closing encloses all that it encloses")


@dataclass(frozen=True, eq=False)
class SeenOutline:
    """The outline of a mesh in a view.

    Attributes:
        region: (H, W) the pixels that see the mesh, holes filled.
        points: (N, 3) where on the mesh its rim is, in object space.
        whole: Whether none of it is cut off by the picture's frame.
    """

    region: Mask
    points: Floats
    whole: bool


def seen_outline(scene: RayScene, camera: Camera) -> SeenOutline:
    """The outline of a mesh through a camera, between pixels."""
    hit = scene.render(camera).hit
    region = filled(hit)
    rim = outermost(region)
    whole = not (hit[0].any() or hit[-1].any() or hit[:, 0].any() or hit[:, -1].any())
    # Rim pixels of a filled region see the mesh, and their neighbour outside doesn't.
    padded = np.pad(region, 1)
    rows, columns = np.nonzero(rim)
    near, steps = [], []
    for step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        outside = ~padded[rows + 1 + step[0], columns + 1 + step[1]]
        near.append(np.stack([columns, rows], axis=1)[outside] + 0.5)
        steps.append(np.broadcast_to([step[1], step[0]], (int(outside.sum()), 2)))
    return SeenOutline(region, _between(scene, camera, np.concatenate(near), np.concatenate(steps)), whole)


def filled(region: Mask) -> Mask:
    """A region with its holes."""
    return ~_outside(region)


def outermost(region: Mask) -> Mask:
    """The pixels of a region that touch what is outside it, the frame too."""
    kernel = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    inner = cv2.erode(region.astype(np.uint8), kernel, borderType=cv2.BORDER_CONSTANT, borderValue=0)
    return np.asarray(region & (inner == 0))


def _counting(ink: Image) -> float:
    """Ink from which on a pixel counts as drawn: lines thinner than a pixel are pale, and must stay in one piece."""
    drawn = ink[ink > _PALEST]
    return _CONNECTED * float(np.percentile(drawn, 90)) if drawn.size else 1.0


def _between(scene: RayScene, camera: Camera, near: Floats, step: Floats) -> Floats:
    """Points of the mesh at its rim, from pixels that see it and the steps to pixels that don't."""
    found = scene.hits(*camera.rays(near))
    point, low, high = found.point, np.zeros(len(near)), np.ones(len(near))
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        hits = scene.hits(*camera.rays(near + middle[:, None] * step))
        seen = hits.face >= 0
        point = np.where(seen[:, None], hits.point, point)
        low, high = np.where(seen, middle, low), np.where(seen, high, middle)
    return np.asarray(point[found.face >= 0])


def _enclosed(lines: Mask, reach: float) -> Mask:
    """What lines enclose if they are `reach` thicker to either side, without what sticks out of it."""
    thick = distance_to(lines) <= reach if reach > 0.0 else lines
    # Thick lines may reach over the frame.
    margin = int(np.ceil(reach)) + 2
    region = ~_outside(np.pad(thick, margin))
    if reach > 0.0:
        region = distance_to(~region) > reach
    kernel = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    opened = cv2.morphologyEx(region.astype(np.uint8), cv2.MORPH_OPEN, kernel)
    return np.asarray(_largest(opened > 0)[margin:-margin, margin:-margin])


def _largest(region: Mask) -> Mask:
    """The connected parts of a region that aren't small beside the largest."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(region.astype(np.uint8), connectivity=4)
    if count < 2:
        return region
    areas = stats[:, cv2.CC_STAT_AREA].copy()
    areas[0] = 0
    return np.asarray((areas >= 0.05 * areas.max())[labels])


def _outside(region: Mask) -> Mask:
    """The pixels that can be reached from the frame without crossing a region, not even between diagonal pixels."""
    canvas = np.pad(region.astype(np.uint8), 1)
    cv2.floodFill(canvas, None, (0, 0), 2, flags=4)
    return np.asarray(canvas[1:-1, 1:-1] == 2)


def _rims(region: Mask) -> list[Ints]:
    """(n, 2) columns and rows of the pixels around each part of a region, in order."""
    found, _ = cv2.findContours(region.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    rims = [rim[:, 0, :].astype(np.int64) for rim in found if len(rim) >= 3]
    if not rims:
        raise OpenOutlineError("it encloses less than a pixel")
    return rims


def _smoothed(rim: Ints) -> Floats:
    return np.asarray(gaussian_filter1d(rim.astype(np.float64), _SMOOTHING, axis=0, mode="wrap"))


def _normals(rim: Ints) -> Floats:
    """Unit normals, outwards, of a rim as OpenCV walks it."""
    smooth = gaussian_filter1d(rim.astype(np.float64), 2 * _SMOOTHING, axis=0, mode="wrap")
    along = np.roll(smooth, -1, axis=0) - np.roll(smooth, 1, axis=0)
    across = np.stack([along[:, 1], -along[:, 0]], axis=1)
    # Either way round: the sign is that of the enclosed area.
    u, v = smooth.T
    if float(np.sum(u * np.roll(v, -1) - v * np.roll(u, -1))) < 0.0:
        across = -across
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9))
