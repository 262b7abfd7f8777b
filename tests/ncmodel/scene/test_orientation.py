"""Faces turned outwards: whole shells, single faces, and what must stay as it is."""

from pathlib import Path

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.scene.orientation import turn_outwards
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Ints, LineFamily, Mesh
from tests.helpers import analytic, extreme_meshes
from tests.helpers.dirty import face_normals, moved
from tests.helpers.mesh_files import write_obj

Geometry = tuple[Floats, Ints]

BALL: Geometry = analytic.icosphere(3)


def reversed_faces(geometry: Geometry) -> Geometry:
    return geometry[0], geometry[1][:, ::-1].copy()


def together(*parts: Geometry) -> Geometry:
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [faces + offset for (_, faces), offset in zip(parts, offsets, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)


def some_reversed(geometry: Geometry, share: float) -> Geometry:
    vertices, faces = geometry
    chosen = np.random.default_rng(0).random(len(faces)) < share
    return vertices, np.where(chosen[:, None], faces[:, ::-1], faces)


INNER = moved(BALL, scale=0.5)
BESIDE = moved(BALL, (0.3, 2.5, 0.1))
BOTTLE = BALL[0], BALL[1][BALL[0][BALL[1]].min(axis=1)[:, 1] > -0.9]

TURNED: dict[str, tuple[Geometry, Geometry]] = {
    "inside out": (reversed_faces(BALL), BALL),
    "a torus inside out": (extreme_meshes.inside_out(), analytic.torus(18, 10)),
    "one of two": (together(BALL, reversed_faces(BESIDE)), together(BALL, BESIDE)),
    "some faces": (some_reversed(BALL, 0.2), BALL),
    "most faces": (some_reversed(BALL, 0.8), BALL),
    "a bottle": (reversed_faces(BOTTLE), BOTTLE),
    "a tube": (reversed_faces(analytic.cylinder(5, 20, 1.0, 2.0)), analytic.cylinder(5, 20, 1.0, 2.0)),
    "outer of two": (together(reversed_faces(BALL), INNER), together(BALL, INNER)),
    "twice, once inside out": (together(BALL, reversed_faces(BALL)), together(BALL, BALL)),
}

KEPT: dict[str, Geometry] = {
    "outwards": BALL,
    "a cavity": together(BALL, reversed_faces(INNER)),
    "within another": together(BALL, INNER),
    "a bowl": (BALL[0], BALL[1][BALL[0][BALL[1]].max(axis=1)[:, 1] < 0.1][:, ::-1]),
    "a sheet": analytic.plane(6),
    "both sides": extreme_meshes.both_sides(),
    "three faces at an edge": extreme_meshes.three_faces_at_an_edge(),
    "a point": (np.zeros((3, 3)), np.array([[0, 1, 2]])),
}


@pytest.mark.parametrize("name", TURNED)
def test_shells_and_faces_are_turned(name: str) -> None:
    (vertices, faces), (_, expected) = TURNED[name]
    turned = turn_outwards(Surface(Mesh(vertices, faces)))
    swapped = (faces != expected).any(axis=1)
    np.testing.assert_array_equal(np.sort(turned.mesh.faces, axis=1), np.sort(expected, axis=1))
    np.testing.assert_allclose(face_normals(vertices, turned.mesh.faces), face_normals(vertices, expected), atol=1e-12)
    assert turned.mesh.notes == (f"turned {swapped.sum()} faces of {len(faces)} outwards",)


@pytest.mark.parametrize("name", KEPT)
def test_what_is_right_or_has_no_outside_stays(name: str) -> None:
    surface = Surface(Mesh(*KEPT[name]))
    assert turn_outwards(surface) is surface


def test_a_room_is_seen_from_within() -> None:
    surface = Surface(Mesh(*reversed_faces(moved(BALL, scale=0.5))))
    assert turn_outwards(surface, (0.1, 0.0, 0.2)) is surface
    assert turn_outwards(surface, (0.45, 0.45, 0.45)) is not surface
    assert turn_outwards(surface, (0.0, 0.0, 3.0)) is not surface


def test_a_moebius_strip_is_left_with_one_seam() -> None:
    """No turning helps where a strip meets itself the wrong way round."""
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    rims = [
        np.stack([(1 + w * np.cos(turn / 2)) * f for f in (np.cos(turn), np.sin(turn))] + [w * np.sin(turn / 2)], 1)
        for w in (-0.3, 0.3)
    ]
    n = np.arange(60)
    after = np.concatenate([n[1:], [60]])
    beyond = np.concatenate([n[1:] + 60, [0]])
    faces = np.concatenate([np.stack([n, after, n + 60], 1), np.stack([after, beyond, n + 60], 1)])
    strip = turn_outwards(Surface(Mesh(np.concatenate(rims), faces)))
    assert len(strip.boundary_edges) == 120 + 2


@pytest.mark.parametrize("lines", [[LineFamily.CONTOURS], list(LineFamily)])
def test_a_file_that_is_inside_out_is_drawn_as_the_other(lines: list[LineFamily], tmp_path: Path) -> None:
    vertices, faces = analytic.torus(40, 20)
    drawings = [
        draw(write_obj(tmp_path / f"{n}.obj", (vertices, wound)), lines=lines, size=(200, 200))
        for n, wound in enumerate((faces, faces[:, ::-1], some_reversed((vertices, faces), 0.3)[1]))
    ]
    assert drawings[0].ink().sum() > 100
    assert drawings[0].notes == ()
    for other in drawings[1:]:
        assert len(other.notes) == 1
        assert np.abs(other.ink() - drawings[0].ink()).mean() < 1e-3


def test_an_eye_within_a_shell_sees_its_inside(tmp_path: Path) -> None:
    room = write_obj(tmp_path / "room.obj", reversed_faces(analytic.icosphere(2)))
    assert draw(room, Camera((0.0, 0.1, 0.0), target=(1.0, 0.0, 0.0))).notes == ()
