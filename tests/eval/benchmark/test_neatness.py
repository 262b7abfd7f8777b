"""Measures of neatness on strokes made by hand, whose value one can work out."""

import math
from dataclasses import replace

import numpy as np
import pytest

from eval.benchmark.each_view import mean_rows
from eval.benchmark.neatness import (
    Neatness,
    crumb_share,
    dash_gaps,
    doubled_share,
    jaggedness,
    measure_neatness,
    neatness_rows,
    open_ends,
    seen,
)
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.surface import Surface
from ncmodel.types import LineFamily, Mask, Stroke
from tests.helpers.dirty import box
from tests.helpers.strokes import stroke


def circle(centre: float, radius: float, start: float = 0.0, end: float = 360.0, family: str = "contours") -> Stroke:
    angle = np.radians(np.linspace(start, end, 181))
    points = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Stroke(family, points, np.ones(len(points)))


def disc(size: int, radius: float) -> Mask:
    row, column = np.mgrid[:size, :size] + 0.5 - size / 2
    return np.asarray(np.hypot(row, column) < radius)


def test_a_zigzag_is_jagged_by_all_its_turns() -> None:
    """Ten teeth of 4 pixels at 45 degrees: 20 strokes of sqrt(8), 19 turns by 90, of which 18 are taken back."""
    teeth = stroke(*((2.0 * n, 2.0 * (n % 2)) for n in range(21)))
    assert jaggedness([teeth]) == pytest.approx(100 * 18 * 90 / (20 * math.sqrt(8)), rel=1e-6)


@pytest.mark.parametrize(
    "line",
    [
        circle(100.0, 50.0),
        stroke((0, 0), (50, 0), (50, 50), (0, 50), (0, 5)),  # corners are turned once
        stroke(*((float(n), 0.4 * (n % 2)) for n in range(60))),  # too little to be seen
        stroke((0, 0), (40, 40), (80, 0), (120, 40)),  # waves longer than any tooth
    ],
)
def test_curves_corners_and_waves_are_not_jagged(line: Stroke) -> None:
    assert jaggedness([line]) == 0.0


def test_a_jog_counts_both_its_turns() -> None:
    jog = stroke((0, 0), (50, 0), (53, 3), (100, 3))
    assert jaggedness([jog]) == pytest.approx(100 * 90 / (97 + math.sqrt(18)))
    assert jaggedness([]) == 0.0


@pytest.mark.parametrize(("gap", "gaps"), [(0.5, []), (3.0, [3.0]), (9.0, [9.0]), (16.0, [])])
def test_dashes_are_gaps_between_ends_that_continue_each_other(gap: float, gaps: list[float]) -> None:
    one, other = stroke((0, 0), (30, 0)), stroke((30 + gap, 0), (60 + gap, 0), family="suggestive")
    assert dash_gaps([one, other]) == pytest.approx(gaps)
    aside = stroke((30 + gap, 0), (30 + gap, 30))
    assert dash_gaps([one, aside]) == []


def test_a_chain_of_dashes_has_a_gap_between_each_two() -> None:
    chain = [stroke((12.0 * n, 0), (12.0 * n + 7, 0)) for n in range(5)]
    assert dash_gaps(chain) == pytest.approx([5.0] * 4)


def test_a_gap_with_a_line_in_it_is_none() -> None:
    """What is interrupted goes on behind something, or along another line."""
    one, other = stroke((0, 0), (30, 0)), stroke((38, 0), (70, 0))
    assert dash_gaps([one, other]) == [8.0]
    assert dash_gaps([one, other, stroke((34, -20), (34, 20))]) == []
    assert dash_gaps([one, other, stroke((0, 0.5), (70, 0.5), family="creases")]) == []


def test_a_line_that_fades_ends_where_it_is_hardly_seen() -> None:
    fading = Stroke("suggestive", np.array([[0.0, 0.0], [40.0, 0.0], [80.0, 0.0]]), np.array([1.0, 0.0, 0.5]))
    first, second = seen([fading])
    np.testing.assert_allclose(first.points, [[0, 0], [30, 0]])
    np.testing.assert_allclose(second.points, [[60, 0], [80, 0]])
    assert seen([stroke((0, 0), (9, 0), alpha=0.2)]) == []


def test_lines_that_run_along_another_family_are_doubles() -> None:
    """Of 300 pixels, the 100 of the crease run along the contour; what crosses or lies farther doesn't."""
    contour, crease = stroke((0, 0), (200, 0)), stroke((50, 2), (150, 2), family="creases")
    assert doubled_share([crease, contour]) == pytest.approx(1 / 3, abs=0.005)
    assert doubled_share([contour, stroke((50, 2), (150, 2))]) == 0.0
    assert doubled_share([contour, stroke((50, 4), (150, 4), family="creases")]) == 0.0
    assert doubled_share([contour, stroke((100, -50), (100, 50), family="creases")]) == 0.0
    assert doubled_share([contour, stroke((200, 0), (300, 0), family="creases")]) == 0.0
    assert doubled_share([]) == 0.0


