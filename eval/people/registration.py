"""A scan or photo of a drawing on paper, laid straight over the picture that was drawn.

A page is flat, so a homography takes it to the picture: by marks around the drawing, by a printed frame, by the sheet's
edges, or by the rendering that was printed with it: by its features, or where it has few, by its silhouette.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

from eval.people.outline import DrawnOutline, filled
from eval.people.page_marks import NoCornersError, frame_corners, mark_corners, page_corners
from eval.people.paper import paper_brightness, pencil_ink
from ncmodel.errors import ArgumentError
from ncmodel.types import Floats, Image, Mask

CORNERS: Mapping[str, Callable[[Image], Floats]] = {
    "marks": mark_corners,
    "frame": frame_corners,
    "page": page_corners,
}
"""Ways to find the picture's four corners in a scan."""
WAYS = (*CORNERS, "rendering")

_RIMS = {"marks": 0.05, "frame": 0.012, "page": 0.012, "rendering": 0.0}
"""Share of the shorter side, at the corners or all around, where what was registered by may be seen."""

_FEATURES = 4000
_RATIO = 0.8
"""A feature's best match must be this much closer than its second best (Lowe 2004)."""
_FEWEST = 30
"""Matches on one homography from which on it is believed."""
_INLIER = 0.004
"""Share of the picture's diagonal that a match may be off."""
_SILHOUETTE = 0.02
"""Share of a silhouette's size that another may be off in the mean."""
_SILHOUETTE_STEPS = 30
_WIDEST = 0.6
"""Share of the shorter side that a printed object is wide at most."""
_SHADED = 0.95
"""Of the paper's brightness: what is darker over an area is printed."""
_FIRST_SIDE = 1024
"""Longer side of the scan in which silhouettes are first laid over each other."""

_HALF = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, 0.0, 1.0]])
"""Takes OpenCV's pixels, counted from the centre of the first, to ours."""


class NotRegisteredError(ValueError):
    """A scan that can't be laid over the picture."""


@dataclass(frozen=True, eq=False)
class Registration:
    """Where a picture lies in a scan.

    Attributes:
        way: One of `WAYS`.
        homography: (3, 3) takes u, v in the picture to the scan's.
        width: Of the picture, pixels.
        height: Of the picture, pixels.
        matches: Features that agree, where it was registered by a rendering.
        mm_per_pixel: Of the picture on the page, where that is known.
    """

    way: str
    homography: Floats
    width: int
    height: int
    matches: int | None = None
    mm_per_pixel: float | None = None

    def drawing(self, scan: Image) -> Image:
        """(height, width) ink of the drawing in a scan, 1 = line, without the marks or the frame at its rim."""
        ink = pencil_ink(self.straight(scan))
        rim = _RIMS[self.way] * min(self.width, self.height)
        u, v = np.arange(self.width) + 0.5, np.arange(self.height)[:, None] + 0.5
        across, down = np.minimum(u, self.width - u), np.minimum(v, self.height - v)
        reached = np.hypot(across, down) if self.way == "marks" else np.minimum(across, down)
        return np.where(reached <= rim, 0.0, ink).astype(np.float32)

    def straight(self, scan: Image) -> Image:
        """(height, width) what the scan shows of the picture, each pixel the mean of what it covers."""
        # Where a pixel covers many of the scan's, a blur keeps thin lines from falling between samples.
        shrinking = math.sqrt(abs(np.linalg.det(self.homography[:2, :2]))) / self.homography[2, 2]
        calm = cv2.GaussianBlur(scan, (0, 0), 0.35 * shrinking) if shrinking > 1.5 else scan
        mapping = np.linalg.inv(_HALF) @ self.homography @ _HALF
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        size = (self.width, self.height)
        return np.asarray(cv2.warpPerspective(calm, mapping, size, flags=flags, borderMode=cv2.BORDER_REPLICATE))


def by_corners(scan: Image, way: str, size: tuple[int, int], millimetres: float | None = None) -> Registration:
    """Register a scan by the four corners of its picture.

    Args:
        scan: (H, W) brightness.
        way: "marks", "frame" or "page".
        size: (width, height) of the picture, pixels.
        millimetres: How wide the picture is on the page.

    Raises:
        NotRegisteredError: There are no such corners.
    """
    width, height = size
    try:
        corners = CORNERS[way](scan)
    except NoCornersError as error:
        raise NotRegisteredError(str(error)) from error
    picture = np.array([[0, 0], [width, 0], [width, height], [0, height]], dtype=np.float32)
    homography = np.asarray(cv2.getPerspectiveTransform(picture, corners.astype(np.float32)), dtype=np.float64)
    _check_aspect(corners, width / height, way)
    return Registration(way, homography, width, height, None, None if millimetres is None else millimetres / width)


