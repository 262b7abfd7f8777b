"""Smooth paths: polylines as cubic Bezier curves that stray little from them.

After Schneider, "An Algorithm for Automatically Fitting Digitized Curves" (Graphics Gems, 1990): between corners, one
curve by least squares whose ends point along the polyline; where it strays, its points are assigned anew a few times,
and then it is parted at the worst of them.
"""

import math
from dataclasses import dataclass

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, Mask

CORNER = math.cos(math.radians(40.0))
"""Where a polyline turns by more, no curve goes round."""
SPACING = 2.0
"""Pixels between the points, at most, that a curve is fitted to."""
ASSIGNMENTS = 4
"""How often points are assigned to places on a curve anew before it is parted."""
REACH = 3.0
"""Pixels along a polyline over which its direction at a point is taken."""
ROUNDED = 0.4
"""Share of the tolerance that rounding may take: fewer digits save more than fewer curves."""


@dataclass(frozen=True, eq=False)
class Path:
    """Straight lines and cubic curves, each from where the last one ended, in parts of a pixel.

    Attributes:
        points: (m, 4, 2) control points of each, int64; those of a straight line lie near it.
        straight: (m,) which are straight lines.
    """

    points: Ints
    straight: Mask

    def svg(self) -> str:
        """As SVG's path data: relative coordinates, a letter only where the kind changes."""
        u, v = self.points[0, 0].tolist()
        parts, kind = [f"M{u} {v}"], ""
        for control, straight in zip(self.points, self.straight.tolist(), strict=True):
            steps = (control[3:] if straight else control[1:]) - control[0]
            letter = "l" if straight else "c"
            text = "".join(f"{value}" if value < 0 else f" {value}" for value in steps.ravel().tolist())
            parts.append(letter + text.lstrip() if letter != kind else text)
            kind = letter
        return "".join(parts)

    def pdf(self) -> str:
        """As PDF's operators."""
        u, v = self.points[0, 0].tolist()
        parts = [f"{u} {v} m"]
        for control, straight in zip(self.points, self.straight.tolist(), strict=True):
            values = control[3:] if straight else control[1:]
            parts += [*map(str, values.ravel().tolist()), "l" if straight else "c"]
        return " ".join(parts)


def parts_of(tolerance: float) -> int:
    """Into how many parts a pixel is divided where paths may stray by a tolerance; 1, 10, 100, ..."""
    # Rounding moves a point by half a part in both directions.
    return int(10 ** max(math.ceil(-math.log10(math.sqrt(2.0) * ROUNDED * tolerance)), 0))


def fitted(points: Floats, tolerance: float) -> Path:
    """A path along a polyline, in `parts_of` the tolerance.

    Args:
        points: (n, 2) of the polyline, two or more.
        tolerance: Pixels that the path strays from it at most, and it from the path.
    """
    parts = parts_of(tolerance)
    dense, own = _densely(points, SPACING)
    control, straight = _fit(dense, np.flatnonzero(_corners(dense, own)), tolerance - math.sqrt(0.5) / parts)
    return Path(np.round(control * parts).astype(np.int64), straight)


def _densely(points: Floats, spacing: float) -> tuple[Floats, Mask]:
    """Points at most `spacing` apart on a polyline, its own among them; and which are its own."""
    count = np.maximum(np.ceil(np.linalg.norm(np.diff(points, axis=0), axis=1) / spacing), 1).astype(np.int64)
    first = np.concatenate([[0], np.cumsum(count)])
    owner = np.repeat(np.arange(len(count)), count)
    share = ((np.arange(first[-1]) - first[owner]) / count[owner])[:, None]
    dense = np.concatenate([points[owner] * (1 - share) + points[owner + 1] * share, points[-1:]])
    own = np.zeros(len(dense), dtype=np.bool_)
    own[first] = True
    return dense, own


