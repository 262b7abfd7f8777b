"""Orthographic views: as perspective ones from very far away, in every stage."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.lines.occlusion import Smooth
from ncmodel.lines.visibility import hidden_pieces, in_frame, visible_pieces
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, LineFamily, LineSet, Mesh
from tests.helpers import analytic
from tests.helpers.views import bumpy, parallel_and_far

SMOOTH = Mesh(*bumpy())
FLAT = Mesh(*analytic.cube(0.8))


def shape_with(family: LineFamily) -> Mesh:
    """A shape that shows lines of a family, and hides some."""
    vertices, faces = analytic.cube(0.8)
    if family is LineFamily.CREASES:
        return FLAT
    if family is LineFamily.BOUNDARIES:
        return Mesh(vertices, faces[1:])
    if family is LineFamily.INTERSECTIONS:
        other = vertices + (0.3, 0.3, -0.3)
        return Mesh(np.concatenate([vertices, other]), np.concatenate([faces, faces + len(vertices)]))
    if family in (LineFamily.RIDGES, LineFamily.VALLEYS):
        return Mesh(*analytic.height_field(lambda x, y: 0.05 * np.sin(9 * x) * np.cos(7 * y + x), 40))
    return SMOOTH


def sampled(lines: LineSet) -> Floats:
    """Points along lines."""
    share = np.linspace(0, 1, 5)[None, :, None]
    return (lines.points[:, :1] * (1 - share) + lines.points[:, 1:] * share).reshape(-1, 3)


def agree(one: LineSet, other: LineSet, within: float, share: float = 1.0) -> bool:
    """Whether that share of each lies within a distance of the other."""
    a, b = sampled(one), sampled(other)
    return all((cKDTree(q).query(p)[0] <= within).mean() >= share for p, q in ((a, b), (b, a)))


@pytest.mark.parametrize("family", list(LineFamily))
def test_lines_are_where_perspective_from_very_far_has_them(family: LineFamily) -> None:
    here, far = parallel_and_far(shape_with(family))
    assert len(here.lines(family)) > 0
    assert agree(here.lines(family), far.lines(family), 1e-4, 0.99)
    assert agree(here.visible(family), far.visible(family), 2e-3, 0.99)
    if len(here.hidden(family)):
        assert agree(here.hidden(family), far.hidden(family), 2e-3, 0.98)


def test_what_depends_on_the_view_agrees() -> None:
    here, far = parallel_and_far(SMOOTH)
    for name in ("n_dot_v", "kr", "sc_num"):
        assert getattr(here, name) == pytest.approx(getattr(far, name), abs=1e-3), name
    seen = np.abs(here.n_dot_v) > 0.1
    assert here.q1[seen] == pytest.approx(far.q1[seen], rel=1e-3, abs=1e-3)
    assert np.abs(here.depth - far.depth).max() < 1e-3
    assert np.mean(here.buffers.face != far.buffers.face) < 1e-3
    assert np.abs(here.shaded - far.shaded).mean() < 1e-4


def test_the_view_vector_is_the_same_everywhere() -> None:
    """A plate seen at a slant has one n.v, and its far side is as long as its near one."""
    plate = Mesh(*analytic.plane(4))
    camera = Camera((0.0, -2.0, 2.0), up=(0.0, 0.0, 1.0), focal_pixels=300.0, projection="orthographic")
    view = View(Surface(plate), camera)
    assert view.n_dot_v == pytest.approx(math.sqrt(0.5))
    corners = camera.project(np.array([[x, y, 0.0] for x in (-0.5, 0.5) for y in (-0.5, 0.5)]))
    assert corners[2:, 0] - corners[:2, 0] == pytest.approx([300.0, 300.0])
    assert corners[0, 1] - corners[1, 1] == pytest.approx(300.0 * math.sqrt(0.5))


def test_visible_and_hidden_are_all_lines() -> None:
    view, _ = parallel_and_far(SMOOTH)
    smooth = Smooth(view.mesh.vertices, view.surface.faces, view.surface.normals)
    lines = view.outlines
    parts = [piece(lines, view.camera, view.surface.scene, smooth) for piece in (visible_pieces, hidden_pieces)]
    whole = in_frame(lines, view.camera, view.surface.scene)

    def length(some: LineSet) -> float:
        return float(np.linalg.norm(some.points[:, 1] - some.points[:, 0], axis=1).sum())

    assert length(parts[0]) > 0 < length(parts[1])
    assert length(parts[0]) + length(parts[1]) == pytest.approx(length(whole), rel=1e-9)


def test_only_what_is_before_the_camera_plane_is_seen() -> None:
    """A plane through the middle of a cube: its front half is cut away, and its back wall is looked at."""
    camera = Camera((0.0, 0.0, 0.1), focal_pixels=300.0, projection="orthographic")
    view = View(Surface(FLAT), camera)
    seen = view.visible(LineFamily.CREASES)
    assert seen.points[..., 2].max() < 0.1
    assert (seen.points[..., 2] < -0.39).any(axis=1).sum() >= 4


@pytest.mark.parametrize("mesh", [SMOOTH, FLAT], ids=["smooth", "flat"])
def test_drawings_agree_with_perspective_from_very_far(mesh: Mesh) -> None:
    here, far = parallel_and_far(mesh)
    one, other = (draw(view.surface, view.camera, hidden="dashed") for view in (here, far))
    assert {s.group for s in one.strokes} == {s.group for s in other.strokes}
    assert np.abs(one.ink() - other.ink()).mean() < 0.1 * one.ink().mean()
