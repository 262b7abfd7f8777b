"""Surfaces parted at creases."""

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.scene.creases import crease_lines, split_at_creases
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Ints, LineFamily, Mesh
from tests.helpers import analytic
from tests.helpers.dirty import inside_out, joined

Geometry = tuple[Floats, Ints]


def surface(geometry: Geometry) -> Surface:
    return Surface(Mesh(*geometry))


def can(sides: int = 48, radius: float = 0.3, height: float = 1.0) -> Geometry:
    """A closed cylinder about y whose caps share their rims with the tube."""
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    ring = np.stack([radius * np.sin(angle), 0 * angle, radius * np.cos(angle)], axis=1)
    up = np.array([0, height / 2, 0])
    vertices = np.concatenate([ring + up, ring - up, [up, -up]])
    i, j = np.arange(sides), np.roll(np.arange(sides), -1)
    tube = np.concatenate([np.stack([i, i + sides, j + sides], 1), np.stack([i, j + sides, j], 1)])
    top, bottom = np.stack([i, j, 0 * i + 2 * sides], 1), np.stack([j, i, 0 * i + 2 * sides + 1], 1)
    return vertices, np.concatenate([tube, top, bottom + [sides, sides, 0]])


def test_cube_falls_into_six_sides() -> None:
    whole = surface(analytic.cube())
    parts = split_at_creases(whole, 40.0)
    assert len(parts.mesh.vertices) == 24
    np.testing.assert_allclose(parts.mesh.vertices[parts.faces], whole.mesh.vertices[whole.faces])
    np.testing.assert_allclose(np.abs(parts.normals).max(axis=1), 1.0)
    centres = parts.mesh.vertices[parts.faces].mean(axis=1)
    assert (np.einsum("fcx,fx->fc", parts.normals[parts.faces], centres) > 0.49).all()


@pytest.mark.parametrize("geometry", [analytic.icosphere(3), analytic.torus(32, 16), analytic.plane(4)])
def test_smooth_surfaces_are_left_alone(geometry: Geometry) -> None:
    whole = surface(geometry)
    assert split_at_creases(whole, 40.0) is whole


def test_angle_decides() -> None:
    folded = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 1], [2, 1, 1]], dtype=float)  # by 45 degrees
    faces = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]])
    assert len(split_at_creases(surface((folded, faces)), 44.0).mesh.vertices) == 8
    assert len(split_at_creases(surface((folded, faces)), 46.0).mesh.vertices) == 6


def test_can_has_round_sides_and_flat_caps() -> None:
    parts = split_at_creases(surface(can()), 40.0)
    on_rim = np.abs(np.abs(parts.mesh.vertices[:, 1]) - 0.5) < 1e-9
    upright = np.abs(parts.normals[:, 1])
    assert (np.isclose(upright, 1.0, atol=1e-9) | np.isclose(upright, 0.0, atol=1e-9))[on_rim].all()
    tube = upright < 0.5
    np.testing.assert_allclose(parts.k1[tube], 1 / 0.3, rtol=0.05)
    np.testing.assert_allclose(parts.k1[~tube], 0.0, atol=1e-9)


def test_can_is_outlined_by_two_straight_contours() -> None:
    camera = Camera((0.0, 1.0, 4.0))
    lines = View(split_at_creases(surface(can()), 40.0), camera).visible(LineFamily.CONTOURS)
    assert np.linalg.norm(lines.points[:, 1] - lines.points[:, 0], axis=1).sum() == pytest.approx(2.0, rel=0.02)
    assert np.ptp(np.abs(lines.points[..., 0])) < 0.01


def prism(sides: int, rows: int = 8) -> Geometry:
    """An open tube with flat sides, each one quad wide."""
    return analytic.cylinder(rows, sides)


def ragged(zigzag: float, height: float, teeth: int = 20) -> Geometry:
    """Two flat strips that meet along a line which zigzags in plan, at an angle that `height` sets."""
    x = np.arange(teeth + 1) / teeth
    middle = np.stack([x, zigzag / teeth * (-1.0) ** np.arange(teeth + 1), 0 * x + height], axis=1)
    left, right = (np.stack([x, 0 * x + side, 0 * x], axis=1) for side in (-1.0, 1.0))
    vertices, n = np.concatenate([left, middle, right]), teeth + 1
    i = np.arange(teeth)
    strips = [np.stack([i + a, i + a + 1, i + a + n + 1], 1) for a in (0, n)]
    strips += [np.stack([i + a, i + a + n + 1, i + a + n], 1) for a in (0, n)]
    return vertices, np.concatenate(strips)