@kernel
def _corners(points: Floats, own: Mask) -> Mask:
    """Where a polyline turns sharply; its ends, too."""
    found = np.zeros(len(points), np.bool_)
    found[0] = found[-1] = True
    for i in range(1, len(points) - 1):
        if own[i]:
            x, y = points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1]
            u, v = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
            found[i] = x * u + y * v < CORNER * math.sqrt((x * x + y * y) * (u * u + v * v))
    return found


@kernel
def _fit(points: Floats, corners: Ints, tolerance: float) -> tuple[Floats, Mask]:
    """Control points of the curves, and which of them are straight."""
    control, straight = [(0.0, 0.0) for _ in range(0)], [False for _ in range(0)]
    is_corner = np.zeros(len(points), np.bool_)
    is_corner[corners] = True
    place, curve = np.empty(len(points)), np.empty((4, 2))
    spans = [(corners[n], corners[n + 1]) for n in range(len(corners) - 2, -1, -1)]
    while spans:
        a, b = spans.pop()
        plain = b == a + 1 or _off_chord(points, a, b) <= tolerance
        worst = -1
        if not plain:
            start, end = _direction(points, a, 1, is_corner), _direction(points, b, -1, is_corner)
            _assign_by_length(points, a, b, place)
            for _ in range(ASSIGNMENTS):
                _least_squares(points, a, b, place, start, end, curve)
                worst, off = _farthest(points, a, b, place, curve)
                if off <= tolerance:
                    worst = -1
                    break
                _assign_anew(points, a, b, place, curve)
        if worst >= 0:
            spans.append((worst, b))
            spans.append((a, worst))
            continue
        for c in range(4):
            if plain:
                x = points[a, 0] + c / 3.0 * (points[b, 0] - points[a, 0])
                y = points[a, 1] + c / 3.0 * (points[b, 1] - points[a, 1])
                control.append((x, y))
            else:
                control.append((curve[c, 0], curve[c, 1]))
        straight.append(plain)
    return np.array(control).reshape(-1, 4, 2), np.array(straight)


@kernel
def _off_chord(points: Floats, a: int, b: int) -> float:
    """How far points a to b are from the straight line between them, its ends included."""
    dx, dy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    square, off = max(dx * dx + dy * dy, 1e-300), 0.0
    for i in range(a + 1, b):
        x, y = points[i, 0] - points[a, 0], points[i, 1] - points[a, 1]
        along = min(max((x * dx + y * dy) / square, 0.0), 1.0)
        off = max(off, math.hypot(x - along * dx, y - along * dy))
    return off


@kernel
def _direction(points: Floats, i: int, forward: int, is_corner: Mask) -> tuple[float, float]:
    """The unit vector along which a curve leaves point i, forwards (1) or backwards (-1).

    On both sides of a point that is no corner it is the same line, so that curves go on smoothly there.
    """
    ahead, behind = i, i
    for way in (forward, -forward):
        j, length = i, 0.0
        while length < REACH and 0 <= j + way < len(points):
            if way == -forward and is_corner[i]:
                break
            step = math.hypot(points[j + way, 0] - points[j, 0], points[j + way, 1] - points[j, 1])
            j, length = j + way, length + step
            if is_corner[j]:
                break
        if way == forward:
            ahead = j
        else:
            behind = j
    x, y = points[ahead, 0] - points[behind, 0], points[ahead, 1] - points[behind, 1]
    length = max(math.hypot(x, y), 1e-300)
    return x / length, y / length


@kernel
def _assign_by_length(points: Floats, a: int, b: int, place: Floats) -> None:
    """Places of points a to b on their curve, 0 to 1, by the length of the polyline."""
    place[a] = 0.0
    for i in range(a + 1, b + 1):
        place[i] = place[i - 1] + math.hypot(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1])
    for i in range(a + 1, b + 1):
        place[i] /= max(place[b], 1e-300)
    place[b] = 1.0


