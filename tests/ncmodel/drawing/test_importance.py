"""The outline alone, all lines, and what is in between: on strokes made by hand and on shapes."""

import itertools
from collections.abc import Sequence

import numpy as np
import pytest

from ncmodel.drawing.draw import draw
from ncmodel.drawing.importance import most_important, without_short
from ncmodel.errors import ArgumentError
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Mask, Stroke
from tests.helpers import analytic
from tests.helpers.dirty import box, joined
from tests.helpers.strokes import stroke

SIDE = 400.0


def beyond(pixels: Floats) -> Mask:
    """The shape is a square from 100 to 300."""
    return np.asarray(np.abs(pixels - SIDE / 2).max(axis=1) > 100.0)


OUTLINE = stroke((100, 100), (300, 100), (300, 300), (100, 300), (100, 100))
LONG = stroke((120, 150), (220, 150), family="creases")
SHORT = stroke((120, 170), (150, 170), family="creases")
FAINT = stroke((120, 190), (220, 190), family="suggestive", alpha=0.25)
DRAWN = (OUTLINE, SHORT, FAINT, LONG)


def same(found: Sequence[Stroke], expected: Sequence[Stroke]) -> bool:
    return [id(each) for each in found] == [id(each) for each in expected]


@pytest.mark.parametrize(
    ("share", "expected"),
    [
        (0.0, [OUTLINE]),
        (0.2, [OUTLINE]),  # of 230 pixels 46: nearer to none than to the 100 of the longest
        (0.25, [OUTLINE, LONG]),
        (0.5, [OUTLINE, SHORT, LONG]),
        (0.7, [OUTLINE, SHORT, LONG]),
        (0.8, [OUTLINE, SHORT, FAINT, LONG]),
        (1.0, DRAWN),
    ],
)
def test_the_strongest_and_longest_come_first(share: float, expected: Sequence[Stroke]) -> None:
    """100 pixels in full ink, 30 in full ink, 100 in a quarter."""
    assert same(most_important(DRAWN, share, beyond, 1.0), expected)


@pytest.mark.parametrize("scale", [0.25, 1.0, 8.0])
def test_the_order_is_the_same_at_any_size(scale: float) -> None:
    larger = [Stroke(each.family, scale * each.points, each.alpha) for each in DRAWN]
    for share in np.linspace(0.0, 1.0, 21).tolist():
        found = most_important(larger, share, lambda pixels: beyond(pixels / scale), scale)
        expected = most_important(DRAWN, share, beyond, 1.0)
        assert [larger.index(each) for each in found] == [DRAWN.index(each) for each in expected]


def test_a_stroke_is_cut_where_it_leaves_the_outline() -> None:
    leaving = Stroke("contours", np.array([[100.0, 100.0], [300.0, 100.0], [200.0, 200.0]]), np.array([1.0, 0.5, 1.0]))
    (outline,) = most_important([leaving], 0.0, beyond, 1.0)
    np.testing.assert_array_equal(outline.points[:2], leaving.points[:2])
    assert np.linalg.norm(outline.points[-1] - [300.0, 100.0]) < 6.0
    first, second = most_important([leaving], 0.999, beyond, 1.0)
    np.testing.assert_array_equal(first.points, outline.points)
    np.testing.assert_array_equal(first.points[-1], second.points[0])
    assert first.alpha[-1] == second.alpha[0] == pytest.approx(0.5, abs=0.02)
    np.testing.assert_array_equal(second.points[-1], [200.0, 200.0])


def test_lines_that_end_at_the_outline_are_none_of_it() -> None:
    for family in ("creases", "contours", "apparent"):
        ending = stroke((200, 200), (300, 200), family=family)
        assert same(most_important([OUTLINE, ending], 0.0, beyond, 1.0), [OUTLINE])
        assert same(most_important([OUTLINE, ending], 0.99, beyond, 1.0), [OUTLINE, ending])


@pytest.mark.parametrize("family", ["apparent", "suggestive", "image"])
def test_what_repeats_the_outline_is_left_out_beside_it(family: str) -> None:
    along = stroke((101, 120), (101, 280), family=family)
    assert same(most_important([OUTLINE, along], 0.9, beyond, 1.0), [OUTLINE])
    assert same(most_important([OUTLINE, along], 1.0, beyond, 1.0), [OUTLINE, along])
    assert same(most_important([along], 0.9, beyond, 1.0), [along]), "without an outline it repeats nothing"


