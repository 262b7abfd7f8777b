"""Extraction of the line families: against the plain definitions and closed forms."""

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.thresholding import fade
from ncmodel.lines import contours
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, LineFamily, LineSet, Mesh, Threshold
from tests.helpers import analytic, spec_oracle
from tests.helpers.segments import matched
from tests.helpers.spec_oracle import Segment
from tests.ncmodel.geometry.test_curvature import EYE, bumpy, seen


@pytest.fixture(scope="module")
def view() -> View:
    """A mesh with lines of every family."""
    return seen(bumpy(0.3, 20.0))


def expected_segments(view: View, family: LineFamily, threshold: float = 0.0) -> list[Segment]:
    """The oracle's segments from the view's own vertex quantities, at a raw threshold (suggestive contours alone)."""
    vertices, faces, surface = view.mesh.vertices, view.mesh.faces, view.surface
    nv = view.n_dot_v
    if family is LineFamily.CONTOURS:
        return spec_oracle.zero_set(vertices, faces, nv, view.kr, None, None)
    if family is LineFamily.SUGGESTIVE:
        return spec_oracle.zero_set(vertices, faces, view.kr, view.sc_num - threshold * nv, nv, nv)
    if family is LineFamily.APPARENT:
        t1 = view.t1[:, :1] * surface.dir1 + view.t1[:, 1:] * surface.dir2
        return spec_oracle.extrema(vertices, faces, view.dt1q1, t1, view.q1, None, 1.0)
    g = 1.0 if family is LineFamily.RIDGES else -1.0
    return spec_oracle.extrema(vertices, faces, surface.dcurv[:, 0], surface.dir1, surface.k1, nv, g)


def same(lines: LineSet, expected: list[Segment]) -> None:
    face, points = np.array([s[0] for s in expected]), np.array([s[1] for s in expected]).reshape(-1, 2, 3)
    assert len(lines) == len(expected)
    assert matched(lines.face, lines.points, face, points, 1e-9) == len(expected)


@pytest.mark.parametrize("family", ["contours", "suggestive", "ridges", "valleys", "apparent"])
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


def length(segments: Floats) -> float:
    return float(np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum())


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
        assert matched(lines.face, lines.points, order[reordered.face], reordered.points, 1e-9) == len(lines)