def by_rendering(
    scan: Image, rendering: Image, place: tuple[float, float] = (0.0, 0.0), millimetres: float | None = None
) -> Registration:
    """Register a scan by a rendering that was printed on the page, below the drawing or beside it.

    Args:
        scan: (H, W) brightness.
        rendering: (h, w) what was printed, of the picture's size.
        place: Where the drawing's picture begins, in pixels of the rendering from its upper left corner: 0, 0 where it
            was drawn over the print; the rendering's width, 0 where it was drawn just right of it.
        millimetres: How wide the rendering is on the page.

    Raises:
        NotRegisteredError: The rendering isn't found.
    """
    height, width = rendering.shape
    matching = _by_features(scan, rendering)
    homography = _by_silhouette(scan, rendering) if matching is None else matching[0]
    if homography is None:
        raise NotRegisteredError("the rendering isn't found in it, neither by features nor by its silhouette")
    shift = np.array([[1.0, 0.0, place[0]], [0.0, 1.0, place[1]], [0.0, 0.0, 1.0]])
    scale = None if millimetres is None else millimetres / width
    return Registration("rendering", homography @ shift, width, height, matching and matching[1], scale)


def turned(scan: Image, degrees: int) -> Image:
    """A scan turned clockwise by quarters.

    Raises:
        ArgumentError: It isn't a multiple of 90.
    """
    if degrees % 90:
        raise ArgumentError("turn", str(degrees), "0, 90, 180 or 270")
    return np.ascontiguousarray(np.rot90(scan, -(degrees // 90)))


def _check_aspect(corners: Floats, aspect: float, way: str) -> None:
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    found = float((sides[0] + sides[2]) / (sides[1] + sides[3]))
    if not 0.8 <= found / aspect <= 1.25:
        raise NotRegisteredError(
            f"the {way} found is {found:.2f} times as wide as high, and the picture {aspect:.2f}: turned, or not it"
        )


def _by_features(scan: Image, rendering: Image) -> tuple[Floats, int] | None:
    """The homography from the rendering to the scan on which most matching features agree, and how many do."""
    # Large scans hold nothing more for features of a rendering's size. What was drawn over the print is none of it.
    factor = min(1.0, 2.0 * max(rendering.shape) / max(scan.shape))
    small = _smaller(scan, factor)
    detector = cv2.SIFT.create(nfeatures=_FEATURES)
    prints = (np.rint(255 * np.clip(paper_brightness(image), 0, 1)).astype(np.uint8) for image in (rendering, small))
    places, described = zip(*(detector.detectAndCompute(image, None) for image in prints), strict=True)
    if any(found is None or len(found) < _FEWEST for found in described):
        return None
    pairs = cv2.BFMatcher(cv2.NORM_L2).knnMatch(described[0], described[1], k=2)
    good = [pair[0] for pair in pairs if len(pair) == 2 and pair[0].distance < _RATIO * pair[1].distance]
    if len(good) < _FEWEST:
        return None
    # Keypoints count from the centre of the first pixel.
    here = np.array([places[0][match.queryIdx].pt for match in good], dtype=np.float64) + 0.5
    there = (np.array([places[1][match.trainIdx].pt for match in good], dtype=np.float64) + 0.5) / factor
    tolerance = _INLIER * math.hypot(*rendering.shape)
    cv2.setRNGSeed(0)
    homography, inliers = cv2.findHomography(there, here, cv2.USAC_MAGSAC, tolerance, maxIters=5000)
    if homography is None or inliers.sum() < _FEWEST:
        return None
    return np.asarray(np.linalg.inv(homography), dtype=np.float64), int(inliers.sum())


def _smaller(scan: Image, factor: float) -> Image:
    if factor >= 1.0:
        return scan
    return np.asarray(cv2.resize(scan, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA), dtype=np.float32)


def _by_silhouette(scan: Image, rendering: Image) -> Floats | None:
    """The homography that lays the rendered object's silhouette over what is printed in the scan, or `None`.

    Begun from place and size in several rolls; then points of the silhouette are moved onto the printed one's outline
    by Gauss-Newton steps, as in `eval.people.camera_fit`. Last, in the picture's own size: there the two outlines are
    cut out alike, and what is off in both is off in neither.
    """
    drawn = _object(rendering)
    factor = min(1.0, _FIRST_SIDE / max(scan.shape))
    small = _smaller(scan, factor)
    printed = _object(small)
    if drawn is None or printed is None:
        return None
    goal, points = DrawnOutline.of(printed), DrawnOutline.of(drawn).points[::2]
    fits = [_laid_over(goal, points, start) for start in _similar(drawn, printed)]
    off, best = min(fits, key=lambda fit: fit[0])
    if off > _SILHOUETTE * math.sqrt(float(printed.sum())):
        return None
    homography = np.diag([1 / factor, 1 / factor, 1.0]) @ best
    for _ in range(2):
        near = Registration("rendering", homography, rendering.shape[1], rendering.shape[0]).straight(scan)
        straight = _object(near)
        if straight is not None:
            homography = homography @ _laid_over(DrawnOutline.of(straight), points, np.eye(3))[1]
    return np.asarray(homography / homography[2, 2])


def _object(image: Image) -> Mask | None:
    """(H, W) the thing in a picture that is most of it darker than the paper around; holes filled."""
    calm = cv2.GaussianBlur(image, (0, 0), 1.5)
    kernel = np.ones((2 * round(_WIDEST * min(calm.shape) / 2) + 1,) * 2, np.uint8)
    # Light that falls off is closed to itself, a thing on paper to the paper.
    around = cv2.morphologyEx(calm, cv2.MORPH_CLOSE, kernel, borderType=cv2.BORDER_REPLICATE)
    darker = (calm < _SHADED * around).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(darker, connectivity=8)
    inside = [n for n in range(1, len(stats)) if _within(stats[n], image.shape)]
    largest = max(inside, key=lambda n: int(stats[n, cv2.CC_STAT_AREA]), default=0)
    if largest == 0 or stats[largest, cv2.CC_STAT_AREA] < 0.003 * darker.size:
        return None
    return filled(labels == largest)


def _within(stat: Floats, shape: tuple[int, ...]) -> bool:
    left, top, width, height = (int(stat[key]) for key in range(4))
    return left > 0 and top > 0 and left + width < shape[1] and top + height < shape[0]


def _similar(drawn: Mask, printed: Mask) -> list[Floats]:
    """Homographies that bring a region to another's place and size, turned by all of 24 angles."""
    (here, size), (there, other) = (_moments(region) for region in (drawn, printed))
    found = []
    for angle in np.arange(24) * math.pi / 12:
        c, s = math.cos(angle) * other / size, math.sin(angle) * other / size
        linear = np.array([[c, -s], [s, c]])
        found.append(np.vstack([np.column_stack([linear, there - linear @ here]), [0.0, 0.0, 1.0]]))
    return found


def _moments(region: Mask) -> tuple[Floats, float]:
    """The mean u, v of a region's pixels and their root mean square distance from it."""
    rows, columns = np.nonzero(region)
    points = np.stack([columns, rows], axis=1) + 0.5
    return points.mean(axis=0), float(np.sqrt(np.sum(points.var(axis=0))))


def _laid_over(goal: DrawnOutline, points: Floats, start: Floats) -> tuple[float, Floats]:
    """How far points are from an outline in the mean, and the homography near `start` that brings them there."""
    down, right = np.gradient(goal.distance)
    limit = np.array(goal.distance.shape[::-1]) - 1.0
    # In units of the region's size about its middle, all eight numbers matter alike.
    middle, size = points.mean(axis=0), float(points.std())
    unit = np.array([[1 / size, 0.0, -middle[0] / size], [0.0, 1 / size, -middle[1] / size], [0.0, 0.0, 1.0]])
    homography = start @ np.linalg.inv(unit)
    homogeneous = np.column_stack([(points - middle) / size, np.ones(len(points))])
    off = math.inf
    for step in range(_SILHOUETTE_STEPS):
        moved = homogeneous @ homography.T
        places = moved[:, :2] / moved[:, 2:]
        inside = np.clip(places - 0.5, 0.0, limit)
        residuals, u, v = (map_coordinates(f, inside.T[::-1], order=1) for f in (goal.distance, right, down))
        off = float(np.abs(residuals).mean() + np.linalg.norm(places - 0.5 - inside, axis=1).mean())
        by_u, by_v = (homogeneous * (slope / moved[:, 2])[:, None] for slope in (u, v))
        by_w = -(homogeneous * ((u * places[:, 0] + v * places[:, 1]) / moved[:, 2])[:, None])[:, :2]
        jacobian = np.column_stack([by_u, by_v, by_w])
        free = 6 if step < _SILHOUETTE_STEPS // 2 else 8  # perspective comes last: it bends what is far off too much
        weight = 1 / np.sqrt(1 + (residuals / (2.0 + np.median(np.abs(residuals)))) ** 2)
        normal = jacobian[:, :free].T @ (weight[:, None] * jacobian[:, :free])
        damped = normal + 1e-4 * np.diag(np.diag(normal)) + 1e-9 * np.eye(free)
        change = np.zeros(9)
        change[:free] = -np.linalg.solve(damped, jacobian[:, :free].T @ (weight * residuals))
        homography = homography + change.reshape(3, 3)
    return off, homography @ unit
