"""Parts to sculpt with: signed distances, negative inside, each with the box that it fills.

Frames are (3, 3) rotations whose rows are a part's own axes, so that `(points - centre) @ frame.T` are its coordinates.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ncmodel.types import Floats

Distance = Callable[[Floats], Floats]
"""Signed distance of (n, 3) points."""

UPRIGHT: Floats = np.eye(3)


@dataclass(frozen=True)
class Part:
    """A piece of a sculpture.

    Attributes:
        distance: Its signed distance, near enough to a true one by its surface.
        low: (3,) lower corner of the box that it fills.
        high: (3,) upper corner.
    """

    distance: Distance
    low: Floats
    high: Floats


def frame(yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0) -> Floats:
    """Axes turned about y (yaw), then their own x (pitch), then their own z (roll), in radians."""
    (a, b, c), (d, e, f) = np.cos([yaw, pitch, roll]), np.sin([yaw, pitch, roll])
    about_y = np.array([[a, 0, d], [0, 1, 0], [-d, 0, a]])
    about_x = np.array([[1, 0, 0], [0, b, -e], [0, e, b]])
    about_z = np.array([[c, -f, 0], [f, c, 0], [0, 0, 1]])
    return np.asarray((about_y @ about_x @ about_z).T)


def frame_along(direction: ArrayLike, roll: float = 0.0) -> Floats:
    """Axes whose y points along a direction."""
    y = np.asarray(direction, dtype=float)
    y = y / np.linalg.norm(y)
    side = np.array([0.0, 0.0, 1.0]) if abs(y[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    x = np.cross(y, side)
    x /= np.linalg.norm(x)
    z = np.cross(x, y)
    turned_x, turned_z = np.cos(roll) * x + np.sin(roll) * z, np.cos(roll) * z - np.sin(roll) * x
    return np.stack([turned_x, y, turned_z])


def _boxed(local: Distance, centre: ArrayLike, half: ArrayLike, axes: Floats) -> Part:
    """A part given in its own axes, which fills a box of half sides `half` about its centre."""
    middle = np.asarray(centre, dtype=float)
    reach = np.abs(axes.T) @ np.asarray(half, dtype=float)
    return Part(lambda points: local((points - middle) @ axes.T), middle - reach, middle + reach)


def ellipsoid(centre: ArrayLike, radii: ArrayLike, axes: Floats = UPRIGHT) -> Part:
    """An ellipsoid; its distance is Quilez's estimate, exact on the surface."""
    r = np.broadcast_to(np.asarray(radii, dtype=float), (3,))

    def distance(points: Floats) -> Floats:
        scaled = points / r
        k0 = np.linalg.norm(scaled, axis=1)
        k1 = np.linalg.norm(scaled / r, axis=1)
        return np.asarray(k0 * (k0 - 1.0) / np.maximum(k1, 1e-9))

    return _boxed(distance, centre, r, axes)


def slab(centre: ArrayLike, half: ArrayLike, rounding: float = 0.0, axes: Floats = UPRIGHT) -> Part:
    """A box with rounded edges; `half` are its half sides, rounding included."""
    h = np.asarray(half, dtype=float)
    inner = np.maximum(h - rounding, 1e-4)

    def distance(points: Floats) -> Floats:
        q = np.abs(points) - inner
        return np.asarray(np.linalg.norm(np.maximum(q, 0.0), axis=1) + np.minimum(q.max(axis=1), 0.0) - rounding)

    return _boxed(distance, centre, h, axes)


