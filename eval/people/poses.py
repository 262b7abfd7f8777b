"""Poses of a camera by numbers that an outline tells apart, and a first search among all of them.

A pose is a rotation, where the middle of object space lands in the picture, how large it is there, and from how near it
is seen. Size and nearness are told apart from each other by perspective alone, which bends an outline a little.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from eval.people.outline import filled
from ncmodel.camera import DEFAULT_DISTANCE, LARGEST, Camera
from ncmodel.geometry.raycast import RayScene
from ncmodel.types import Floats, Image, Mask

NEAREST, FARTHEST = 0.95, 40.0
"""Distances between the eye and the middle of object space, in which shapes are 1 long; beyond, perspective is gone."""

_DIRECTIONS = 420
"""Over the view sphere: about 10 degrees from each other."""
_ROLLS = 36
_SIDE = 64
"""Pixels of the small silhouettes that the first search compares."""
_SPREAD = 0.19
"""Share of a small picture that a region's pixels are away from their middle (root mean square)."""
_APART = math.radians(18.0)
"""Poses closer than this to a better one are no start of their own."""


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a mesh is before a camera.

    Attributes:
        rotation: (3, 3) rows are the camera's right, up and backward axes in object space.
        u: Pixels from the picture's middle at which the middle of object space is seen, to the right.
        v: The same, downwards.
        size: Pixels that a unit of length takes at the middle of object space: focal length / distance.
        distance: From the eye to the middle of object space, along the optical axis.
    """

    rotation: Floats
    u: float
    v: float
    size: float
    distance: float

    def camera(self, width: int, height: int) -> Camera:
        """The camera of a picture of that size."""
        middle = np.array([self.u / self.size, -self.v / self.size, -self.distance])
        eye = -self.rotation.T @ middle
        target = eye - self.distance * self.rotation[2]
        return Camera(
            _triple(eye), _triple(target), _triple(self.rotation[1]), width, height, self.size * self.distance
        )

    def scaled(self, factor: float) -> "Pose":
        """The same pose in a picture `factor` as large."""
        return Pose(self.rotation, self.u * factor, self.v * factor, self.size * factor, self.distance)

    def moved(self, by: Floats) -> "Pose":
        """Another pose near it.

        Args:
            by: (7,) a rotation vector in the camera's axes, radians; du and dv, as shares of the object's size; the
                logarithms of the changes of size and distance.
        """
        turn = Rotation.from_rotvec(by[:3]).as_matrix()
        u, v = self.u + by[3] * self.size, self.v + by[4] * self.size
        distance = float(np.clip(self.distance * math.exp(by[6]), NEAREST, FARTHEST))
        return Pose(turn @ self.rotation, u, v, self.size * math.exp(by[5]), distance)

    def project(self, points: Floats) -> Floats:
        """(N, 2) pixels from the picture's middle of (N, 3) points in object space."""
        local = points @ self.rotation.T
        depth = np.maximum(self.distance - local[:, 2], 1e-3) / self.distance
        u = (local[:, 0] * self.size + self.u) / depth
        v = (self.v - local[:, 1] * self.size) / depth
        return np.stack([u, v], axis=1)

    def slopes(self, points: Floats) -> Floats:
        """(N, 2, 7) derivatives of `project` by the numbers that `moved` takes."""
        x, y, z = (points @ self.rotation.T).T
        u, v = self.project(points).T
        depth = np.maximum(self.distance - z, 1e-3)
        unit, zero = self.size * self.distance / depth, np.zeros(len(points))
        by_u = [u * y / depth, unit * z - u * x / depth, -unit * y, unit, zero, unit * x, -u * z / depth]
        by_v = [unit * z + v * y / depth, -v * x / depth, -unit * x, zero, unit, -unit * y, -v * z / depth]
        return np.stack([np.stack(by_u, axis=1), np.stack(by_v, axis=1)], axis=1)

    def angle_to(self, other: "Pose") -> float:
        """Radians between two poses' rotations."""
        return angle_between(self.rotation, other.rotation)

    @staticmethod
    def of(camera: Camera) -> "Pose":
        """The pose that a camera sees the object in."""
        rotation = camera.rotation
        x, y, z = rotation @ -np.asarray(camera.eye)
        size = camera.focal_pixels / -z
        return Pose(rotation, x * size, -y * size, size, -z)


def angle_between(first: Floats, second: Floats) -> float:
    """Radians by which one rotation must be turned to be another."""
    cosine = (float(np.sum(first * second)) - 1.0) / 2.0
    return math.acos(min(1.0, max(-1.0, cosine)))


