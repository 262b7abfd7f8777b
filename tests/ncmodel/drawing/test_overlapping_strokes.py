"""Strokes along other strokes: what goes, and what stays."""

from collections.abc import Sequence

import numpy as np
import pytest

from eval.measures.metrics import compare_lines
from ncmodel.chamfer import Lines
from ncmodel.drawing.draw import draw
from ncmodel.drawing.overlapping_strokes import drop_accompanying, drop_overlapping
from ncmodel.mesh.load import make_mesh
from ncmodel.types import LineFamily, Mask, Stroke
from tests.helpers import analytic
from tests.helpers.strokes import inside


def stroke(*points: tuple[float, float], alpha: float = 1.0, family: str = "creases") -> Stroke:
    return Stroke(family, np.array(points, dtype=np.float64), np.full(len(points), alpha))


def length(strokes: tuple[Stroke, ...]) -> float:
    return float(sum(np.linalg.norm(np.diff(s.points, axis=0), axis=1).sum() for s in strokes))


LONG = stroke((0, 0), (60.5, 3), (100, 40))


@pytest.mark.parametrize("aside", [0.0, 0.2, -0.2])
@pytest.mark.parametrize("turn", [1, -1])
def test_a_stroke_along_a_longer_one_goes(aside: float, turn: int) -> None:
    twin = stroke(*[(x, y + aside) for x, y in ((5.3, 5.3 * 3 / 60.5), (60.5, 3))][::turn])
    assert drop_overlapping([twin, LONG], 0.25) == (LONG,)
    assert drop_overlapping([LONG, stroke((58, 2.88), (60.5, 3))], 0.25) == (LONG,)


@pytest.mark.parametrize(
    "other",
    [
        stroke((0, 1), (60.5, 4)),  # beside it
        stroke((30, -20), (30, 20)),  # across
        stroke((20, -4), (60, 6)),  # across at a small angle
        stroke((100, 40), (120, 60)),  # on from its end
    ],
)
def test_others_stay(other: Stroke) -> None:
    assert drop_overlapping([other, LONG], 0.25) == (other, LONG)


def test_stronger_ink_stays() -> None:
    faint, strong = stroke((0, 0), (100, 0), alpha=0.3), stroke((10, 0), (40, 0), alpha=0.8)
    assert drop_overlapping([faint, strong], 0.25) == (faint, strong)
    assert drop_overlapping([stroke((0, 0), (100, 0), alpha=0.8), stroke((10, 0), (40, 0), alpha=0.3)], 0.25)[1:] == ()


def test_what_leaves_a_longer_stroke_is_kept_from_there() -> None:
    fork = Stroke("creases", np.array([(10.0, 0.1), (50.0, 0.1), (50.0, 30.0)]), np.array([0.2, 0.6, 0.9]))
    kept = drop_overlapping([stroke((0, 0), (100, 0)), fork], 0.25)
    assert len(kept) == 2
    np.testing.assert_allclose(kept[1].points[-2:], fork.points[-2:])
    assert 30.0 < length(kept[1:]) < 33.0
    assert kept[1].alpha[-1] == 0.9
    assert 0.55 < kept[1].alpha[0] <= 0.6


def test_a_shape_in_a_tight_shell_is_drawn_once() -> None:
    vertices, faces = analytic.icosphere(4)
    once = make_mesh(vertices, faces)
    both = np.concatenate([vertices, vertices * 0.9997])
    twice = make_mesh(both, np.concatenate([faces, faces + len(vertices)]))
    families = [LineFamily.CONTOURS]
    single, double = (draw(mesh, lines=families) for mesh in (once, twice))
    assert length(double.strokes) == pytest.approx(length(single.strokes), rel=0.02)
    inks = [Lines.of(drawing.ink() > 0.5) for drawing in (single, double)]
    assert compare_lines(inks[0], inks[1], 1.0).f1 > 0.999


CLAIMS = ["contours", "boundaries", "creases", "intersections", "ridges", "suggestive"]


