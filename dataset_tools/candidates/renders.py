"""Shaded pictures of a shape, as participants see it: matte, lit from beside the eye, no lines."""

import math

import cv2
import numpy as np
from numba import njit

from ncmodel.camera import Camera
from ncmodel.geometry.normals_areas import Indices
from ncmodel.geometry.shading import blended
from ncmodel.geometry.view_vectors import toward
from ncmodel.images import Pixels
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Image, Ints

Triple = tuple[float, float, float]

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
    light = np.asarray(LIGHT) / np.linalg.norm(LIGHT) @ camera.rotation
    mesh = surface.mesh
    brightness = _brightness(
        buffers.face, buffers.barycentric, mesh.vertices, surface.faces, surface.normals, camera.viewpoint, light
    )
    small = cv2.resize(brightness, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    return np.asarray(np.rint(255 * small), dtype=np.uint8)


@njit(cache=True, nogil=True, error_model="numpy")
def _brightness(
    face: Ints, barycentric: Floats, vertices: Floats, faces: Indices, normals: Floats, viewpoint: Floats, light: Floats
) -> Image:
    """(H, W) brightness of what each pixel sees, 1 on the background."""
    image = np.ones(face.shape, dtype=np.float32)
    for row in range(face.shape[0]):
        for column in range(face.shape[1]):
            f = face[row, column]
            if f < 0:
                continue
            weights = barycentric[row, column]
            x, y, z = blended(vertices, faces, f, weights)
            to_eye = _unit(*toward(viewpoint, x, y, z))
            smooth, flat = _unit(*blended(normals, faces, f, weights)), _unit(*_across(vertices, faces, f))
            normal = smooth if _dot(smooth, flat) >= SMOOTH_COSINE else flat
            facing, lit = _dot(normal, to_eye), _dot(normal, (light[0], light[1], light[2]))
            if facing < 0:  # open surfaces are seen from behind too; both sides are lit alike
                facing, lit = -facing, -lit
            image[row, column] = AMBIENT + HEADLIGHT * facing + KEY * max(lit, 0.0)
    return image


@njit(cache=True, nogil=True)
def _across(vertices: Floats, faces: Indices, f: int) -> Triple:
    """A face's own normal, of any length."""
    a, b, c = vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]]
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    u, v, w = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    return y * w - z * v, z * u - x * w, x * v - y * u


@njit(cache=True, nogil=True)
def _dot(a: Triple, b: Triple) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True)
def _unit(x: float, y: float, z: float) -> Triple:
    length = math.sqrt(x * x + y * y + z * z)
    scale = 1 / length if length > 0 else 0.0
    return x * scale, y * scale, z * scale
