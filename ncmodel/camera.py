"""Cameras: where a view is seen from, and how it lands on the picture plane.

A camera is a pinhole (perspective), or looks along parallel lines (orthographic). What differs is said here once:
`Camera.viewpoint` for vectors towards the camera, `Camera.rays` and `Camera.rays_to` for lines of sight, and
`Camera.scale_distance` for how large things appear.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from numbers import Integral, Real
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ncmodel.errors import InputError, UsageError
from ncmodel.parsing import parse_json
from ncmodel.types import Floats, Ints, Mask

DEFAULT_SIZE = 768
DEFAULT_AZIMUTH = 30.0
DEFAULT_ELEVATION = 30.0
DEFAULT_DISTANCE = 3.0
VIEWS = {
    "front": (0.0, 0.0),
    "back": (180.0, 0.0),
    "left": (-90.0, 0.0),
    "right": (90.0, 0.0),
    "top": (0.0, 90.0),
    "bottom": (0.0, -90.0),
    "iso": (45.0, math.degrees(math.atan(math.sqrt(0.5)))),
}
"""Names of views -> azimuth and elevation, degrees. In "iso" all three axes are equally long; left and right are the
shape's sides at -x and +x."""
FRAME_MARGIN = 0.06
"""Share of the shorter side left empty on each side when a camera is fitted to an object."""

MAX_SIDE = 16384
LARGEST = 1e12
"""Larger numbers than this in a camera would lose the object, of size 1, to rounding."""
PERSPECTIVE, ORTHOGRAPHIC = "perspective", "orthographic"
PROJECTIONS = (PERSPECTIVE, ORTHOGRAPHIC)
_SCALE = "pixels_per_unit"
"""What an orthographic camera's file has in place of `focal_pixels`."""
_KEYS = {"eye": 3, "target": 3, "up": 3, "width": 0, "height": 0, "focal_pixels": 0}


class Rays(NamedTuple):
    """Lines of sight.

    Attributes:
        origins: (3,) the eye from which all of them start, or (N, 3) where each starts on the camera plane.
        directions: (N, 3).
    """

    origins: Floats
    directions: Floats

    def at(self, share: Floats) -> Floats:
        """(N, 3) points on them, (N,) times their directions from where they start."""
        return np.asarray(self.origins + share[:, None] * self.directions)

    def aside(self, offset: Floats) -> "Rays":
        """The rays to points that are (N, 3) beside where these lead, across them."""
        if self.origins.ndim == 1:
            return Rays(self.origins, self.directions + offset)
        return Rays(self.origins + offset, self.directions)

    def take(self, kept: Mask | Ints) -> "Rays":
        """Those selected by a mask or by indices."""
        return Rays(self.origins if self.origins.ndim == 1 else self.origins[kept], self.directions[kept])