def bent(family: str, aside: float, alpha: float = 1.0) -> Stroke:
    """Along a quarter of a circle of radius 100."""
    angle = np.linspace(0.0, np.pi / 2, 40)
    points = (100.0 + aside) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Stroke(family, points, np.full(len(points), alpha))


@pytest.mark.parametrize("strong", range(len(CLAIMS)))
@pytest.mark.parametrize("aside", [-2.5, 0.5, 2.5])
def test_of_lines_of_two_families_side_by_side_the_stronger_claim_stays(strong: int, aside: float) -> None:
    for weak in CLAIMS[strong + 1 :]:
        lines = [bent(weak, aside), bent(CLAIMS[strong], 0.0)]
        assert drop_accompanying(lines, 3.0, inside) == (lines[1],)


def test_two_edges_of_something_thin_are_one_line_and_both_sides_of_a_limb_are_two() -> None:
    edges = [bent("creases", 0.0), bent("creases", 2.0)]
    assert drop_accompanying(edges, 3.0, inside) == (edges[1],)  # the longer one
    outlines = [bent("contours", 0.0), bent("contours", 2.0)]
    assert drop_accompanying(outlines, 3.0, inside) == tuple(outlines)


@pytest.mark.parametrize("other", [bent("suggestive", 3.5), stroke((60, 60), (90, 90), family="suggestive")])
def test_lines_farther_off_and_across_stay(other: Stroke) -> None:
    lines = (bent("contours", 0.0), other)
    assert drop_accompanying(lines, 3.0, inside) == lines


def test_a_strong_line_does_not_give_way_to_a_faint_one() -> None:
    lines = (bent("ridges", 0.0, alpha=0.2), bent("apparent", 1.0, alpha=0.9))
    assert drop_accompanying(lines, 3.0, inside) == lines
    assert drop_accompanying((bent("ridges", 0.0, alpha=0.8), lines[1]), 3.0, inside)[1:] == ()


def test_a_line_that_leaves_another_one_starts_on_it() -> None:
    trunk = stroke((0, 0), (100, 0), family="contours")
    branch = stroke((10, 1), (50, 1), (90, 25), family="suggestive")
    kept, rest = drop_accompanying([trunk, branch], 3.0, inside)
    assert kept is trunk
    assert rest.family == "suggestive"
    assert rest.points[0, 1] == 0.0  # on the trunk
    assert 45 < rest.points[0, 0] < 60
    np.testing.assert_allclose(rest.points[-1], (90, 25))
    way = np.diff(rest.points, axis=0)
    turn = np.degrees(np.arctan2(way[:, 1], way[:, 0]))
    assert turn.max() < 40.0  # and leaves it without a step


@pytest.mark.parametrize("turn", [1, -1])
def test_what_ended_on_a_line_that_went_ends_on_the_one_that_stays(turn: int) -> None:
    edge, twin = stroke((0, 0), (100, 0), family="contours"), stroke((10, 2.5), (90, 2.5))
    post, other = stroke(*[(50, 2.5), (50, 60)][::turn]), stroke((70, 30), (70, 60))
    kept = drop_accompanying([edge, twin, post, other], 3.0, inside)
    assert kept[0] is edge
    assert other in kept
    assert len(kept) == 3
    reaching = kept[1].points[::turn]
    assert reaching[0, 1] == 0.0
    assert 49 < reaching[0, 0] < 52
    np.testing.assert_array_equal(reaching[-1], (50, 60))
    np.testing.assert_allclose(reaching[:, 0], 50.0, atol=0.75)  # half a sample's spacing


@pytest.mark.parametrize("gap", [8.0, 14.0])
def test_what_closes_a_gap_in_stronger_lines_stays_and_a_bulge_beside_one_goes(gap: float) -> None:
    left = stroke((0, 0), (50, 0), family="contours")
    right = stroke((50 + gap, 0), (100, 0), family="contours")
    *_, closing = drop_accompanying([left, right, stroke((10, 1), (90, 1))], 3.0, inside)
    assert closing.points[:, 0].min() < 51 < 49 + gap < closing.points[:, 0].max()
    assert length((closing,)) < gap + 10.0
    whole = stroke((0, 0), (100, 0), family="contours")
    bulge = stroke((10, 1), (45, 1), (50, 4), (55, 1), (90, 1))
    assert drop_accompanying([whole, bulge], 3.0, inside) == (whole,)


