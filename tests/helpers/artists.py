"""Small shapes with something to draw."""

import numpy as np

from ncmodel.camera import Camera
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Mesh
from tests.helpers.analytic import cube, icosphere, torus


def bumpy_view(side: int = 256) -> View:
    """A ring with bumps."""
    vertices, faces = torus()
    bumps = 1.0 + 0.06 * np.sin(14 * vertices[:, :1]) * np.sin(17 * vertices[:, 1:2])
    mesh = Mesh(vertices * bumps, faces, "bumpy")
    return View(Surface(mesh), Camera.orbit(mesh.vertices, elevation=50.0, size=(side, side)))


def box_view(side: int = 512) -> View:
    """A box from a corner."""
    mesh = Mesh(*cube(), "box")
    return View(Surface(mesh), Camera.orbit(mesh.vertices, size=(side, side)))


def carved_view(waves: tuple[float, float, float], side: int = 768) -> View:
    """A ball with raised islands, `waves` of them along each axis: ridges, valleys, and a few contours inside."""
    vertices, faces = icosphere(6, 0.4)
    x, y, z = (np.array(waves) * vertices).T
    raised = 1.0 + 0.07 * np.tanh(9.0 * (np.sin(x + 0.4) * np.cos(y) + np.sin(z - y)))
    mesh = Mesh(vertices * raised[:, None], faces, "carved")
    return View(Surface(mesh), Camera.orbit(mesh.vertices, size=(side, side)))