def drum(start: ArrayLike, end: ArrayLike, radius: float, rounding: float = 0.0) -> Part:
    """A cylinder between two points, its rims rounded."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    half = float(np.linalg.norm(b - a)) / 2

    def distance(points: Floats) -> Floats:
        out = np.hypot(points[:, 0], points[:, 2]) - (radius - rounding)
        up = np.abs(points[:, 1]) - (half - rounding)
        outside = np.hypot(np.maximum(out, 0.0), np.maximum(up, 0.0))
        return np.asarray(outside + np.minimum(np.maximum(out, up), 0.0) - rounding)

    return _boxed(distance, (a + b) / 2, (radius, half, radius), frame_along(b - a))


def ring(centre: ArrayLike, axis: ArrayLike, radius: float, thickness: float) -> Part:
    """A torus around an axis."""

    def distance(points: Floats) -> Floats:
        out = np.hypot(points[:, 0], points[:, 2]) - radius
        return np.asarray(np.hypot(out, points[:, 1]) - thickness)

    reach = radius + thickness
    return _boxed(distance, centre, (reach, thickness, reach), frame_along(axis))


def limb(points: ArrayLike, radii: ArrayLike, flatten: float = 1.0, axes: Floats = UPRIGHT) -> Part:
    """A tube of changing thickness along a curve through points.

    Args:
        points: (k, 3) of the curve.
        radii: (k,) or one, thickness there.
        flatten: Thickness along the third of `axes` over that along the others.
        axes: Those that `flatten` means.
    """
    knots = np.asarray(points, dtype=float) @ axes.T
    width = np.broadcast_to(np.asarray(radii, dtype=float), len(knots))
    squash = np.array([1.0, 1.0, 1.0 / flatten])
    path, size = smooth_curve(knots * squash, 5), smooth_curve(width[:, None], 5)[:, 0]

    def distance(where: Floats) -> Floats:
        local = (where @ axes.T) * squash
        nearest = np.full(len(local), np.inf)
        for a, b, r, s in zip(path[:-1], path[1:], size[:-1], size[1:], strict=True):
            along = b - a
            t = np.clip((local - a) @ (along / max(float(along @ along), 1e-12)), 0.0, 1.0)
            gap = local - a - t[:, None] * along
            np.minimum(nearest, np.sqrt(np.einsum("ij,ij->i", gap, gap)) - r - t * (s - r), out=nearest)
        return nearest * min(flatten, 1.0)

    spread = (path / squash) @ axes
    reach = float(size.max()) * max(1.0, flatten)
    return Part(distance, spread.min(axis=0) - reach, spread.max(axis=0) + reach)


def smooth_curve(knots: Floats, steps: int) -> Floats:
    """Points along the centripetal cubic through (k, n) knots, `steps` to each span."""
    from scipy.interpolate import PchipInterpolator

    if len(knots) < 3:
        return knots
    place = np.arange(len(knots))
    return np.asarray(PchipInterpolator(place, knots)(np.linspace(0, len(knots) - 1, steps * (len(knots) - 1) + 1)))


def prism(
    outline: ArrayLike, half: float, centre: ArrayLike = (0, 0, 0), axes: Floats = UPRIGHT, rounding: float = 0.0
) -> Part:
    """A closed polygon in x and y drawn along z.

    Args:
        outline: (k, 2) corners.
        half: Half its length.
        centre: Where its origin lies.
        axes: Its own.
        rounding: Radius of its edges.
    """
    corners = np.asarray(outline, dtype=float)

    def distance(points: Floats) -> Floats:
        flat = polygon_distance(corners, points[:, :2]) + rounding
        up = np.abs(points[:, 2]) - half + rounding
        outside = np.hypot(np.maximum(flat, 0.0), np.maximum(up, 0.0))
        return np.asarray(outside + np.minimum(np.maximum(flat, up), 0.0) - rounding)

    return _boxed(distance, centre, (*np.abs(corners).max(axis=0), half), axes)


def turned(outline: ArrayLike, centre: ArrayLike = (0, 0, 0), axes: Floats = UPRIGHT) -> Part:
    """A closed polygon of radius and height turned about the y axis."""
    corners = np.asarray(outline, dtype=float)

    def distance(points: Floats) -> Floats:
        return polygon_distance(corners, np.stack([np.hypot(points[:, 0], points[:, 2]), points[:, 1]], axis=1))

    reach, height = np.abs(corners).max(axis=0)
    return _boxed(distance, centre, (reach, height, reach), axes)


def polygon_distance(corners: Floats, points: Floats) -> Floats:
    """Signed distance of (n, 2) points from a closed polygon."""
    nearest = np.full(len(points), np.inf)
    inside = np.zeros(len(points), dtype=bool)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along, offset = b - a, points - a
        t = np.clip(offset @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
        np.minimum(nearest, ((offset - t[:, None] * along) ** 2).sum(axis=1), out=nearest)
        crosses = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        if a[1] != b[1]:
            inside ^= crosses & (points[:, 0] < along[0] * offset[:, 1] / along[1] + a[0])
    return np.asarray(np.where(inside, -1.0, 1.0) * np.sqrt(nearest))


def hollow(part: Part, thickness: float) -> Part:
    """The skin of a part, `thickness` inwards."""
    return Part(lambda points: np.abs(part.distance(points) + thickness / 2) - thickness / 2, part.low, part.high)


def repeated(part: Part, count: int, twist: float = 0.0) -> Part:
    """A part that lies towards +z of the y axis, `count` times around it.

    Args:
        part: Within its share of the turn.
        count: How many.
        twist: Radians that they turn in a unit of height, as threads and helical teeth do.
    """
    share = 2 * np.pi / count
    corners = np.array([[x, z] for x in (part.low[0], part.high[0]) for z in (part.low[2], part.high[2])])
    reach = float(np.linalg.norm(corners, axis=1).max())

    def distance(points: Floats) -> Floats:
        angle = np.arctan2(points[:, 0], points[:, 2]) + twist * points[:, 1]
        angle = (angle + share / 2) % share - share / 2
        out = np.hypot(points[:, 0], points[:, 2])
        return part.distance(np.stack([out * np.sin(angle), points[:, 1], out * np.cos(angle)], axis=1))

    return Part(distance, np.array([-reach, part.low[1], -reach]), np.array([reach, part.high[1], reach]))


def placed(part: Part, place: "Place") -> Part:
    """A part carried to a place."""
    reach = np.abs([part.low, part.high]).max(axis=0) * place.scale
    return _boxed(lambda points: place.scale * part.distance(points / place.scale), place.origin, reach, place.axes)


def common(part: Part, others: Sequence[Part]) -> Part:
    """Where all parts are."""
    low = np.max([part.low, *(other.low for other in others)], axis=0)
    high = np.min([part.high, *(other.high for other in others)], axis=0)
    return Part(lambda points: np.max([p.distance(points) for p in (part, *others)], axis=0), low, high)


def ripples(rng: np.random.Generator, wavelength: float, waves: int = 12) -> Distance:
    """A smooth random pattern of about unit size, for bumps and folds."""
    direction = rng.normal(size=(waves, 3))
    direction *= 2 * np.pi / (wavelength * np.linalg.norm(direction, axis=1, keepdims=True))
    phase, size = rng.uniform(0, 2 * np.pi, waves), np.sqrt(2.0 / waves)
    return lambda points: np.asarray(size * np.sin(points @ direction.T + phase).sum(axis=1))


@dataclass(frozen=True)
class Place:
    """Where something sits: an origin and axes of its own.

    Attributes:
        origin: (3,).
        axes: (3, 3), rows.
    """

    origin: Floats
    axes: Floats = field(default_factory=lambda: UPRIGHT)
    scale: float = 1.0

    def at(self, x: float, y: float, z: float) -> Floats:
        """A point given in its own axes."""
        return self.origin + self.scale * (np.array([x, y, z]) @ self.axes)

    def along(self, points: Sequence[Sequence[float]]) -> Floats:
        """Several of them, (k, 3)."""
        return np.asarray(self.origin + self.scale * (np.asarray(points, dtype=float) @ self.axes))