@dataclass(frozen=True)
class Camera:
    """A camera in object space that looks from `eye` to `target`.

    Pixel (u, v) = (W/2 + f x / (-z), H/2 - f y / (-z)) in camera space: row 0 on top, pixel centres at +0.5. Without
    perspective it is (W/2 + f x, H/2 - f y). What is seen is in front of the plane through the eye across the axis.

    Attributes:
        eye: Position.
        target: Point on the optical axis.
        up: Direction that points up in the picture; needn't be orthogonal to the line of sight.
        width: Pixels.
        height: Pixels.
        focal_pixels: Focal length f, pixels; of an orthographic camera its scale f, pixels per unit.
        projection: "perspective" or "orthographic".
    """

    eye: tuple[float, float, float]
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    width: int = DEFAULT_SIZE
    height: int = DEFAULT_SIZE
    focal_pixels: float = 1410.540280392905
    projection: str = PERSPECTIVE

    def __post_init__(self) -> None:
        if not len(self.eye) == len(self.target) == len(self.up) == 3:
            raise UsageError(f"camera: eye {self.eye}, target {self.target}, up {self.up}, expected three numbers each")
        values: list[Any] = [*self.eye, *self.target, *self.up, self.focal_pixels]
        if not all(isinstance(value, Real) and math.isfinite(value) for value in values):
            raise UsageError(f"camera: all numbers must be finite, found {values}")
        if not all(isinstance(side, Integral) for side in (self.width, self.height)):
            raise UsageError(f"camera: size {self.width} x {self.height}, expected whole pixels")
        if not (1 <= self.width <= MAX_SIDE and 1 <= self.height <= MAX_SIDE):
            raise UsageError(f"camera: size {self.width} x {self.height}, expected sides in 1..{MAX_SIDE} pixels")
        if self.focal_pixels <= 0:
            raise UsageError(f"camera: focal_pixels is {self.focal_pixels}, expected a positive number")
        if max(abs(value) for value in values) > LARGEST:
            raise UsageError(f"camera: found {max(values, key=abs):g}, expected numbers up to {LARGEST:g}")
        if not any(self.up):
            raise UsageError(f"camera: up is {self.up}, expected a direction")
        if math.dist(self.eye, self.target) < 1e-9 * max(1.0, *map(abs, self.target)):
            raise UsageError(f"camera: eye and target are both {self.eye}, expected two different points")
        if self.projection not in PROJECTIONS:
            raise UsageError(f"camera: projection is {self.projection!r}, expected one of {', '.join(PROJECTIONS)}")

    @property
    def is_orthographic(self) -> bool:
        """Whether all lines of sight are parallel."""
        return self.projection == ORTHOGRAPHIC

    @cached_property
    def viewpoint(self) -> Floats:
        """(4,) homogeneous: the eye and 1, or the direction to it and 0 (`ncmodel.geometry.view_vectors`)."""
        return np.array([*self.rotation[2], 0.0] if self.is_orthographic else [*self.eye, 1.0], dtype=np.float64)

    @cached_property
    def rotation(self) -> Floats:
        """(3, 3) rows are the camera's right, up and backward axes in object space."""
        backward = np.subtract(self.eye, self.target).astype(np.float64)
        backward /= np.linalg.norm(backward)
        right = np.cross(np.asarray(self.up, dtype=np.float64), backward)
        if np.linalg.norm(right) <= 1e-9 * np.linalg.norm(self.up):
            # `up` along the line of sight leaves the roll open: any axis off it will do.
            right = np.cross(np.eye(3)[np.argmin(np.abs(backward))], backward)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(backward, right), backward])

    def project(self, points: Floats) -> Floats:
        """Project (..., 3) points to (..., 3): u, v in pixels and the distance in front of the camera plane (-z).

        Points at or behind the camera plane have a third value <= 0 and meaningless pixels.
        """
        x, y, distance = self.local(points)
        divisor = self.scale_distance(distance)
        projected = np.empty(points.shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            projected[..., 0] = self.width / 2 + self.focal_pixels * x / divisor
            projected[..., 1] = self.height / 2 - self.focal_pixels * y / divisor
        projected[..., 2] = distance
        return projected

    def local(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """How far (..., 3) points are to the right of the eye, above it and before the camera plane, each (...)."""
        # One product of matrices is several times as fast as one for each pair of points.
        axes = (points.reshape(-1, 3) - np.asarray(self.eye)) @ self.rotation.T
        x, y, backward = axes.T.reshape(3, *points.shape[:-1])
        return x, y, -backward

    def scale_distance(self, distance: Floats) -> Floats:
        """(N,) what f x is divided by to give pixels, (N,) before the camera plane: the distance; 1 if orthographic."""
        return np.ones_like(distance) if self.is_orthographic else distance

    def rays(self, pixels: Floats) -> Rays:
        """The lines of sight through (N, 2) pixels, their directions of length 1 along the optical axis."""
        x = (pixels[:, 0] - self.width / 2) / self.focal_pixels
        y = (self.height / 2 - pixels[:, 1]) / self.focal_pixels
        eye = np.asarray(self.eye, dtype=np.float64)
        if not self.is_orthographic:
            return Rays(eye, np.stack([x, y, np.full(len(pixels), -1.0)], axis=1) @ self.rotation)
        across = np.stack([x, y], axis=1) @ self.rotation[:2]
        return Rays(eye + across, np.tile(-self.rotation[2], (len(pixels), 1)))

    def rays_to(self, points: Floats) -> Rays:
        """The lines of sight to (N, 3) points, with directions as long as the way from the camera."""
        eye = np.asarray(self.eye, dtype=np.float64)
        if not self.is_orthographic:
            return Rays(eye, points - eye)
        directions = ((points - eye) @ self.rotation[2])[:, None] * self.rotation[2]
        return Rays(points - directions, directions)

    def projected(self, projection: str) -> "Camera":
        """The camera with that projection in which what is as far as its target appears as large as it does now."""
        changed, away = replace(self, projection=projection), math.dist(self.eye, self.target)
        if changed.is_orthographic == self.is_orthographic:
            return self
        return changed.zoomed(self.focal_pixels / away if changed.is_orthographic else self.focal_pixels * away)

    def resized(self, width: int, height: int) -> "Camera":
        """The same view at another resolution: scaled so that the shorter side shows as much."""
        scale = min(width, height) / min(self.width, self.height)
        return replace(self, width=width, height=height, focal_pixels=self.focal_pixels * scale)

    def turned(self, azimuth: float) -> "Camera":
        """The same camera swung about the vertical axis through its target by `azimuth` degrees."""
        angle = math.radians(azimuth)
        x, y, z = np.subtract(self.eye, self.target)
        c, s = math.cos(angle), math.sin(angle)
        swung = np.array([c * x + s * z, y, -s * x + c * z]) + self.target
        return replace(self, eye=(float(swung[0]), float(swung[1]), float(swung[2])))

    @staticmethod
    def orbit(
        vertices: Floats,
        azimuth: float = DEFAULT_AZIMUTH,
        elevation: float = DEFAULT_ELEVATION,
        distance: float = DEFAULT_DISTANCE,
        size: tuple[int, int] = (DEFAULT_SIZE, DEFAULT_SIZE),
        target: tuple[float, float, float] = (0.0, 0.0, 0.0),
        projection: str = PERSPECTIVE,
    ) -> "Camera":
        """A camera on a sphere around `target`, zoomed so that `vertices` fill the frame with a margin.

        Args:
            vertices: (V, 3) what must be in the frame.
            azimuth: Degrees from +z towards +x.
            elevation: Degrees above the ground plane.
            distance: From `target`, object-space units.
            size: (width, height) pixels.
            target: The point looked at.
            projection: "perspective" or "orthographic".
        """
        a, e = math.radians(azimuth), math.radians(elevation)
        # Exactly along an axis where that is meant: what is seen edge-on is then so for all faces alike.
        (ca, sa), (ce, se) = ([0.0 if abs(x) < 1e-15 else x for x in (math.cos(t), math.sin(t))] for t in (a, e))
        direction = (ce * sa, se, ce * ca)
        eye = tuple(t + distance * d for t, d in zip(target, direction, strict=True))
        up = (0.0, 1.0, 0.0)
        if abs(elevation) > 89.9:
            up = (-math.sin(a) * math.copysign(1.0, elevation), 0.0, -math.cos(a) * math.copysign(1.0, elevation))
        width, height = size
        unit = Camera((eye[0], eye[1], eye[2]), target, up, width, height, 1.0, projection)
        projected = unit.project(vertices)
        seen = projected[projected[:, 2] > 1e-6]
        if len(seen) == 0:
            return unit.zoomed(0.8 * min(size))
        reach_u = max(float(np.abs(seen[:, 0] - width / 2).max()), 1e-9)
        reach_v = max(float(np.abs(seen[:, 1] - height / 2).max()), 1e-9)
        inner = 0.5 - FRAME_MARGIN
        # A degenerate object (a point) must not ask for an unbounded zoom.
        return unit.zoomed(min(inner * width / reach_u, inner * height / reach_v, 1e6))

    def zoomed(self, focal_pixels: float) -> "Camera":
        """The same camera with another focal length."""
        return replace(self, focal_pixels=focal_pixels)

    def to_json(self) -> str:
        """The camera as the JSON text of a camera file."""
        record = {key: getattr(self, key) for key in _KEYS}
        if self.is_orthographic:
            record |= {"projection": self.projection, _SCALE: record.pop("focal_pixels")}
        return json.dumps(record, indent=1)

    @staticmethod
    def load(path: str | Path) -> "Camera":
        """Read a camera file.

        Raises:
            InputError: The file is missing, isn't JSON, or has wrong keys or values.
        """
        try:
            # Whole numbers as floats: those that are too large become infinite.
            record = parse_json(Path(path).read_text(encoding="utf-8-sig"), parse_int=float)
        except OSError as error:
            raise InputError(path, f"can't be read ({error.strerror})", f"a JSON object {_with_keys(_KEYS)}") from error
        except ValueError as error:
            raise InputError(path, f"not JSON ({error})", f"a JSON object {_with_keys(_KEYS)}") from error
        return Camera.of_record(path, record)

    @staticmethod
    def of_record(path: str | Path, record: Any) -> "Camera":
        """A camera from the object that a camera file holds.

        Args:
            path: The file to name in error messages.
            record: What was read.

        Raises:
            InputError: It has wrong keys or values.
        """
        if not isinstance(record, dict):
            raise InputError(path, f"found {type(record).__name__}", f"a JSON object {_with_keys(_KEYS)}")
        record = dict(record)
        projection, expected = record.pop("projection", PERSPECTIVE), _KEYS
        if projection == ORTHOGRAPHIC:
            record.pop("focal_pixels", None)
            expected = {key: length for key, length in _KEYS.items() if key != "focal_pixels"} | {_SCALE: 0}
        if record.keys() != expected.keys():
            raise InputError(path, f"found {sorted(record)}", f"a JSON object {_with_keys(expected)}")
        for key, length in expected.items():
            items = record[key] if length else [record[key]]
            numbers = isinstance(items, list) and all(
                isinstance(item, int | float) and not isinstance(item, bool) for item in items
            )
            if not numbers or (length and len(items) != length):
                raise InputError(path, f"{key} is {record[key]!r}", f"{length or 'one'} number{'s' if length else ''}")
        if not all(math.isfinite(record[side]) and record[side] == int(record[side]) for side in ("width", "height")):
            raise InputError(path, f"size {record['width']} x {record['height']}", "whole pixels")
        vectors = {key: (float(v[0]), float(v[1]), float(v[2])) for key, v in record.items() if expected[key]}
        try:
            return Camera(
                **vectors,
                width=int(record["width"]),
                height=int(record["height"]),
                focal_pixels=float(record[_SCALE if projection == ORTHOGRAPHIC else "focal_pixels"]),
                projection=projection,
            )
        except UsageError as error:
            raise InputError(path, str(error), "a usable camera") from error


def _with_keys(keys: Mapping[str, int]) -> str:
    return f"with the keys {', '.join(keys)}"