def test_what_is_taken_away_takes_nothing_away() -> None:
    trunk = stroke((0, 0), (100, 0), family="contours")
    leaving = stroke((10, 1), (92, 1), (97, 6), family="boundaries")  # its last bit goes
    beside = stroke((94, 4), (101, 11), family="creases")
    kept = drop_accompanying([trunk, leaving, beside], 3.0, inside)
    assert kept == (trunk, beside)


def test_the_outline_goes_on_to_its_corners() -> None:
    trunk, edge = stroke((0, 0), (100, 0), family="contours"), stroke((10, 1), (92, 1), (97, 6))
    assert drop_accompanying([trunk, edge], 3.0, inside) == (trunk,)
    rest = drop_accompanying([trunk, edge], 3.0, lambda some: np.ones(len(some), dtype=np.bool_))[1]
    assert rest.points[0, 1] == 0.0  # from the trunk
    np.testing.assert_allclose(rest.points[-1], (97, 6))


def test_a_line_goes_over_to_its_neighbour_without_a_kink() -> None:
    edge, other = stroke((0, 0), (200, 0)), stroke((100, 2.5), (250, 2.5))
    kept = drop_accompanying([edge, other], 3.0, inside)
    way = np.diff(kept[1].points, axis=0)
    assert kept[0] is edge
    assert kept[1].points[0, 1] == 0.0
    np.testing.assert_array_equal(kept[1].points[-1], (250, 2.5))
    assert np.abs(way[:, 1]).max() > 0.0
    assert np.degrees(np.arctan2(way[:, 1], way[:, 0])).max() < 8.0


def test_a_cap_between_two_lines_stays_and_a_tick_beside_one_goes() -> None:
    edges = (stroke((0, 0), (100, 0)), stroke((0, 5), (99, 5)))
    cap, tick = stroke((100, 0), (99, 5)), stroke((50, 0), (52, -2), (54, 0))
    assert drop_accompanying([*edges, cap, tick], 3.0, inside) == (*edges, cap)


def test_of_two_edges_the_one_on_the_outline_stays() -> None:
    long, short = stroke((0, 2), (100, 2)), stroke((0, 0), (80, 0))
    kept = drop_accompanying([long, short], 3.0, lambda some: np.array([each is short for each in some]))
    assert kept[-1] is short
    assert length(kept) < 110.0


@pytest.mark.parametrize("outline", [True, False])
def test_what_is_left_of_a_line_is_no_crumb_where_it_is_outline(outline: bool) -> None:
    rim, inner = stroke((10, 0), (100, 0)), stroke((0, 0.5), (100, 0.5), (160, 60))

    def beyond(some: Sequence[Stroke]) -> Mask:
        return np.array([each is rim or (outline and each.points[:, 0].max() < 20) for each in some])

    kept = drop_accompanying([rim, inner], 3.0, beyond)
    assert (min(float(each.points[:, 0].min()) for each in kept) < 0.1) == outline


def test_what_is_left_of_a_line_stays_in_its_place() -> None:
    trunk = stroke((0, 0), (50, 0), family="contours")
    longer = stroke((10, 2.5), (250, 2.5))  # no point of its own beside the trunk's end
    twin = stroke((120, 5), (200, 5))  # along the longer one
    kept = drop_accompanying([trunk, longer, twin], 3.0, inside)
    assert len(kept) == 2
    left = kept[1].points
    np.testing.assert_allclose(np.interp([75.0, 120.0, 200.0], left[:, 0], left[:, 1]), 2.5, atol=1e-9)


def test_nothing_is_no_trouble() -> None:
    assert drop_overlapping([], 0.25) == ()
    assert drop_overlapping([LONG], 0.25) == (LONG,)
    assert drop_accompanying([], 3.0, inside) == ()
    assert drop_accompanying([LONG], 3.0, inside) == (LONG,)
