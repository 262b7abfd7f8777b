"""Shaded pictures of a shape, as participants see it: matte, lit from beside the eye, no lines."""

import cv2
import numpy as np

from ncmodel.camera import Camera
from ncmodel.geometry.surface import Surface
from ncmodel.pictures import Pixels
from ncmodel.types import Floats

SUPERSAMPLING = 2
LIGHT = (-0.45, 0.55, 0.70)
"""Towards the light in camera axes (right, up, backward): from above the viewer's left shoulder."""

AMBIENT, HEADLIGHT, KEY = 0.22, 0.28, 0.50
"""Shares of brightness: the same everywhere, from the eye, from the light."""

SMOOTH_COSINE = 0.82
"""A face whose own normal is farther from the smoothed one (35 degrees) is shaded flat: its border is an edge."""


def shaded_picture(surface: Surface, camera: Camera) -> Pixels:
    """(H, W) grey picture on white.

    Args:
        surface: The shape.
        camera: The view.
    """
    large = camera.resized(SUPERSAMPLING * camera.width, SUPERSAMPLING * camera.height)
    buffers = surface.scene.render(large)
    hit = buffers.hit
    face, weights = buffers.face[hit], buffers.barycentric[hit]
    mesh = surface.mesh
    smooth = _unit(np.einsum("nk,nkd->nd", weights, surface.normals[mesh.faces[face]]))
    corners = mesh.vertices[mesh.faces[face]]
    flat = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    normal = np.where((smooth * flat).sum(axis=1, keepdims=True) >= SMOOTH_COSINE, smooth, flat)
    to_eye = _unit(np.asarray(camera.eye) - np.einsum("nk,nkd->nd", weights, corners))
    # Open surfaces are seen from behind too; both sides are lit alike.
    normal *= np.where((normal * to_eye).sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
    light = _unit(np.asarray(LIGHT)[None]) @ camera.rotation
    brightness = np.ones(hit.shape, dtype=np.float32)
    brightness[hit] = (
        AMBIENT
        + HEADLIGHT * np.clip((normal * to_eye).sum(axis=1), 0.0, 1.0)
        + KEY * np.clip((normal * light).sum(axis=1), 0.0, 1.0)
    )
    small = cv2.resize(brightness, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    return np.rint(255 * small).astype(np.uint8)


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))