@kernel
def _least_squares(
    points: Floats,
    a: int,
    b: int,
    place: Floats,
    start: tuple[float, float],
    end: tuple[float, float],
    curve: Floats,
) -> None:
    """The curve from point a to b along two directions that is nearest to the points at their places."""
    c00, c01, c11, x0, x1 = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(a, b + 1):
        t = place[i]
        s = 1.0 - t
        inner, outer = 3.0 * t * s * s, 3.0 * t * t * s
        first, last = s * s * s + inner, t * t * t + outer
        ax, ay, bx, by = start[0] * inner, start[1] * inner, end[0] * outer, end[1] * outer
        u = points[i, 0] - first * points[a, 0] - last * points[b, 0]
        v = points[i, 1] - first * points[a, 1] - last * points[b, 1]
        c00, c01, c11 = c00 + ax * ax + ay * ay, c01 + ax * bx + ay * by, c11 + bx * bx + by * by
        x0, x1 = x0 + ax * u + ay * v, x1 + bx * u + by * v
    chord = math.hypot(points[b, 0] - points[a, 0], points[b, 1] - points[a, 1])
    determinant = c00 * c11 - c01 * c01
    one = other = 0.0
    if abs(determinant) > 1e-12 * max(c00 * c11, 1e-300):
        one, other = (x0 * c11 - x1 * c01) / determinant, (c00 * x1 - c01 * x0) / determinant
    # Handles that point backwards, or hardly anywhere, would make a loop or a cusp.
    if not (one > 1e-3 * chord and other > 1e-3 * chord):
        one = other = chord / 3.0
    for k in range(2):
        curve[0, k], curve[3, k] = points[a, k], points[b, k]
        curve[1, k], curve[2, k] = points[a, k] + one * start[k], points[b, k] + other * end[k]


@kernel
def _at(curve: Floats, t: float) -> tuple[float, float]:
    """The point of a cubic curve at a place."""
    s = 1.0 - t
    p, q, r, w = s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t
    return (
        p * curve[0, 0] + q * curve[1, 0] + r * curve[2, 0] + w * curve[3, 0],
        p * curve[0, 1] + q * curve[1, 1] + r * curve[2, 1] + w * curve[3, 1],
    )


@kernel
def _farthest(points: Floats, a: int, b: int, place: Floats, curve: Floats) -> tuple[int, float]:
    """The inner point that is farthest from its place, and how far polyline and curve are apart at most.

    Between two places the curve is held against the straight line between their points.
    """
    worst, most, off = a + 1, -1.0, 0.0
    for i in range(a, b):
        x, y = _at(curve, place[i])
        here = math.hypot(points[i, 0] - x, points[i, 1] - y)
        u, v = _at(curve, (place[i] + place[i + 1]) / 2.0)
        dx, dy = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
        x, y = u - points[i, 0], v - points[i, 1]
        along = min(max((x * dx + y * dy) / max(dx * dx + dy * dy, 1e-300), 0.0), 1.0)
        here = max(here, math.hypot(x - along * dx, y - along * dy))
        off = max(off, here)
        if here > most and i > a:
            worst, most = i, here
    return worst, off


@kernel
def _assign_anew(points: Floats, a: int, b: int, place: Floats, curve: Floats) -> None:
    """One step of Newton's for each inner point towards the place on the curve that is nearest to it, in order."""
    for i in range(a + 1, b):
        t = place[i]
        s = 1.0 - t
        x, y = _at(curve, t)
        x, y = x - points[i, 0], y - points[i, 1]
        d = np.empty(2)
        e = np.empty(2)
        for k in range(2):
            p, q, r, w = curve[0, k], curve[1, k], curve[2, k], curve[3, k]
            d[k] = 3.0 * (s * s * (q - p) + 2.0 * s * t * (r - q) + t * t * (w - r))
            e[k] = 6.0 * (s * (r - 2.0 * q + p) + t * (w - 2.0 * r + q))
        slope = d[0] * d[0] + d[1] * d[1] + x * e[0] + y * e[1]
        if slope > 0.0:
            t -= (x * d[0] + y * d[1]) / slope
        place[i] = min(max(t, place[i - 1]), 1.0)
