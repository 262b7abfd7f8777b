"""Where a drawing's picture lies on a scanned page: four marks, a printed frame, or the paper's own edges.

Corners come in the order upper left, upper right, lower right, lower left of the scan; pixels, u to the right and v
down, the first pixel's centre at (0.5, 0.5).
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

from eval.people.paper import line_darkness
from ncmodel.types import Floats, Image, Mask

_LEAST_AREA = 0.15
"""Share of the scan that the four corners enclose at least."""
_MARK_AREAS = (2e-5, 6e-3)
"""Share of the scan that a mark covers."""
_MARK_FILL = 0.6
"""Share of its bounding box that a mark covers at least; a disc covers 0.79, a square standing on its corner 0.5."""
_MOST_CANDIDATES = 14
_SAMPLES = 160
"""Places along a side where a frame is measured."""
_AWAY = 0.06
"""Share of a side at its ends that isn't measured, for the other side is there."""
_REACH = 0.012
"""Share of the scan's diagonal to either side of a frame's first guess that is searched."""


class NoCornersError(ValueError):
    """The scan has no such marks."""


def mark_corners(brightness: Image) -> Floats:
    """(4, 2) the middles of four filled marks, discs or squares, of about one size.

    Raises:
        NoCornersError: There are none.
    """
    # Marks are wider than lines: the paper is what is left if they, too, are closed.
    side = min(brightness.shape)
    size = 2 * round(0.06 * side) + 1
    paper = cv2.morphologyEx(
        cv2.GaussianBlur(brightness, (0, 0), 1.5), cv2.MORPH_CLOSE, np.ones((size, size), np.uint8)
    )
    darkness = np.clip(1.0 - brightness / np.maximum(paper, 0.02), 0.0, 1.0).astype(np.float32)
    _, labels, stats, _ = cv2.connectedComponentsWithStats((darkness > 0.5).astype(np.uint8), connectivity=8)
    found = [n for n in range(1, len(stats)) if _is_mark(stats[n], brightness.size) and _on_paper(brightness, stats[n])]
    found = sorted(found, key=lambda n: -stats[n, cv2.CC_STAT_AREA])[:_MOST_CANDIDATES]
    middles = {n: _centroid(darkness, labels == n, stats[n]) for n in found}
    best, largest = None, _LEAST_AREA * brightness.size
    for four in combinations(found, 4):
        areas = [stats[n, cv2.CC_STAT_AREA] for n in four]
        corners = _ordered(np.array([middles[n] for n in four]))
        if max(areas) <= 2.5 * min(areas) and _convex(corners) and (size_ := _area(corners)) > largest:
            best, largest = corners, size_
    if best is None:
        raise NoCornersError(f"{len(found)} filled marks, not four of one size around the drawing")
    return best


