"""Shaded pictures of shapes."""

import numpy as np

from dataset_tools.candidates.renders import AMBIENT, shaded_picture
from dataset_tools.candidates.viewpoints import camera_at
from dataset_tools.cleaning.repair import clean
from ncmodel.scene.surface import Surface
from ncmodel.types import Mesh
from tests.helpers import dirty


def picture(part: dirty.Geometry) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    mesh = Mesh(*part)
    return shaded_picture(Surface(mesh), camera_at(mesh, 0.0, (80, 60)))


def test_a_shape_is_grey_on_white_and_lit_from_the_left() -> None:
    ball = picture(dirty.sphere(0.5, fineness=4))
    assert ball.shape == (60, 80)
    assert (ball[[0, -1], :] == 255).all()
    seen = ball < 255
    assert ball[seen].min() >= round(255 * AMBIENT)
    assert ball[25:35, 22:38].mean() > ball[25:35, 42:58].mean()


def test_both_sides_of_a_sheet_are_lit_alike() -> None:
    vertices, faces = dirty.strip(-0.5, 0.5, 3)
    assert np.array_equal(picture((vertices, faces)), picture((vertices, faces[:, ::-1].copy())))


def test_the_sides_of_a_cleaned_box_are_flat() -> None:
    mesh, _ = clean(*dirty.box())
    image = shaded_picture(Surface(mesh), camera_at(mesh, 30.0, (120, 120)))
    counts = np.unique(image[image < 255], return_counts=True)[1]
    # Three sides, each nearly one grey: the direction to the eye changes a little across it.
    assert np.sort(counts)[-30:].sum() > 0.8 * counts.sum()
