"""Signed distances against closed forms, sculptures against the volumes they should have, patches closed."""

import numpy as np
import pytest

from dataset_tools.modelling.fields import (
    Part,
    Place,
    drum,
    ellipsoid,
    frame,
    limb,
    placed,
    prism,
    repeated,
    ring,
    slab,
)
from dataset_tools.modelling.patches import block, extrusion, lathe, loft, sheet, tube
from dataset_tools.modelling.sculpting import Sculpture, Surface, decimated
from ncmodel.types import Floats
from tests.helpers.dirty import is_closed, signed_volume

SQUARE = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]


@pytest.mark.parametrize(
    ("part", "point", "distance"),
    [
        (ellipsoid((1, 0, 0), 0.5), (2, 0, 0), 0.5),
        (slab((0, 0, 0), (1, 2, 3), 0.2), (1.5, 0, 0), 0.5),
        (slab((0, 0, 0), (1, 1, 1), 0, frame(np.pi / 4)), (0, 0, 2), 2 - np.sqrt(2)),
        (drum((0, 0, 0), (0, 0, 2), 0.5), (1.5, 0, 1), 1.0),
        (ring((0, 0, 0), (0, 1, 0), 1.0, 0.25), (1, 0, 0), -0.25),
        (limb([(0, 0, 0), (0, 2, 0)], [0.5, 0.3]), (1, 1, 0), 0.6),
        (prism(SQUARE, 1.0), (0, 0, 0), -0.5),
        (repeated(ellipsoid((0, 0, 1), 0.25), 4), (1.5, 0, 0), 0.25),
        (placed(ellipsoid((0, 0, 0), 1.0), Place(np.array([3.0, 0, 0]), scale=0.5)), (3, 0, 2), 1.5),
    ],
)
def test_distances_of_parts(part: Part, point: tuple[float, float, float], distance: float) -> None:
    assert part.distance(np.array([point], dtype=float))[0] == pytest.approx(distance, abs=1e-9)


def test_a_ball_with_a_bore_has_its_volume() -> None:
    work = Sculpture()
    work.add(ellipsoid((0, 0, 0), 1.0))
    work.cut(drum((0, -2, 0), (0, 2, 0), 0.6))
    vertices, faces = work.mesh(20_000)
    assert is_closed(faces)
    assert 14_000 < len(faces) < 26_000
    # Napkin ring: what is left of a ball depends on the height of the bore's wall alone.
    assert signed_volume(vertices, faces) == pytest.approx(np.pi / 6 * 1.6**3, rel=0.01)
    radius = np.linalg.norm(vertices[np.hypot(vertices[:, 0], vertices[:, 2]) > 0.75], axis=1)
    assert np.abs(radius - 1).max() < 1e-3


def test_pressing_raises_the_surface_in_its_region_only() -> None:
    work = Sculpture()
    work.add(ellipsoid((0, 0, 0), 1.0))
    work.press(slab((1, 0, 0), (0.5, 0.5, 0.5)), lambda points: np.full(len(points), 0.05), 0.1)
    vertices, _ = work.mesh(12_000)
    radius = np.linalg.norm(vertices, axis=1)
    assert radius[vertices[:, 0] > 0.98].min() > 1.03
    assert np.abs(radius[vertices[:, 0] < 0]).max() < 1.005


def test_fewer_faces_keep_the_shape() -> None:
    work = Sculpture()
    work.add(slab((0, 0, 0), (1, 0.5, 0.5), 0.1))
    fine = work.mesh(12_000)
    coarse = decimated(fine, 3_000)
    assert len(coarse[1]) == pytest.approx(3_000, abs=30)
    assert signed_volume(*coarse) == pytest.approx(signed_volume(*fine), rel=0.002)


def _circle(height: float) -> Floats:
    angle = np.linspace(0, -2 * np.pi, 24, endpoint=False)  # anticlockwise against +y
    return np.stack([np.cos(angle), np.full(24, height), np.sin(angle)], axis=1)


@pytest.mark.parametrize(
    ("surface", "volume"),
    [
        (block((1, 0.5, 0.25), 0.05), 1.0),
        (lathe([(1, 0), (1, 2)], 96), 2 * np.pi),
        (tube([(0, 0, 0), (0, 1, 0), (0, 2, 0)], 0.5, 96), 0.5 * np.pi),
        (loft([_circle(0), _circle(1)]), 12 * np.sin(2 * np.pi / 24)),
        (extrusion(SQUARE, 2.0), 2.0),
        (sheet(np.stack([*np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9)), np.zeros((9, 9))], -1), 0.1), 0.1),
    ],
    ids=["block", "lathe", "tube", "loft", "extrusion", "sheet"],
)
def test_patches_are_closed_solids(surface: Surface, volume: float) -> None:
    vertices, faces = surface
    assert is_closed(faces)
    assert signed_volume(vertices, faces) == pytest.approx(volume, rel=0.02)
