"""What lies far away is told, and nothing else."""

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.stray_parts import stray_parts
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Ints, Mesh
from tests.helpers import analytic
from tests.helpers.dirty import joined, moved

Geometry = tuple[Floats, Ints]
TORUS = analytic.torus(24, 12)
TRIANGLE = np.eye(3), np.array([[0, 1, 2]])


def notes_of(*parts: Geometry) -> tuple[str, ...]:
    return stray_parts(Surface(make_mesh(*joined(*parts))))


@pytest.mark.parametrize("place", [(40.0, 0.0, 0.0), (0.0, -9.0, 0.0), (30.0, 30.0, -30.0)])
def test_a_triangle_far_away_is_told(place: tuple[float, float, float]) -> None:
    (note,) = notes_of(TORUS, moved(TRIANGLE, place))
    assert note.startswith("1 of 2 parts, 1 of 577 faces, far away: the rest measures ")
    assert "take them out" in note


def test_strays_on_both_sides_are_told_together() -> None:
    (note,) = notes_of(
        TORUS, moved(TRIANGLE, (40.0, 0.0, 0.0)), moved(TORUS, (1.2, 0.0, 0.0)), moved(TRIANGLE, (0.0, -30.0, 0.0))
    )
    assert note.startswith("2 of 4 parts, 2 of 1154 faces, ")


@pytest.mark.parametrize(
    "parts",
    [
        [TORUS],
        [TORUS, moved(TORUS, (1.2, 0.0, 0.0))],
        [TORUS, moved(TORUS, (2.5, 0.0, 0.0))],
        [TORUS, moved(TRIANGLE, (0.6, 0.3, 0.0), 0.1)],
        [moved(TORUS, (0.0, 0.0, x)) for x in np.arange(0.0, 12.0, 1.5).tolist()],
        [TORUS, moved(analytic.plane(4), (0.0, 0.0, -0.2), 8.0)],
    ],
)
def test_shapes_of_parts_have_no_note(parts: list[Geometry]) -> None:
    assert notes_of(*parts) == ()


def test_a_drawing_has_the_note_unless_a_camera_frames_it() -> None:
    mesh = make_mesh(*joined(TORUS, moved(TRIANGLE, (40.0, 0.0, 0.0))))
    assert any("far away" in note for note in draw(mesh, lines="contours", size=64).notes)
    framed = draw(mesh, Camera.orbit(mesh.vertices, size=(64, 64)), "contours")
    assert not any("far away" in note for note in framed.notes)
    assert draw(Mesh(*TORUS), lines="contours", size=64).notes == ()
