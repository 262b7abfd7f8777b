"""Views of small surfaces, and eyes that strain the definitions."""

import math
from dataclasses import replace

import numpy as np

from ncmodel.camera import Camera
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Ints, Mesh
from tests.helpers import analytic

EYE = (1.3, 1.1, 2.4)
AWAY = 1e6
"""Of a perspective camera, so far that angles differ by a millionth."""


def bumpy(amplitude: float = 0.1, frequency: float = 9.0) -> tuple[Floats, Ints]:
    """A small closed mesh with obtuse and acute faces, no symmetry, curvatures of both signs."""
    vertices, faces = analytic.torus(18, 10, 0.35, 0.15)
    rng = np.random.default_rng(0)
    return vertices * (1 + amplitude * np.sin(frequency * vertices[:, :1])) + rng.normal(
        scale=4e-3, size=vertices.shape
    ), faces


def seen(surface: tuple[Floats, Ints]) -> View:
    """The surface from `EYE`."""
    return View(Surface(Mesh(*surface)), Camera(EYE))


def eyes(mesh: Mesh) -> dict[str, tuple[float, float, float]]:
    """Eyes that strain the definitions, for one mesh."""
    surface = Surface(mesh)
    vertex, normal = mesh.vertices[mesh.faces[0, 0]], surface.normals[mesh.faces[0, 0]]
    across = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])

    def at(point: Floats) -> tuple[float, float, float]:
        return float(point[0]), float(point[1]), float(point[2])

    return {
        "outside": (1.3, 1.1, 2.4),
        "inside": (0.0, 1e-3, 0.0),
        "at a vertex": at(vertex),
        "along a normal": at(vertex + 2 * normal),
        "across a normal": at(vertex + 2 * across / np.linalg.norm(across)),
        "very far": (1e9, 1e9, 1e9),
        "very near": at(vertex + 1e-13 * normal),
    }


def orbited(vertices: Floats, faces: Ints, side: int) -> View:
    """The surface from the default direction, on a square picture."""
    return View(Surface(Mesh(vertices, faces)), Camera.orbit(vertices, size=(side, side)))


def parallel_and_far(mesh: Mesh, size: int = 256) -> tuple[View, View]:
    """A view of a mesh along parallel lines, and the same with perspective from very far away."""
    camera = Camera.orbit(mesh.vertices, 35.0, 25.0, size=(size, size), projection="orthographic")
    away = AWAY / math.hypot(*camera.eye)
    x, y, z = (away * value for value in camera.eye)
    far = replace(camera, eye=(x, y, z), projection="perspective", focal_pixels=camera.focal_pixels * AWAY)
    surface = Surface(mesh)
    return View(surface, camera), View(surface, far)
