"""Where shapes are seen from."""

import numpy as np
import pytest

from dataset_tools.candidates.viewpoints import camera_at, choose_azimuths, surface_centroid
from ncmodel.types import Mesh
from tests.helpers import dirty


def test_azimuths_follow_from_the_name_and_the_seed_alone() -> None:
    assert choose_azimuths("cow", 2) == choose_azimuths("cow", 2)
    assert choose_azimuths("cow", 3)[:2] == choose_azimuths("cow", 2)
    others = {tuple(choose_azimuths(name, 2, seed)) for name, seed in (("cow", 0), ("cow", 1), ("calf", 0))}
    assert len(others) == 3


def test_azimuths_go_all_around() -> None:
    azimuths = np.array([choose_azimuths(f"shape {number}", 2) for number in range(300)])
    assert azimuths.min() >= 0
    assert azimuths.max() < 360
    assert (np.histogram(azimuths, 6, (0, 360))[0] > 60).all()


def test_the_camera_is_elevated_upright_and_aimed_at_the_centroid() -> None:
    vertices, faces = dirty.joined(dirty.sphere(0.3, (0.2, 0.1, 0)), dirty.box((-0.5, -0.4, -0.1), (0, 0, 0.1)))
    mesh = Mesh(vertices, faces)
    camera = camera_at(mesh, 75.0, (300, 200))
    assert camera.target == pytest.approx(surface_centroid(vertices, faces))
    x, y, z = np.subtract(camera.eye, camera.target)
    assert np.degrees(np.arctan2(y, np.hypot(x, z))) == pytest.approx(30.0)
    assert np.degrees(np.arctan2(x, z)) == pytest.approx(75.0)
    assert camera.up == (0.0, 1.0, 0.0)
    centre = camera.project(np.array(camera.target))
    assert centre[:2] == pytest.approx([150.0, 100.0])


def test_the_shape_fills_the_frame_with_a_margin() -> None:
    mesh = Mesh(*dirty.box((-0.5, -0.1, -0.2), (0.5, 0.1, 0.2)))
    for size in ((256, 256), (320, 200)):
        projected = camera_at(mesh, 10.0, size).project(mesh.vertices)[:, :2]
        share = np.abs(projected / size - 0.5).max(axis=0)
        assert share.max() == pytest.approx(0.44)


def test_the_centroid_is_that_of_the_surface_not_of_its_vertices() -> None:
    coarse, fine = dirty.strip(-1.0, 0.0, 1), dirty.strip(0.0, 1.0, 50)
    assert surface_centroid(*dirty.joined(coarse, fine)) == pytest.approx([0.0, 0.5, 0.0])
