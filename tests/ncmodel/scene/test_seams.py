"""Seams: vertices that a file holds once for each texture are one vertex of the surface."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from ncmodel.drawing.draw import draw
from ncmodel.mesh.load import load_mesh
from ncmodel.scene.seams import sew_seams
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Ints, Mesh
from tests.helpers import analytic


def cut_at(vertices: Floats, faces: Ints, left: Ints) -> Mesh:
    """The mesh in two parts with vertices of their own: the faces numbered in `left`, and the others."""
    part = np.zeros(len(faces), dtype=np.int64)
    part[left] = 1
    corners, place = np.unique(np.stack([np.repeat(part, 3), faces.ravel()], axis=1), axis=0, return_inverse=True)
    return Mesh(vertices[corners[:, 1]], place.reshape(-1, 3))


def test_a_sphere_cut_along_a_seam_is_closed_again() -> None:
    vertices, faces = analytic.sphere()
    cut = cut_at(vertices, faces, np.arange(len(faces) // 3))
    assert len(Surface(cut).boundary_edges) > 10
    whole = sew_seams(Surface(cut))
    assert whole.is_closed
    assert len(whole.mesh.vertices) == len(vertices)
    np.testing.assert_array_equal(whole.mesh.vertices[whole.mesh.faces], cut.vertices[cut.faces])
    extra = len(cut.vertices) - len(vertices)
    assert whole.mesh.notes == (f"sewed seams: {extra} vertices merged with others on borders at equal positions",)


def test_closed_shells_and_holes_stay_as_they_are() -> None:
    vertices, faces = analytic.sphere()
    twice = Mesh(np.concatenate([vertices, vertices]), np.concatenate([faces, faces + len(vertices)]))
    for mesh in (Mesh(vertices, faces), twice, Mesh(vertices, faces[7:])):
        surface = Surface(mesh)
        assert sew_seams(surface) is surface


def test_a_shell_that_touches_a_border_is_not_joined_to_it() -> None:
    vertices, faces = analytic.sphere()
    both = Mesh(np.concatenate([vertices, vertices]), np.concatenate([faces, faces[7:] + len(vertices)]))
    surface = Surface(both)
    assert sew_seams(surface) is surface


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".off"])
def test_drawings_of_files_show_no_seams(suffix: str, tmp_path: Path) -> None:
    vertices, faces = analytic.sphere()
    cut = cut_at(vertices, faces, np.flatnonzero(vertices[faces].mean(axis=1)[:, 2] > 0.1))
    trimesh.Trimesh(cut.vertices, cut.faces, process=False).export(tmp_path / f"cut{suffix}")
    drawing = draw(tmp_path / f"cut{suffix}", size=(100, 100), lines=["contours", "boundaries", "creases"])
    assert {stroke.family for stroke in drawing.strokes} == {"contours"}
    assert "sewed" in drawing.notes[0]
    assert len(load_mesh(tmp_path / f"cut{suffix}").vertices) == len(cut.vertices)


def test_a_mesh_is_drawn_as_its_file_is(tmp_path: Path) -> None:
    vertices, faces = analytic.sphere()
    cut = cut_at(vertices, faces[:, ::-1], np.flatnonzero(vertices[faces].mean(axis=1)[:, 2] > 0.1))
    trimesh.Trimesh(cut.vertices, cut.faces, process=False).export(tmp_path / "cut.ply")
    single = cut.vertices.astype(np.float32).astype(np.float64)  # as the file has them
    of_file, of_mesh = draw(tmp_path / "cut.ply"), draw(Mesh(single, cut.faces, "cut"))
    assert of_mesh.svg() == of_file.svg()
    assert of_mesh.notes[-2:] == of_file.notes[-2:]
    assert "outwards" in of_mesh.notes[-1]