def test_a_small_hole_is_no_outline() -> None:
    def holed(pixels: Floats) -> Mask:
        return np.asarray(beyond(pixels) | (np.linalg.norm(pixels - SIDE / 2, axis=1) < 2.0))

    angle = np.linspace(0.0, 2.0 * np.pi, 13)
    points = SIDE / 2 + 2.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for pieces in ([points], [points[:7], points[6:]]):
        hole = [Stroke("creases", piece, np.ones(len(piece))) for piece in pieces]
        assert same(most_important([OUTLINE, *hole], 0.0, holed, 1.0), [OUTLINE])
        assert same(most_important([OUTLINE, *hole], 0.99, holed, 1.0), [OUTLINE, *hole])


def test_an_outline_of_short_pieces_that_hang_on_a_long_one_stays() -> None:
    corners = [(100, 100), (300, 100), (300, 285), (300, 295), (300, 300), (290, 300)]
    pieces = [stroke(*ends, family="creases") for ends in itertools.pairwise(corners)]
    assert same(most_important(pieces, 0.0, beyond, 1.0), pieces)


def test_short_strokes_are_left_out_except_the_outline_s() -> None:
    piece, along = stroke((120, 100), (140, 100)), stroke((120, 101), (140, 101), family="apparent")
    drawn = [piece, along, SHORT, LONG]
    assert same(without_short(drawn, 0.0, beyond, 1.0), drawn)
    assert same(without_short(drawn, 30.0, beyond, 1.0), [piece, SHORT, LONG])
    assert same(without_short(drawn, 30.5, beyond, 1.0), [piece, LONG])
    assert same(without_short(drawn, 20.0, beyond, 2.0), [piece, LONG])
    assert without_short([], 5.0, beyond, 1.0) == most_important([], 0.5, beyond, 1.0) == ()


@pytest.fixture(scope="module")
def tower() -> Surface:
    """A cube on a cube: edges inside the outline."""
    return Surface(make_mesh(*joined(box(), box((0.25, 1, 0.25), (0.75, 1.5, 0.75))), name="tower"))


def test_a_drawing_of_less_detail_has_its_outline_and_fewer_lines(tower: Surface) -> None:
    whole = draw(tower)
    lengths = []
    for detail in (0.0, 0.3, 0.6, 1.0):
        drawing = draw(tower, detail=detail)
        assert drawing.plan.detail == detail
        near = np.minimum(drawing.ink(), whole.ink())
        np.testing.assert_allclose(drawing.ink(), near, atol=0.3)
        lengths.append(drawing.ink().sum())
    assert lengths == sorted(lengths)
    assert lengths[0] < 0.8 * lengths[-1]
    hit = tower.scene.render(whole.camera).hit
    outline = np.concatenate([each.points for each in draw(tower, detail=0.0).strokes])
    column, row = np.floor(outline).astype(np.int64).T
    for r, c in zip(row, column, strict=True):
        assert not hit[r - 6 : r + 7, c - 6 : c + 7].all(), (r, c)


def test_larger_pictures_show_the_same_lines() -> None:
    torus = Surface(make_mesh(*analytic.torus(64, 32)))
    for detail in (0.0, 0.2, 0.6):
        drawings = [draw(torus, detail=detail, size=size, elevation=20) for size in (300, 1200)]
        totals = [
            sum(np.linalg.norm(np.diff(each.points, axis=0), axis=1).sum() for each in drawing.strokes)
            for drawing in drawings
        ]
        assert 4 * totals[0] == pytest.approx(totals[1], rel=0.02)


def test_without_the_options_nothing_is_changed_or_computed(tower: Surface) -> None:
    plain, asked = draw(tower), draw(tower, detail=1, min_length=0)
    assert plain.svg() == asked.svg()
    assert "importance" not in draw(Surface(tower.mesh)).trace.seconds()
    assert "importance" in draw(Surface(tower.mesh), min_length=3).trace.seconds()


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"detail": -0.1}, "detail"),
        ({"detail": 1.01}, "detail"),
        ({"detail": float("nan")}, "detail"),
        ({"detail": "half"}, "detail"),
        ({"min_length": -1.0}, "min_length"),
        ({"min_length": float("inf")}, "min_length"),
    ],
)
def test_values_out_of_range_are_refused(tower: Surface, options: dict[str, float], name: str) -> None:
    with pytest.raises(ArgumentError, match=f"^{name}: found .*, expected ") as error:
        draw(tower, **options)  # type: ignore[arg-type]
    assert "\n" not in str(error.value)
