"""What a ray meets first: embree's float32 search, positions, distances and depth in float64.

Embree works in float32, so a scene is moved and scaled into the unit ball, and every ray starts where it enters that
ball, however far away the eye is. Only the hit face and its barycentric weights are taken from embree; the position,
and with it distance and depth, is their float64 combination of the mesh's own vertices (about 1e-7 of its size).

Depth is linear in the distance along the optical axis: 0 on the near plane and 1 on the far plane, the two planes
across that axis which touch the mesh's bounding sphere; the near plane is never behind the eye. The background is 1.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ncmodel.camera import Camera, Rays
from ncmodel.geometry.coincident_faces import distinct_faces
from ncmodel.geometry.normals_areas import Indices
from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, Mesh, ViewBuffers

if TYPE_CHECKING:
    from embreex.rtcore_scene import EmbreeScene

CHUNK = 1 << 18
"""Rays handed to embree at once: bounds the memory of large pictures without costing time."""

BALL_MARGIN = 1.001
"""Rays start this many radii from the centre, so that rounding never puts a start behind the surface."""


@dataclass(frozen=True, eq=False)
class Hits:
    """What N rays meet first.

    Attributes:
        face: (N,) face index, -1 for a miss.
        barycentric: (N, 3) weights of the face's corners, 0 for a miss.
        point: (N, 3) position in object space, meaningless for a miss.
        distance: (N,) from the ray's origin, infinite for a miss.
    """

    face: Ints
    barycentric: Floats
    point: Floats
    distance: Floats


def _embree_scene(vertices: NDArray[np.float32], faces: NDArray[np.uint32]) -> "EmbreeScene":
    """Embree is loaded here: who only computes networks does without a ray tracer."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    # "Robust" makes edges watertight: without it rays slip through between two faces.
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, vertices, faces.view(np.int32))
    return scene


class RayScene:
    """A mesh ready for rays. Faces are met from both sides, and shared edges let no ray through.

    Of faces that lie on each other, corner on corner, the first one is met: with all in the scene, a ray would be held
    against each of them.

    Args:
        mesh: The mesh; a mesh without faces is met by no ray.
    """

    def __init__(self, mesh: Mesh) -> None:
        self.vertices, self.faces = mesh.vertices, mesh.faces.astype(np.uint32)
        self.centre = np.zeros(3)
        self.radius = 1.0
        self._scene: EmbreeScene | None = None
        self._cast_at: Ints | None = None  # the scene's faces; None for all
        if len(mesh.faces):
            used = mesh.used_vertices
            self.centre = (used.min(axis=0) + used.max(axis=0)) / 2
            self.radius = float(np.linalg.norm(used - self.centre, axis=1).max()) or 1.0
            self._cast_at = distinct_faces(self.vertices, self.faces)
            faces = self.faces if self._cast_at is None else self.faces[self._cast_at]
            self._scene = _embree_scene(self._local(mesh.vertices), faces)

    def hits(self, origins: Floats, directions: Floats) -> Hits:
        """Cast rays.

        Args:
            origins: (N, 3), or (3,) for rays from one point.
            directions: (N, 3), of any length above 0.
        """
        parts = [self._cast(*chunk) for chunk in _chunks(origins, directions)]
        return Hits(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))

    def first_hit(self, origins: Floats, directions: Floats) -> tuple[Floats, Ints]:
        """The (N,) distance to, and face of, the first hit of each ray; infinite and -1 for a miss.

        Args:
            origins: (N, 3), or (3,) for rays from one point.
            directions: (N, 3), of any length above 0.
        """
        hits = self.hits(origins, directions)
        return hits.distance, hits.face

    def depth_range(self, camera: Camera) -> tuple[float, float]:
        """Distances along the optical axis where depth is 0 and 1."""
        axial = float((self.centre - np.asarray(camera.eye)) @ -camera.rotation[2])
        near = max(axial - self.radius, 0.0)
        return near, max(axial + self.radius, near + self.radius)

    def render(self, camera: Camera) -> ViewBuffers:
        """One ray through the centre of every pixel."""
        height, width = camera.height, camera.width
        face = np.empty(height * width, dtype=np.int64)
        barycentric = np.empty((height * width, 3))
        depth = np.empty(height * width, dtype=np.float32)
        near, far = self.depth_range(camera)
        eye, forward = np.asarray(camera.eye), -camera.rotation[2]
        for start in range(0, height * width, CHUNK):
            part = slice(start, min(start + CHUNK, height * width))
            face[part], barycentric[part], point, _ = self._cast(*_pixel_rays(camera, part))
            scaled = ((point - eye) @ forward - near) / (far - near)
            depth[part] = np.where(face[part] >= 0, np.clip(scaled, 0.0, 1.0), 1.0)
        return ViewBuffers(
            face.reshape(height, width), barycentric.reshape(height, width, 3), depth.reshape(height, width)
        )

    def _local(self, points: Floats) -> NDArray[np.float32]:
        return ((points - self.centre) / self.radius).astype(np.float32)

    def _cast(self, origins: Floats, directions: Floats) -> tuple[Ints, Floats, Floats, Floats]:
        """The fields of `Hits` for one chunk of rays."""
        count = len(directions)
        if self._scene is None or count == 0:
            return np.full(count, -1), np.zeros((count, 3)), np.zeros((count, 3)), np.full(count, np.inf)
        origins = np.ascontiguousarray(np.atleast_2d(origins))
        starts, unit = _approach(origins, np.ascontiguousarray(directions), self.centre, self.radius)
        found = self._scene.run(starts, unit, output=True)
        face = found["primID"].astype(np.int64)
        if self._cast_at is not None:
            face = np.where(face >= 0, self._cast_at[face], -1)
        return face, *_locate(face, found["u"], found["v"], self.vertices, self.faces, origins)