def test_crumbs_are_the_ink_of_short_strokes() -> None:
    """A stroke of 90 in full ink, one of 20 in half, beside 10 pixels of crumbs in a picture of 768."""
    long, faint = stroke((0, 0), (90, 0)), stroke((0, 9), (20, 9), alpha=0.5)
    crumbs = [stroke((0, y), (5, y)) for y in (20, 30)]
    assert crumb_share([long, faint, *crumbs], 768) == pytest.approx(10 / 110)
    assert crumb_share([long, faint, *crumbs], 250) == 0.0
    assert crumb_share([], 768) == 0.0


def test_an_outline_is_open_where_it_stops_with_nothing_to_meet() -> None:
    hit = disc(200, 60.0)
    assert open_ends([circle(100.0, 60.0)], hit) == 0
    assert open_ends([circle(100.0, 60.0, 0.0, 340.0)], hit) == 2
    assert open_ends([circle(100.0, 60.0, 0.0, 340.0, family="apparent")], hit) == 0
    other = circle(100.0, 60.0, 340.0, 360.0, family="boundaries")
    assert open_ends([circle(100.0, 60.0, 0.0, 340.0), other], hit) == 0
    inside = stroke((70, 100), (130, 100))
    assert open_ends([circle(100.0, 60.0), inside], hit) == 0
    to_the_outline = stroke((100, 100), (159.5, 100), family="creases")
    assert open_ends([circle(100.0, 60.0), to_the_outline], hit) == 0
    assert open_ends([to_the_outline], hit) == 1


def test_a_box_is_neat() -> None:
    surface = Surface(make_mesh(*box(), name="box"))
    told: list[str] = []
    (found,) = measure_neatness([surface], told.append, [(30.0, 20.0)], 256)
    assert replace(found, crumbs=0.0) == Neatness("box", 30.0, 20.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert found.crumbs < 0.002
    assert told == ["box"]


def test_every_measure_sees_lines_that_are_spoilt(monkeypatch: pytest.MonkeyPatch) -> None:
    """A box whose edges are dashed, drawn twice, and jagged."""
    from eval.benchmark import neatness
    from ncmodel.drawing.draw import draw
    from ncmodel.drawing.drawing import Drawing

    def spoilt(surface: Surface, camera: object) -> Drawing:
        drawing = draw(surface, camera)  # type: ignore[arg-type]
        pieces = []
        for edge in drawing.strokes:
            start, end = edge.points[0], edge.points[-1]
            aside = np.array([start[1] - end[1], end[0] - start[0]]) / np.linalg.norm(end - start)
            for n in range(0, 10, 2):
                at = np.linspace(n / 10, (n + 1) / 10, 5)[:, None]
                line = start + at * (end - start) + aside * np.array([0.0, 2.0, -2.0, 2.0, 0.0])[:, None]
                pieces += [Stroke("contours", line, np.ones(5)), Stroke("creases", line + 2.5 * aside, np.ones(5))]
        return Drawing(drawing.camera, tuple(pieces))

    monkeypatch.setattr(neatness, "draw", spoilt)
    (found,) = measure_neatness([Surface(make_mesh(*box()))], lambda _: None, [(30.0, 20.0)], 256)
    assert found.jaggedness > 100.0
    assert found.dashes >= 5
    assert found.dash_length > 5.0 * found.dashes
    assert found.doubles > 0.1
    assert found.open_outlines > 10
    assert found.crumbs == 0.0, "the pieces are longer than 2 % of this small picture"


def test_rows_average_views_first() -> None:
    found = [
        Neatness("a", 0.0, 0.0, 10.0, 2.0, 8.0, 0.5, 0.1, 4.0),
        Neatness("a", 1.0, 0.0, 20.0, 0.0, 0.0, 0.0, 0.1, 0.0),
        Neatness("b", 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ]
    rows = neatness_rows(mean_rows(found))
    assert rows[1] == ["a", "15.0", "1.0", "4.0", "25.00", "10.00", "2.0"]
    assert rows[-1] == ["mean", "10.0", "0.5", "2.0", "12.50", "5.00", "1.0"]
    assert len(rows[0]) == len(rows[1])


def test_all_families_have_a_rank() -> None:
    """A line of a family that comes later is the double, whichever is longer."""
    for earlier, later in zip(list(LineFamily)[:-1], list(LineFamily)[1:], strict=True):
        pair = [stroke((0, 0), (100, 0), family=earlier), stroke((0, 2), (60, 2), family=later)]
        assert doubled_share(pair) == pytest.approx(60 / 160, abs=0.01)
    image = [stroke((0, 0), (100, 0), family="apparent"), stroke((0, 2), (60, 2), family="image")]
    assert doubled_share(image) == pytest.approx(60 / 160, abs=0.01)