def frame_corners(brightness: Image) -> Floats:
    """(4, 2) the corners of a printed rectangle, in the middle of its line.

    Raises:
        NoCornersError: There is none.
    """
    darkness = line_darkness(brightness)
    grown = cv2.dilate((darkness > 0.2).astype(np.uint8), np.ones((3, 3), np.uint8))
    contours, _ = cv2.findContours(grown, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    for guess in _quadrilaterals(contours, brightness.size):
        corners = _refined(darkness, guess)
        if _is_line(brightness, darkness, corners):
            return corners
    raise NoCornersError("no printed rectangle around the drawing")


def page_corners(brightness: Image) -> Floats:
    """(4, 2) the corners of a sheet of paper that lies on something darker.

    Raises:
        NoCornersError: No sheet's four edges are in the scan.
    """
    calm = cv2.GaussianBlur(brightness, (0, 0), max(1.0, 0.002 * min(brightness.shape)))
    levels = np.clip(np.rint(255 * calm), 0, 255).astype(np.uint8)
    _, bright = cv2.threshold(levels, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    contours, _ = cv2.findContours(bright, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    guess = next(iter(_quadrilaterals(contours, brightness.size)), None)
    height, width = brightness.shape
    if guess is None or not (guess.min() > 2.0 and (guess < [width - 2.0, height - 2.0]).all()):
        raise NoCornersError("no sheet of paper with its four edges in it")
    slope = np.hypot(cv2.Sobel(calm, cv2.CV_32F, 1, 0), cv2.Sobel(calm, cv2.CV_32F, 0, 1))
    return _refined(np.asarray(slope, dtype=np.float32), guess)


def _is_mark(stat: Floats, pixels: int) -> bool:
    area, width, height = (float(stat[key]) for key in (cv2.CC_STAT_AREA, cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT))
    low, high = (share * pixels for share in _MARK_AREAS)
    return (
        low <= area <= high and max(width, height) <= 2.0 * min(width, height) and area >= _MARK_FILL * width * height
    )


def _on_paper(brightness: Image, stat: Floats) -> bool:
    """Whether what surrounds a mark is bright all around: a wedge between a page and its ground isn't a mark."""
    left, top, width, height = (int(stat[key]) for key in range(4))
    aside = 4 + max(width, height) // 8
    rows = slice(top - aside, top + height + aside)
    columns = slice(left - aside, left + width + aside)
    if min(rows.start, columns.start) < 0 or rows.stop > brightness.shape[0] or columns.stop > brightness.shape[1]:
        return False
    around = brightness[rows, columns]
    rim = np.concatenate([around[0], around[-1], around[:, 0], around[:, -1]])
    return bool(np.percentile(rim, 5) > 0.65 * np.percentile(rim, 95))


def _centroid(darkness: Image, mask: Mask, stat: Floats) -> Floats:
    """The middle of a mark's darkness, its soft edge included."""
    left, top = max(0, int(stat[cv2.CC_STAT_LEFT]) - 3), max(0, int(stat[cv2.CC_STAT_TOP]) - 3)
    part = (
        slice(top, int(stat[cv2.CC_STAT_TOP] + stat[cv2.CC_STAT_HEIGHT]) + 3),
        slice(left, int(stat[cv2.CC_STAT_LEFT] + stat[cv2.CC_STAT_WIDTH]) + 3),
    )
    near = cv2.dilate(mask[part].astype(np.uint8), np.ones((5, 5), np.uint8))
    weight = np.clip(darkness[part] - 0.1, 0.0, None) * near
    rows, columns = np.mgrid[: weight.shape[0], : weight.shape[1]] + 0.5
    total = weight.sum()
    return np.array([left + (columns * weight).sum() / total, top + (rows * weight).sum() / total])


def _quadrilaterals(contours: Sequence[Any], pixels: int) -> Iterator[Floats]:
    """The corners of the convex quadrilaterals among contours, the largest first."""
    for contour in sorted(contours, key=cv2.contourArea, reverse=True)[:20]:
        # A page may have a hand on it, a frame a gap: their hulls haven't.
        hull = cv2.convexHull(contour)
        for share in (0.01, 0.02, 0.04):
            corners = cv2.approxPolyDP(hull, share * cv2.arcLength(hull, True), True)[:, 0, :]
            if len(corners) == 4:
                ordered = _ordered(corners.astype(np.float64) + 0.5)
                if _convex(ordered) and _area(ordered) > _LEAST_AREA * pixels:
                    yield ordered
                break


def _is_line(brightness: Image, darkness: Image, corners: Floats) -> bool:
    """Whether a quadrilateral's sides are dark lines on one paper, and not where two things meet."""
    aside = _REACH * float(np.hypot(*brightness.shape))
    sound = []
    for begin, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = (end - begin) / np.linalg.norm(end - begin)
        across = np.array([-along[1], along[0]])
        places = begin + np.linspace(_AWAY, 1 - _AWAY, _SAMPLES)[:, None] * (end - begin)
        inner, outer = (_values(brightness, places + side * aside * across) for side in (1, -1))
        alike = np.minimum(inner, outer) >= 0.7 * np.maximum(inner, outer)
        sound.append(float((alike & (_values(darkness, places) > 0.1)).mean()))
    return min(sound) >= 0.6


def _values(image: Image, places: Floats) -> Floats:
    """An image's values between its pixels, 0 beyond it."""
    return np.asarray(map_coordinates(image, (places - 0.5).T[::-1], order=1, mode="constant"))


def _refined(weight: Image, corners: Floats) -> Floats:
    """Corners where the straight lines meet on which `weight` is heaviest near a quadrilateral's sides."""
    reach = max(4.0, _REACH * float(np.hypot(*weight.shape)))
    lines = []
    for begin, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = (end - begin) / np.linalg.norm(end - begin)
        across = np.array([-along[1], along[0]])
        places = begin + np.linspace(_AWAY, 1 - _AWAY, _SAMPLES)[:, None] * (end - begin)
        points = places
        for width in (reach, max(3.0, reach / 3)):
            steps = np.arange(-width, width + 0.25, 0.5)
            sampled = points[:, None, :] + steps[None, :, None] * across
            values = map_coordinates(weight, (sampled - 0.5).transpose(2, 0, 1)[::-1], order=1, mode="constant")
            # Only around the heaviest place: another line may be near.
            peak = steps[values.argmax(axis=1)]
            near = np.abs(steps[None, :] - peak[:, None]) <= max(2.5, width / 4)
            mass = (values * near).sum(axis=1)
            offset = (values * near * steps).sum(axis=1) / np.maximum(mass, 1e-9)
            sound = mass > 0.3 * np.median(mass)
            middle, along = _line_through(points[sound] + offset[sound, None] * across)
            across = np.array([-along[1], along[0]])
            points = middle + ((places - middle) @ along)[:, None] * along
        lines.append((middle, along))
    meet = [_meeting(lines[n - 1], lines[n]) for n in range(4)]
    return np.array(meet)


def _line_through(points: Floats) -> tuple[Floats, Floats]:
    """A point and the unit direction of a straight line through points, few of which may lie anywhere."""
    vx, vy, x, y = (float(v) for v in cv2.fitLine(points.astype(np.float32), cv2.DIST_HUBER, 0, 0.001, 0.001).ravel())
    return np.array([x, y]), np.array([vx, vy])


def _meeting(first: tuple[Floats, Floats], second: tuple[Floats, Floats]) -> Floats:
    along = np.linalg.solve(np.column_stack([first[1], -second[1]]), second[0] - first[0])
    return np.asarray(first[0] + along[0] * first[1])


def _ordered(corners: Floats) -> Floats:
    """Corners clockwise as seen, the upper left first."""
    middle = corners.mean(axis=0)
    angle = np.arctan2(corners[:, 1] - middle[1], corners[:, 0] - middle[0])
    clockwise = corners[np.argsort(angle)]
    return np.roll(clockwise, -int(np.argmin(clockwise.sum(axis=1))), axis=0)


def _convex(corners: Floats) -> bool:
    return bool(cv2.isContourConvex(corners.astype(np.float32).reshape(-1, 1, 2)))


def _area(corners: Floats) -> float:
    return float(cv2.contourArea(corners.astype(np.float32)))