def starting_poses(scene: RayScene, region: Mask, count: int, upright: float) -> list[Pose]:
    """The poses whose small silhouettes overlap most with a region, each different from the others.

    Silhouettes from directions all over the view sphere are brought to one size and place and laid over the region in
    all rolls.

    Args:
        scene: The mesh.
        region: (H, W) what a drawing's outline encloses.
        count: How many.
        upright: Radians that +y may lean to the side in the picture.
    """
    rolls = np.arange(_ROLLS) * 2 * math.pi / _ROLLS
    rolls = rolls[np.abs((rolls + math.pi) % (2 * math.pi) - math.pi) <= upright + 1e-9]
    drawn = np.stack([_centred(region, roll).ravel() for roll in rolls])
    views = [_upright_pose(direction) for direction in _sphere(_DIRECTIONS)]
    masks = [filled(scene.render(view.camera(_SIDE, _SIDE)).hit) for view in views]
    seen = np.stack([_centred(mask, 0.0).ravel() for mask in masks])
    both = seen @ drawn.T
    overlap = both / (seen.sum(axis=1)[:, None] + drawn.sum(axis=1)[None, :] - both)
    found: list[Pose] = []
    for index in np.argsort(-overlap, axis=None, kind="stable"):
        view, roll = divmod(int(index), len(rolls))
        pose = _placed(views[view], masks[view], region, rolls[roll])
        if all(pose.angle_to(other) > _APART for other in found):
            found.append(pose)
        if len(found) == count:
            break
    return found


def _sphere(count: int) -> Floats:
    """(count, 3) directions spread evenly over the sphere (Fibonacci lattice)."""
    n = np.arange(count) + 0.5
    height, turn = 1 - 2 * n / count, math.pi * (1 + math.sqrt(5)) * n
    ring = np.sqrt(1 - height**2)
    return np.stack([ring * np.sin(turn), height, ring * np.cos(turn)], axis=1)


def _upright_pose(direction: Floats) -> Pose:
    """Seen from a direction at the default distance, +y upwards, in a small picture."""
    eye = DEFAULT_DISTANCE * direction
    # A shape's bounding box, 1 long, fits from every side and however close its corners come.
    return Pose(Camera(_triple(eye)).rotation, 0.0, 0.0, 0.5 * _SIDE, DEFAULT_DISTANCE)


def _middle(region: Mask) -> tuple[Floats, float]:
    """The mean u, v of a region's pixels and their root mean square distance from it."""
    rows, columns = np.nonzero(region)
    points = np.stack([columns, rows], axis=1) + 0.5
    middle = points.mean(axis=0)
    return middle, float(np.sqrt(np.mean(np.sum((points - middle) ** 2, axis=1))))


def _centred(region: Mask, roll: float) -> Image:
    """A small picture of a region, its middle in the middle, its size the same for all, turned clockwise by `roll`."""
    if not region.any():
        return np.zeros((_SIDE, _SIDE), dtype=np.float32)
    middle, spread = _middle(region)
    scale = _SPREAD * _SIDE / max(spread, 1e-6)
    c, s = math.cos(roll), math.sin(roll)
    linear = scale * np.array([[c, -s], [s, c]])
    shift = np.full(2, _SIDE / 2) - linear @ middle
    # OpenCV counts from the centre of the first pixel.
    shift += linear @ np.full(2, 0.5) - 0.5
    size = (_SIDE, _SIDE)
    warped = cv2.warpAffine(region.astype(np.float32), np.column_stack([linear, shift]), size, flags=cv2.INTER_LINEAR)
    return np.asarray(warped, dtype=np.float32)


def _placed(view: Pose, mask: Mask, region: Mask, roll: float) -> Pose:
    """An upright view turned, scaled and shifted so that its silhouette lies over a region."""
    seen, seen_spread = _middle(mask)
    drawn, drawn_spread = _middle(region)
    factor = drawn_spread / max(seen_spread, 1e-6)
    # The region turned clockwise by `roll` looks like the view: the view is turned back.
    c, s = math.cos(roll), math.sin(roll)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    offset = np.array([[c, s], [-s, c]]) @ (np.full(2, _SIDE / 2) - seen) * factor
    u, v = drawn + offset - np.array([region.shape[1], region.shape[0]]) / 2
    return Pose(turn @ view.rotation, float(u), float(v), view.size * factor, view.distance)


def _triple(values: Sequence[float] | Floats) -> tuple[float, float, float]:
    x, y, z = (float(np.clip(value, -LARGEST, LARGEST)) for value in values)
    return x, y, z
