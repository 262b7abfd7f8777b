"""Lines behind the surface: all that visible ones leave out, each once, as dashes or a layer."""

import re
import zlib
from pathlib import Path

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.drawing.drawing import Drawing
from ncmodel.errors import ArgumentError
from ncmodel.export.dashes import dashed
from ncmodel.lines.visibility import in_frame
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, Floats, LineFamily, LineSet, Mesh, Stroke
from tests.helpers import analytic
from tests.helpers.dirty import box, joined
from tests.helpers.pictures import objects_of

HIDDEN_CORNER = (-0.5, -0.5, -0.5)
"""Of the cube, from the default view."""
ABSENT = (LineFamily.BOUNDARIES, LineFamily.VALLEYS)
"""What `knobs` have none of, or none that is hidden."""


def cube() -> Mesh:
    return make_mesh(*box(), name="cube")


def knobs() -> Mesh:
    """A torus before and through which boxes stand: lines of all families hide each other."""
    ring = analytic.torus(48, 24)
    posts = [box((x, -0.4, -0.08), (x + 0.1, 0.4, 0.08)) for x in (-0.42, 0.1)]
    return make_mesh(*joined(ring, *posts), name="knobs")


def length(lines: LineSet) -> Floats:
    """Of what lies on each face."""
    total = np.zeros(10**5)
    np.add.at(total, lines.face, np.linalg.norm(lines.points[:, 1] - lines.points[:, 0], axis=1))
    return total


def stroke_length(strokes: list[Stroke]) -> float:
    return sum(float(np.linalg.norm(np.diff(stroke.points, axis=0), axis=1).sum()) for stroke in strokes)


def hidden(drawing: Drawing) -> list[Stroke]:
    return [stroke for stroke in drawing.strokes if stroke.hidden]


@pytest.fixture(scope="module")
def view() -> View:
    mesh = knobs()
    return View(Surface(mesh), Camera.orbit(mesh.vertices, 60.0, 10.0, size=(300, 300)))


@pytest.mark.parametrize("family", [family for family in LineFamily if family not in ABSENT])
def test_visible_and_hidden_are_all(view: View, family: LineFamily) -> None:
    lines = view.candidates(family)
    seen, rest = view.unhidden(lines), view.behind(lines)
    every = length(in_frame(lines, view.camera, view.surface.scene))
    np.testing.assert_allclose(length(seen) + length(rest), every, atol=1e-12)
    assert 0.0 < length(rest).sum() < every.sum()
    if family in FILTERED_FAMILIES or family is LineFamily.CREASES:
        np.testing.assert_array_equal(view.visible(family).points, seen.points)
        np.testing.assert_array_equal(view.hidden(family).points, rest.points)


def test_contours_of_a_smooth_shape_are_visible_or_hidden() -> None:
    mesh = make_mesh(*analytic.torus(64, 32))
    view = View(Surface(mesh), Camera.orbit(mesh.vertices, elevation=20.0))
    every = length(view.candidates(LineFamily.CONTOURS)).sum()
    seen, rest = (
        length(lines).sum() for lines in (view.visible(LineFamily.CONTOURS), view.hidden(LineFamily.CONTOURS))
    )
    assert rest > 0.05 * every
    assert seen + rest == pytest.approx(every, rel=1e-6)


def test_a_cube_hides_three_edges() -> None:
    drawing = draw(cube(), lines="creases,contours", hidden="dashed")
    corner, *ends = drawing.camera.project(
        np.array([HIDDEN_CORNER, (0.5, -0.5, -0.5), (-0.5, 0.5, -0.5), (-0.5, -0.5, 0.5)])
    )[:, :2]
    expected = sum(float(np.linalg.norm(end - corner)) for end in ends)
    assert stroke_length(hidden(drawing)) == pytest.approx(expected, abs=3.0 * 6.0)
    assert {stroke.group for stroke in hidden(drawing)} == {"hidden"}
    assert all(min(np.linalg.norm(stroke.points - corner, axis=1)) < 2.0 for stroke in hidden(drawing))
    visible = [stroke for stroke in drawing.strokes if not stroke.hidden]
    plain = draw(cube(), lines="creases,contours")
    assert [s.points.tolist() for s in visible] == [s.points.tolist() for s in plain.strokes]


def test_nothing_is_computed_unasked() -> None:
    assert not [stage for stage in draw(cube()).trace.seconds() if "hidden" in stage]
    assert "hidden_creases" in draw(cube(), hidden="layer").trace.seconds()


def test_as_dashes_or_as_a_layer(tmp_path: Path) -> None:
    with_dashes, layer = draw(cube(), hidden="dashed"), draw(cube(), hidden="layer")
    group = r'<g id="hidden"[^>]*>'
    found = re.findall(group, with_dashes.svg()), re.findall(group, layer.svg())
    assert 'stroke-dasharray="6 4"' in found[0][0]
    assert 'inkscape:groupmode="layer"' in found[1][0]
    assert "dasharray" not in found[1][0]
    for drawing, dashes in ((with_dashes, 1), (layer, 0)):
        drawing.save(tmp_path / "a.pdf")
        objects = objects_of((tmp_path / "a.pdf").read_bytes())
        assert any(b"/OCG /Name (hidden)" in body for body in objects.values())
        content = zlib.decompress(objects[4].split(b"stream\n", 1)[1].rsplit(b"\nendstream", 1)[0])
        assert content.count(b"[6 4] 0 d") == content.count(b"[] 0 d") == dashes
    # Pixels have no layers: dashes tell hidden lines apart in both.
    np.testing.assert_array_equal(with_dashes.ink(), layer.ink())
    more = with_dashes.ink().sum() - draw(cube()).ink().sum()
    assert more == pytest.approx(0.6 * 2.0 * stroke_length(hidden(layer)), rel=0.1)


def test_dashes_follow_the_stroke() -> None:
    points = np.array([[0.0, 0.0], [7.0, 0.0], [7.0, 10.0]])
    stroke = Stroke("creases", points, np.ones(3), np.array([1.0, 2.0, 3.0]), hidden=True)
    first, second = dashed([stroke], 6.0, 4.0)
    np.testing.assert_allclose(first.points, [[0, 0], [6, 0]])
    np.testing.assert_allclose(second.points, [[7, 3], [7, 9]])
    assert second.depth is not None
    np.testing.assert_allclose(second.depth, [2.3, 2.9])
    assert stroke_length(dashed([stroke], 5.0, 0.5)) == pytest.approx(17.0 - 3 * 0.5)


def test_another_word_is_refused() -> None:
    with pytest.raises(ArgumentError, match="hidden: found 'dotted', expected one of none, dashed, layer"):
        draw(cube(), hidden="dotted")