@pytest.mark.parametrize("sides", [6, 8])
def test_even_edges_are_lines_however_weak(sides: int) -> None:
    tube = surface(prism(sides))
    assert len(tube.creases(40.0)) == len(crease_lines(tube, 40.0).sharp) == sides * 7


@pytest.mark.parametrize(("height", "drawn"), [(0.45, 0), (0.9, 20)])
def test_weak_zigzags_are_no_lines_and_strong_ones_are(height: float, drawn: int) -> None:
    bent = surface(ragged(0.2, height))
    middle = bent.creases(40.0)
    assert len(middle) == 20
    assert len(crease_lines(bent, 40.0).sharp) == drawn
    assert (split_at_creases(bent, 40.0) is bent) == (drawn == 0)
    view = View(bent, Camera((0.5, 0.0, 4.0), target=(0.5, 0.0, 0.0)), 40.0)
    assert len(view.lines(LineFamily.CREASES)) == 20
    assert len(view.candidates(LineFamily.CREASES)) == drawn


@pytest.mark.parametrize("angle", [1.0, 119.0, 121.0, 170.0])
def test_every_angle_is_fine(angle: float) -> None:
    folded = surface(ragged(0.2, 5.0))
    assert len(crease_lines(folded, angle).sharp) <= len(folded.creases(angle))


def test_weak_lines_that_run_straight_stay() -> None:
    bent = surface(ragged(0.0, 0.5))
    assert len(crease_lines(bent, 40.0).sharp) == 20


def test_what_belongs_to_the_whole_stays() -> None:
    whole = surface(analytic.cube())
    parts = split_at_creases(whole, 40.0)
    assert parts.is_closed
    assert len(parts.boundary_edges) == 0
    assert len(parts.creases(40.0)) == 12
    assert parts.scene is whole.scene
    assert parts.trace is whole.trace


def test_two_sided_sheets_keep_a_normal_a_side() -> None:
    sheet = analytic.plane(3)
    both = surface((sheet[0], np.concatenate([sheet[1], inside_out(sheet)[1]])))
    parts = split_at_creases(both, 40.0)
    assert len(parts.mesh.vertices) == 2 * len(sheet[0])
    facing = parts.normals[parts.faces][:, :, 2]
    np.testing.assert_allclose(facing[: len(sheet[1])], 1.0)
    np.testing.assert_allclose(facing[len(sheet[1]) :], -1.0)


def test_two_sided_sheets_have_creases_at_bends_and_borders_only() -> None:
    vertices, faces = analytic.plane(4)
    bent = vertices * [1, 1, 0] + np.abs(vertices[:, :1]) * [0, 0, 2]
    both = surface((bent, np.concatenate([faces, faces[:, ::-1]])))
    found = both.mesh.vertices[both.creases(40.0).ends]
    on_bend = (np.abs(found[..., 0]) < 1e-9).all(axis=1)
    outer = np.abs(np.abs(found[..., :2]) - 0.5) < 1e-9
    on_border = outer[:, 0, 0] & outer[:, 1, 0] | outer[:, 0, 1] & outer[:, 1, 1]
    assert (on_bend.sum(), on_border.sum(), len(found)) == (4, 16, 20)


def test_parts_do_not_depend_on_the_order_of_faces() -> None:
    geometry = joined(can(), analytic.cube())
    order = np.random.default_rng(0).permutation(len(geometry[1]))
    one, other = (
        split_at_creases(surface(geometry), 40.0),
        split_at_creases(surface((geometry[0], geometry[1][order])), 40.0),
    )
    np.testing.assert_allclose(one.normals[one.faces][order], other.normals[other.faces], atol=1e-12)


def test_degenerate_faces_and_edges_of_three_faces_do_no_harm() -> None:
    vertices, faces = can(12)
    fin = np.array([[0.0, 0.8, 0.9]])
    odd = np.concatenate([faces, [[0, 0, 1], [2, 2, 2], [0, 1, len(vertices)]]])
    parts = split_at_creases(surface((np.concatenate([vertices, fin]), odd)), 40.0)
    assert np.isfinite(parts.normals).all()
    np.testing.assert_array_equal(parts.mesh.vertices[parts.faces[-1]][2], fin[0])


def test_a_parted_surface_is_parted_anew_at_another_angle() -> None:
    whole, camera = surface(can()), Camera.orbit(can()[0], 30.0, 20.0, size=(256, 256))
    anew = split_at_creases(split_at_creases(whole, 20.0), 60.0)
    assert anew is split_at_creases(whole, 60.0)
    assert split_at_creases(anew, 60.0) is anew
    found = View(anew, camera, 50.0).candidates(LineFamily.CREASES)
    np.testing.assert_array_equal(found.points, View(whole, camera, 50.0).candidates(LineFamily.CREASES).points)
