"""Shading and feature maps of a view: closed forms on a sphere, and interpolation done by hand."""

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import LineFamily, Mesh
from tests.helpers import analytic

CAMERA = Camera((0.0, 0.0, 3.0), width=120, height=90, focal_pixels=200.0)
LEVEL = Camera((1.3, 1.1, 2.4), width=160, height=120, focal_pixels=300.0)


def test_a_sphere_is_shaded_by_the_cosine() -> None:
    """max(n.v, 0) from the ray's own geometry, at every level: smoothing a sphere's normals changes nothing much."""
    view = View(Surface(Mesh(*analytic.icosphere(5, 0.5))), CAMERA)
    u, v = np.meshgrid(np.arange(120) + 0.5 - 60, 45 - np.arange(90) - 0.5)
    ray = np.stack([u, v, np.full(u.shape, -200.0)], axis=-1)
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    along = -3 * ray[..., 2]
    root = along**2 - (9 - 0.25)
    inside = root > 0.01
    hit = [0, 0, 3.0] + (along - np.sqrt(np.maximum(root, 0)))[..., None] * ray
    expected = -(hit / 0.5 * ray).sum(axis=-1)
    for level in (0, 1, 5):
        np.testing.assert_allclose(view.shaded[level][inside], expected[inside], atol=4e-3)
    background = root < -0.01
    assert background.any()
    assert (view.shaded[:, background] == 1).all()


def test_back_faces_are_black() -> None:
    vertices, faces = analytic.plane(4)
    view = View(Surface(Mesh(vertices, faces[:, ::-1].copy())), CAMERA)
    assert (view.shaded[:, view.buffers.hit] == 0).all()


@pytest.mark.parametrize("family", ["suggestive", "ridges", "valleys", "apparent"])
def test_feature_maps_interpolate_the_vertices(family: str) -> None:
    vertices, faces = analytic.torus(48, 24)
    view = View(Surface(Mesh(vertices, faces)), LEVEL)
    k1 = view.surface.k1
    values = {"suggestive": view.sc_num, "ridges": k1, "valleys": -k1, "apparent": view.q1}[family]
    image, buffers = view.feature_map(LineFamily(family)), view.buffers
    expected = (values[faces[buffers.face]] * buffers.barycentric).sum(axis=-1)
    np.testing.assert_allclose(image, np.where(buffers.hit, expected, 0), rtol=1e-5, atol=1e-6)
    assert (image[~buffers.hit] == 0).all()
    assert view.feature_map(LineFamily(family)) is image


def test_families_without_thresholds_have_no_map() -> None:
    view = View(Surface(Mesh(*analytic.torus(12, 8))), LEVEL)
    with pytest.raises(KeyError):
        view.feature_map(LineFamily.CREASES)
