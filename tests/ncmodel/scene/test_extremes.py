"""Extreme input: a right result or one clear line, and no number that isn't one.

| case | outcome |
|---|---|
| coordinates at 1e-12, 1e12, 1e7 from the origin | as at 1, to the digits that are left |
| zero-area faces | no part in normals and curvature; everything else as without them |
| slivers and needles of aspect 1e6 | curvature as the definition has it, finite |
| coincident vertices | kept: curvature of loose faces is 0, all their sides are boundaries |
| unreferenced vertices, near or far | normal +y, curvature 0; everything else as without them |
| degenerate faces alone | boundaries alone |
| edges with three faces | no boundary, a crease if one pair of opposite sides bends |
| faces twice, back to back | the first face's side counts |
| inverted shells | curvature with the other sign |
| single triangle, plane | curvature 0, feature size 0.05 R, no line but boundaries |
| sphere (umbilic) | k1 = k2 = 1/R; lines of rounding noise only below 1e-6 of the default threshold |
| eye at a vertex | n.v = 0 there, as nothing is defined |
| two million faces | drawn, the whole process in less than 4 GB |
| eye inside; along a normal (s2 = 0); across it (n.v = 0) | finite; q1 at most (k / 1e-8)^2 |
"""

from pathlib import Path

import numpy as np
import pytest

from dataset_tools.simulation.shapes import bumpy_torus
from eval.benchmark.processes import run_command, write_ply
from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.lines import contours
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.feature_arrays import features
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import LineFamily, Mesh, Thresholds
from tests.helpers import analytic, extreme_meshes
from tests.helpers.extreme_meshes import MESHES
from tests.helpers.segments import agreement
from tests.helpers.views import eyes


@pytest.mark.parametrize("name", MESHES)
def test_every_number_is_finite(name: str) -> None:
    mesh = make_mesh(*MESHES[name]())
    surface = Surface(mesh)
    assert surface.feature_size > 0
    for label, eye in eyes(mesh).items():
        view = View(surface, Camera(eye, target=(3.0, 0.1, 0.2)))
        for key, value in features(view).items():
            assert np.isfinite(value).all(), (label, key)
        assert (np.abs(view.n_dot_v) <= 1 + 1e-12).all()
        assert (view.q1 >= 0).all()
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(surface.dir1, axis=1), 1, rtol=1e-12)
    np.testing.assert_allclose((surface.dir1 * surface.normals).sum(axis=1), 0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(surface.smoothed_normals, axis=2), 1, rtol=1e-12)
    assert 0 < Surface(mesh, sizing="sampled").feature_size < 1


@pytest.mark.parametrize(("name", "digits"), [("tiny", 10), ("huge", 10), ("far away", 4)])
def test_size_and_place_dont_matter(name: str, digits: int) -> None:
    plain = Surface(make_mesh(*analytic.torus(18, 10)))
    moved = Surface(make_mesh(*MESHES[name]()))
    np.testing.assert_allclose(moved.k1, plain.k1, rtol=10.0**-digits)
    assert moved.feature_size == pytest.approx(plain.feature_size, rel=10.0**-digits)


def test_zero_area_faces_change_nothing() -> None:
    vertices, faces = extreme_meshes.with_zero_area()
    with_them, without = Surface(Mesh(vertices, faces)), Surface(Mesh(vertices, faces[:-3]))
    for name in ("normals", "point_areas", "k1", "k2", "dcurv"):
        np.testing.assert_allclose(getattr(with_them, name), getattr(without, name), rtol=1e-12, atol=1e-15)


def test_unreferenced_vertices_change_nothing() -> None:
    plain, strays = Surface(Mesh(*analytic.torus(18, 10))), Surface(Mesh(*extreme_meshes.unreferenced()))
    np.testing.assert_array_equal(np.delete(strays.k1, [7, 8, 9]), plain.k1)
    np.testing.assert_array_equal(strays.normals[7:10], np.tile([0.0, 1.0, 0.0], (3, 1)))
    assert (strays.curvatures[7:10] == 0).all()
    assert strays.is_closed


def test_unreferenced_vertices_change_no_drawing() -> None:
    """Neither where they are, here 1e5 sizes away, nor how many: no size, no hidden part, no threshold follows them."""
    vertices, faces = analytic.torus(60, 30)
    vertices = vertices * (1 + 0.1 * np.sin(14 * vertices[:, :1]))
    strays = np.random.default_rng(0).normal(scale=1e5, size=(len(vertices), 3))
    thresholds = Thresholds(0.001, 0.02, 0.02, 0.02)
    plain, among = (
        draw(mesh, lines=list(LineFamily), thresholds=thresholds, size=(256, 256))
        for mesh in (Mesh(vertices, faces), Mesh(np.concatenate([strays, vertices]), faces + len(strays)))
    )
    assert {stroke.family for stroke in plain.strokes} >= {LineFamily.CONTOURS, LineFamily.RIDGES, LineFamily.APPARENT}
    assert len(plain.strokes) == len(among.strokes)
    for one, other in zip(plain.strokes, among.strokes, strict=True):
        np.testing.assert_allclose(one.points, other.points, atol=1e-6)


