"""Contours and suggestive contours: against the plain definitions and closed forms."""

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.thresholding import fade
from ncmodel.lines import contours
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import LineFamily, Mesh, Threshold
from tests.helpers import analytic
from tests.helpers.segments import expected_segments, length, matched, same
from tests.helpers.views import EYE, seen


def test_zero_sets_by_their_definition_face_by_face(view: View) -> None:
    for family in (LineFamily.CONTOURS, LineFamily.SUGGESTIVE):
        expected = expected_segments(view, family)
        assert len(expected) > 5
        same(view.lines(family), expected)


@pytest.mark.parametrize("threshold", [0.001, 0.01, 0.1])
def test_thresholds_after_extraction_cut_suggestive_contours_as_thresholds_before(threshold: float, view: View) -> None:
    size = view.surface.feature_size
    expected = expected_segments(view, LineFamily.SUGGESTIVE, threshold / size**2)
    faded = fade(view.lines(LineFamily.SUGGESTIVE), Threshold(threshold))
    points = np.array([s[1] for s in expected]).reshape(-1, 2, 3)
    face = np.array([s[0] for s in expected], dtype=np.int64)
    assert matched(faded.face, faded.points, face, points, 1e-9) == len(expected) == len(faded)


def test_suggestive_strength_is_never_negative(view: View) -> None:
    lines = view.lines(LineFamily.SUGGESTIVE)
    assert (lines.strength >= 0).all()
    assert not np.isnan(lines.strength).any()


def test_the_sign_of_kr_parts_the_zeros_of_n_dot_v(view: View) -> None:
    """Contours for kr and for -kr make up all of n.v = 0."""
    vertices, faces, nv = view.mesh.vertices, view.surface.faces, view.n_dot_v
    parts = [contours.contours(vertices, faces, nv, kr).points for kr in (view.kr, -view.kr)]
    assert min(map(length, parts)) > 0
    assert sum(map(length, parts)) == pytest.approx(length(contours.contours(vertices, faces, nv, None).points))


def test_outlines_without_curvature_are_contours_with_it() -> None:
    """On a fine torus, where half of n.v = 0 is hidden by the solid, all but the ends of lines agree."""
    view = seen(analytic.torus(96, 48))
    outlines, drawn = view.outlines, view.lines(LineFamily.CONTOURS)
    everything = contours.contours(view.mesh.vertices, view.surface.faces, view.n_dot_v, None)
    assert matched(outlines.face, outlines.points, drawn.face, drawn.points, 1e-9) > 0.98 * len(drawn)
    assert length(outlines.points) == pytest.approx(length(drawn.points), rel=0.01)
    assert length(drawn.points) < 0.9 * length(everything.points)


def test_outlines_of_a_sheet_are_all_zeros() -> None:
    """Seen from behind, an open half of a torus has contours where a solid would hide them."""
    vertices, faces = analytic.torus(48, 24)
    view = seen((vertices, faces[: len(faces) // 2]))
    assert len(view.outlines) > len(view.lines(LineFamily.CONTOURS))


@pytest.mark.parametrize("subdivisions", [3, 4, 5])
def test_contour_of_a_sphere_is_its_circle(subdivisions: int) -> None:
    """n.v = 0 on a sphere is a plane's section: where normals are exact, the line lies on it to second order."""
    vertices, faces = analytic.icosphere(subdivisions, 0.5)
    camera = Camera(EYE)
    lines = View(Surface(Mesh(vertices, faces)), camera).lines(LineFamily.CONTOURS)
    pixels = camera.project(lines.points.reshape(-1, 3))[:, :2]
    distance = np.linalg.norm(EYE)
    radius = camera.focal_pixels * 0.5 / np.sqrt(distance**2 - 0.25)
    error = np.abs(np.linalg.norm(pixels - 384, axis=1) - radius).max()
    edge = 0.5 * 1.1 / 2**subdivisions
    assert error < camera.focal_pixels / distance * edge**2 / 0.5 / 4
    assert subdivisions < 5 or error < 0.5
    assert len(lines) > 2 * np.pi / 1.1 * 2**subdivisions