@kernel
def _approach(
    origins: Floats, directions: Floats, centre: Floats, radius: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Rays moved forward to the unit ball: their float32 starts and unit directions."""
    starts = np.empty(directions.shape, np.float32)
    unit = np.empty(directions.shape, np.float32)
    for i in range(len(directions)):
        origin, d = origins[min(i, len(origins) - 1)], directions[i]
        length = math.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        toward = 0.0
        for k in range(3):
            toward += (centre[k] - origin[k]) * d[k] / length
        skipped = max(toward - BALL_MARGIN * radius, 0.0)
        for k in range(3):
            unit[i, k] = d[k] / length
            starts[i, k] = (origin[k] + skipped * d[k] / length - centre[k]) / radius
    return starts, unit


@kernel
def _locate(
    face: Ints, u: NDArray[np.float32], v: NDArray[np.float32], vertices: Floats, faces: Indices, origins: Floats
) -> tuple[Floats, Floats, Floats]:
    """Barycentric weights, positions and distances of hits, in float64."""
    barycentric = np.zeros((len(face), 3))
    point = np.zeros((len(face), 3))
    distance = np.full(len(face), np.inf)
    for i in range(len(face)):
        if face[i] < 0:
            continue
        second = min(max(float(u[i]), 0.0), 1.0)
        third = min(max(float(v[i]), 0.0), 1.0 - second)
        barycentric[i, 0], barycentric[i, 1], barycentric[i, 2] = 1.0 - second - third, second, third
        origin, square = origins[min(i, len(origins) - 1)], 0.0
        for k in range(3):
            for j in range(3):
                point[i, k] += barycentric[i, j] * vertices[faces[face[i], j], k]
            square += (point[i, k] - origin[k]) ** 2
        distance[i] = math.sqrt(square)
    return barycentric, point, distance


def _chunks(origins: Floats, directions: Floats) -> Iterator[tuple[Floats, Floats]]:
    for start in range(0, max(len(directions), 1), CHUNK):
        part = slice(start, start + CHUNK)
        yield (origins if origins.ndim == 1 else origins[part]), directions[part]


def _pixel_rays(camera: Camera, part: slice) -> Rays:
    """Lines of sight through the centres of the pixels `part` in row-major order."""
    index = np.arange(part.start, part.stop)
    return camera.rays(np.stack([index % camera.width + 0.5, index // camera.width + 0.5], axis=1))
