"""Ridges, valleys and apparent ridges: against the plain definitions and closed forms."""

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.draw import visible_segments
from ncmodel.lines.ridges import resolved_in_view
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import LineFamily, LineSet, Mesh
from tests.helpers import analytic
from tests.helpers.segments import expected_segments, matched, same
from tests.helpers.views import EYE, bumpy


@pytest.mark.parametrize("family", ["ridges", "valleys", "apparent"])
def test_the_definitions_face_by_face(view: View, family: str) -> None:
    lines = view.lines(LineFamily(family))
    expected = expected_segments(view, lines.family)
    assert len(expected) > 5
    same(lines, expected)


@pytest.mark.parametrize("family", ["ridges", "valleys", "apparent"])
def test_strength_along_the_segments(view: View, family: str) -> None:
    lines = view.lines(LineFamily(family))
    expected = {(s[0], tuple(np.round(s[1][0], 9))): s[2] for s in expected_segments(view, lines.family)}
    for face, points, feature in zip(lines.face, lines.points, lines.feature, strict=True):
        found = expected.get((int(face), tuple(np.round(points[0], 9))))
        if found is None:  # the oracle ran along it the other way
            found = expected[int(face), tuple(np.round(points[1], 9))][::-1]
        np.testing.assert_allclose(feature, found, rtol=1e-9)


def test_ridges_and_valleys_of_a_wavy_sheet() -> None:
    """Crests of z = a cos(x) are ridges, troughs valleys, all along y."""
    vertices, faces = analytic.height_field(lambda x, y: 0.05 * np.cos(4 * np.pi * x) + 0 * y, 101)
    view = View(Surface(Mesh(vertices, faces)), Camera((0.2, 0.1, 3.0)))
    for family, places in ((LineFamily.RIDGES, [-0.5, 0.0, 0.5]), (LineFamily.VALLEYS, [-0.25, 0.25])):
        lines = view.lines(family).points
        inner = lines[(np.abs(lines[..., :2]) < 0.45).all(axis=(1, 2))]
        off = np.abs(inner[..., 0, None] - np.array(places)).min(axis=-1)
        assert off.max() < 1e-3
        along = np.abs(inner[:, 1, 1] - inner[:, 0, 1]).sum()
        assert along == pytest.approx(0.9 * sum(abs(place) < 0.45 for place in places), rel=0.05)


def test_lines_stay_when_faces_are_reordered(view: View) -> None:
    rng = np.random.default_rng(5)
    vertices, faces = bumpy(0.3, 20.0)
    order = rng.permutation(len(faces))
    other = View(Surface(Mesh(vertices, faces[order])), Camera(EYE))
    for family in LineFamily:
        lines, reordered = view.lines(family), other.lines(family)
        assert len(lines) == len(reordered)
        assert len(lines) > 5 or family in (LineFamily.BOUNDARIES, LineFamily.CREASES)
        assert matched(lines.face, lines.points, order[reordered.face], reordered.points, 1e-9) == len(lines)


@pytest.mark.parametrize(
    ("n_dot_v", "told"),
    [((0.6, 0.9, 0.8), True), ((0.3, 0.6, 0.4), True), ((0.3, 0.61, 0.4), False), ((-0.1, 0.2, 0.1), False)],
)
def test_an_apparent_ridge_needs_a_face_over_which_n_dot_v_changes_by_less_than_it_is(
    n_dot_v: tuple[float, float, float], told: bool
) -> None:
    level = np.ones((1, 2))
    line = LineSet(LineFamily.APPARENT, np.zeros((1, 2, 3)), np.array([1]), level, level)
    faces = np.array([[0, 0, 0], [1, 2, 0]], dtype=np.uint32)
    assert len(resolved_in_view(line, faces, np.array(n_dot_v))) == told


def test_only_finished_drawings_leave_out_apparent_ridges_on_coarse_faces() -> None:
    view = View(Surface(Mesh(*bumpy(0.3, 20.0))), Camera(EYE))
    found = visible_segments(view, LineFamily.APPARENT)
    finished = visible_segments(view, LineFamily.APPARENT, finished=True)
    assert 0 < len(finished) < len(found)
    n_dot_v = view.n_dot_v[view.surface.faces[finished.face]]
    assert (np.abs(n_dot_v).min(axis=1) >= np.ptp(n_dot_v, axis=1)).all()
