"""Files that are z-up are told where left and right say so, and no others."""

from pathlib import Path

import numpy as np
import pytest

from ncmodel.drawing.draw import draw
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.surface import Surface
from ncmodel.scene.upright import looks_z_up
from ncmodel.types import Floats, Ints
from tests.helpers import analytic
from tests.helpers.dirty import joined, moved

X, Y, Z = np.eye(3)
BODY, HEAD = analytic.ellipsoid(3, (1.0, 0.5, 0.6)), analytic.icosphere(2, 0.3)
ANIMAL = joined(BODY, moved(HEAD, (1.0, 0.0, 0.6)))
"""Looks along x, stands upright along z; left and right are along y."""
BRACKET = joined(
    analytic.cube(), moved(analytic.cube(0.5), (0.75, 0.25, 0.75)), moved(analytic.cube(0.5), (0.75, -0.25, 0.75))
)


def noted(vertices: Floats, faces: Ints) -> bool:
    return bool(looks_z_up(Surface(make_mesh(vertices, faces))))


@pytest.mark.parametrize("forwards", [X, -X])
def test_an_animal_on_its_side_is_told(forwards: Floats) -> None:
    vertices, faces = ANIMAL
    turned = vertices @ np.stack([forwards, forwards[0] * Y, Z])
    assert noted(turned, faces)
    (note,) = looks_z_up(Surface(make_mesh(turned, faces)))
    assert "try --up z" in note


@pytest.mark.parametrize(
    "turn", [np.stack([X, -Z, Y]), np.stack([Z, X, Y]), np.stack([-X, Z, Y]), np.stack([Y, X, -Z])]
)
def test_an_animal_that_stands_is_not(turn: Floats) -> None:
    vertices, faces = ANIMAL
    assert not noted(vertices @ turn, faces)


def test_what_is_alike_above_and_below_for_other_reasons_is_not() -> None:
    vertices, faces = ANIMAL
    assert not noted(vertices * [1.0, 0.2, 1.0], faces)
    assert not noted(*BRACKET)
    assert not noted(*analytic.torus())
    assert not noted(*analytic.ellipsoid(3))


def test_draw_tells_it_of_files_unless_they_are_said_to_be_z_up(tmp_path: Path) -> None:
    vertices, faces = ANIMAL
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path = tmp_path / "animal.obj"
    path.write_text("\n".join(lines))
    assert any("looks z-up" in note for note in draw(path, lines="contours", size=64).notes)
    assert not any("looks z-up" in note for note in draw(path, lines="contours", size=64, up="z").notes)
    assert not any("looks z-up" in note for note in draw(make_mesh(*ANIMAL), lines="contours", size=64).notes)