def test_nothing_but_degenerate_faces() -> None:
    """Faces without area have borders at most."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]])
    drawing = draw(make_mesh(vertices, [[0, 1, 2], [1, 2, 3], [2, 2, 3]]), lines=list(LineFamily), size=(64, 64))
    assert {stroke.family for stroke in drawing.strokes} <= {LineFamily.BOUNDARIES}
    assert np.isfinite(drawing.ink()).all()


def test_coincident_vertices_stay_apart() -> None:
    surface = Surface(make_mesh(*extreme_meshes.coincident()))
    assert (surface.curvatures == 0).all()
    assert len(surface.boundary_edges) == 3 * len(surface.mesh.faces)


def test_a_plane_is_flat_however_it_lies() -> None:
    rng = np.random.default_rng(6)
    for _ in range(10):
        rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        surface = Surface(make_mesh(analytic.plane(9)[0] @ rotation, analytic.plane(9)[1]))
        assert (surface.curvatures == 0).all()


@pytest.mark.parametrize("name", ["plane", "single triangle"])
def test_flat_things_have_no_lines_but_their_border(name: str) -> None:
    mesh = make_mesh(*MESHES[name]())
    view = View(Surface(mesh), Camera((0.3, 0.2, 2.0)))
    assert view.surface.feature_size == pytest.approx(
        0.05 * np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / 2, rel=1e-9
    )
    counts = {family.value: len(view.lines(family)) for family in LineFamily}
    assert counts.pop("boundaries") == {"plane": 24, "single triangle": 3}[name]
    assert set(counts.values()) == {0}


def test_a_sphere_has_its_outline_alone() -> None:
    """All its points are umbilics, so what other lines there are is rounding noise, far below any threshold."""
    view = View(Surface(make_mesh(*analytic.icosphere(3))), Camera((1.3, 1.1, 2.4)))
    assert len(view.lines(LineFamily.CONTOURS)) > 50
    assert view.lines(LineFamily.SUGGESTIVE).strength.max(initial=0.0) < 1e-8
    assert len(view.lines(LineFamily.VALLEYS)) == 0


def test_faces_twice_back_to_back_keep_the_first_side() -> None:
    vertices, _ = extreme_meshes.both_sides()
    surface = Surface(Mesh(*extreme_meshes.both_sides()))
    assert ((surface.normals * vertices).sum(axis=1) > 0.8).all()


def test_an_edge_of_three_faces() -> None:
    """Sides 0 -> 1 three times and never back: each is without a twin; turned to have one, a crease."""
    vertices, faces = extreme_meshes.three_faces_at_an_edge()
    surface = Surface(Mesh(vertices, faces))
    assert len(surface.boundary_edges) == 9
    faces[0] = [0, 1, 2]
    turned = Surface(Mesh(vertices, faces))
    assert len(turned.boundary_edges) == 6
    assert turned.creases().ends.tolist() == [[0, 1]]


def test_eye_at_a_vertex_sees_nothing_there() -> None:
    mesh = make_mesh(*analytic.torus(18, 10))
    x, y, z = mesh.vertices[5]
    view = View(Surface(mesh), Camera((float(x), float(y), float(z)), target=(3.0, 0.0, 0.0)))
    assert view.n_dot_v[5] == view.kr[5] == view.sc_num[5] == 0
    assert view.q1[5] == pytest.approx(view.surface.k1[5] ** 2)


def test_lines_of_an_inverted_shell_are_those_seen_from_within() -> None:
    """Turning a shell inside out turns ridges into valleys; contours swap what kr keeps."""
    outside = View(Surface(make_mesh(*analytic.torus(18, 10))), Camera((1.3, 1.1, 2.4)))
    inside = View(Surface(make_mesh(*extreme_meshes.inside_out())), Camera((1.3, 1.1, 2.4)))
    np.testing.assert_allclose(inside.surface.k1, -outside.surface.k1, rtol=1e-9)
    lines, turned = (
        contours.contours(view.mesh.vertices, view.surface.faces, view.n_dot_v, None) for view in (outside, inside)
    )
    assert agreement(lines.face, lines.points, turned.face, turned.points, 1e-9) == 1


def test_what_a_surface_holds_is_in_proportion_to_its_faces() -> None:
    """Some 130 bytes a face, apparent ridges included: 260 MB for two million."""
    vertices, faces = analytic.torus(200, 100)
    surface = Surface(Mesh(vertices, faces))
    view = View(surface, Camera((1.3, 1.1, 2.4)))
    view.lines(LineFamily.APPARENT)
    held = sum(_bytes(value) for owner in (surface, view) for value in owner.__dict__.values())
    assert 100 * len(faces) < held < 150 * len(faces)


def _bytes(value: object) -> int:
    """What an array, or a tuple of arrays, holds."""
    if isinstance(value, tuple):
        return sum(map(_bytes, value))
    return value.nbytes if isinstance(value, np.ndarray) else 0


@pytest.mark.slow
def test_two_million_faces_are_drawn_in_four_gigabytes(tmp_path: Path) -> None:
    """The whole process, all families, from the file to the SVG."""
    faces = write_ply(tmp_path / "large.ply", bumpy_torus(2_000_000))
    lines = ",".join(LineFamily)
    command = ["draw", str(tmp_path / "large.ply"), "-o", str(tmp_path / "large.svg"), "--lines", lines]
    run = run_command(command, "all families", faces)
    assert faces > 1_990_000
    assert run.peak_megabytes < 4000
    assert (tmp_path / "large.svg").stat().st_size > 10_000
