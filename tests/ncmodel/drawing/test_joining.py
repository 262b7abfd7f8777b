"""Strokes that continue each other: which gaps are bridged, and which aren't."""

from collections.abc import Sequence

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.joining import join, meet
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Mesh, Stroke
from tests.helpers.dirty import Geometry, box, joined

CAMERA = Camera((0.0, 0.0, 3.0), focal_pixels=800.0)


def view(*parts: Geometry) -> View:
    return View(Surface(Mesh(*joined(*parts))), CAMERA)


def dash(*points: tuple[float, float, float], family: str = "suggestive", alpha: float = 1.0) -> Stroke:
    """A stroke through points in space."""
    seen = CAMERA.project(np.array(points))
    return Stroke(family, seen[:, :2], np.full(len(points), alpha), seen[:, 2])


def length(strokes: Sequence[Stroke]) -> float:
    return float(sum(np.linalg.norm(np.diff(stroke.points, axis=0), axis=1).sum() for stroke in strokes))


def front(z: float = 0.5) -> Geometry:
    """A box from -0.5 to 0.5 whose front lies at z."""
    return box((-0.5, -0.5, -0.5), (0.5, 0.5, z))


def dashes(z: float, family: str = "suggestive") -> list[Stroke]:
    """A line of dashes 30 pixels long with gaps of 8, from left to right."""
    pixel = (3.0 - z) / CAMERA.focal_pixels
    starts = -0.3 + 38.0 * pixel * np.arange(5)
    return [dash((x, 0.1, z), (x + 30.0 * pixel, 0.1, z), family=family) for x in starts.tolist()]


@pytest.mark.parametrize("family", ["suggestive", "contours", "creases"])
@pytest.mark.parametrize("turned", [False, True])
def test_dashes_on_a_smooth_surface_become_one_stroke(family: str, turned: bool) -> None:
    parts = dashes(0.5, family)
    if turned:
        parts[1::2] = [Stroke(p.family, p.points[::-1], p.alpha, p.depth) for p in parts[1::2]]
    (whole,) = join(parts, 12.0, view(front()))
    assert whole.family == family
    assert length([whole]) == pytest.approx(5 * 30 + 4 * 8)
    assert len(join(parts, 7.0, view(front()))) == 5  # gaps that are too long


def test_no_line_is_drawn_over_something_nearer() -> None:
    parts = dashes(0.5)
    gap = (parts[0].points[1] + parts[1].points[0]) / 2
    x, pixel = (gap[0] - CAMERA.width / 2) * 2.2 / CAMERA.focal_pixels, 2.2 / CAMERA.focal_pixels
    wire = box((x - 2.5 * pixel, -0.4, 0.75), (x + 2.5 * pixel, 0.4, 0.8))
    assert len(join(parts, 12.0, view(front(), wire))) == 2


def test_a_line_of_the_surface_is_not_continued_where_there_is_none() -> None:
    parts = dashes(0.5)
    pixel = 2.5 / CAMERA.focal_pixels
    edge = -0.3 + 31.0 * pixel
    halves = (box((-0.5, -0.5, -0.5), (edge, 0.5, 0.5)), box((edge + 6.0 * pixel, -0.5, -0.5), (0.5, 0.5, 0.5)))
    assert len(join(parts, 12.0, view(*halves))) == 2
    outlines = [Stroke("contours", part.points, part.alpha, part.depth) for part in parts]
    assert len(join(outlines, 12.0, view(*halves))) == 1


def test_ends_at_other_depths_are_of_other_lines() -> None:
    near, far = dashes(0.5)[0], dashes(-0.5)[0]
    shift = near.points[1] + (8.0, 0.0) - far.points[0]
    moved_far = Stroke(far.family, far.points + shift, far.alpha, far.depth)
    assert len(join([near, moved_far], 12.0, view(front()))) == 2


@pytest.mark.parametrize("angle", [0.0, 20.0, 60.0, 120.0, 180.0])
def test_only_ends_that_go_on_to_each_other_are_joined(angle: float) -> None:
    first = dashes(0.5)[0]
    turn = np.radians(angle)
    start = first.points[1] + 5.0 * np.array([np.cos(turn / 2), np.sin(turn / 2)])
    away = Stroke(
        "suggestive", start + 30.0 * np.array([(0, 0), (np.cos(turn), np.sin(turn))]), first.alpha, first.depth
    )
    assert len(join([first, away], 12.0, view(front()))) == (1 if angle < 25.0 else 2)


def test_dots_bridge_nothing_longer_than_themselves() -> None:
    first, last = dashes(0.5)[:2]
    middle = (first.points[1] + last.points[0]) / 2
    dot = Stroke("suggestive", middle + np.array([(-1.0, 0.0), (1.0, 0.0)]), first.alpha, first.depth)
    assert len(join([first, dot], 12.0, view(front()))) == 2


def circle(begin: float, end: float, family: str = "contours") -> Stroke:
    angle = np.linspace(begin, end, 60)
    return dash(*np.stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), np.full(60, 0.5)], axis=1).tolist(), family=family)


def test_an_outline_with_a_gap_is_closed() -> None:
    (whole,) = join([circle(0.1, 2 * np.pi)], 12.0, view(front()))
    np.testing.assert_array_equal(whole.points[0], whole.points[-1])
    assert whole.depth is not None
    assert len(whole.depth) == len(whole.alpha) == len(whole.points) == 61


def test_families_that_hand_a_line_on_to_each_other_meet() -> None:
    parts = [circle(0.0, np.pi), circle(np.pi + 0.08, 2 * np.pi - 0.08, "suggestive")]
    found = join(parts, 12.0, view(front()))
    assert [stroke.family for stroke in found] == ["contours", "suggestive"]
    for end, other in ((0, -1), (-1, 0)):
        np.testing.assert_array_equal(found[0].points[end], found[1].points[other])


def test_smooth_shapes_in_any_order_give_the_same_lines() -> None:
    parts: list[Stroke] = [*dashes(0.5), *dashes(0.5, "contours")]
    parts = [Stroke(p.family, p.points + (0.0, 40.0 * (k > 4)), p.alpha, p.depth) for k, p in enumerate(parts)]
    sphere = view(front())
    some, others = join(parts, 12.0, sphere), join(parts[::-1], 12.0, sphere)
    assert len(some) == len(others) == 2
    assert length(some) == pytest.approx(length(others))


def edge(first: tuple[float, float], last: tuple[float, float], family: str = "creases", z: float = 0.5) -> Stroke:
    """A stroke between two points given in pixels from the centre of a front at z."""
    pixel = (3.0 - z) / CAMERA.focal_pixels
    return dash(*((x * pixel, y * pixel, z) for x, y in (first, last)), family=family)


def last_of(stroke: Stroke) -> list[float]:
    """Where a stroke ends, in pixels from the centre."""
    return [stroke.points[-1, 0] - CAMERA.width / 2, CAMERA.height / 2 - stroke.points[-1, 1]]


@pytest.mark.parametrize("family", ["creases", "intersections"])
@pytest.mark.parametrize(("gap", "reached"), [(8.0, True), (13.0, False)])
def test_an_edge_that_ends_just_before_a_line_reaches_it(family: str, gap: float, reached: bool) -> None:
    parts = [edge((-50.0, 0.0), (-gap, 0.0), family), edge((0.0, -40.0), (0.0, 40.0))]
    found = meet(parts, 12.0, view(front()))
    assert last_of(found[0]) == pytest.approx([0.0, 0.0] if reached else [-gap, 0.0])
    assert found[1] is parts[1]


@pytest.mark.parametrize("other", ["suggestive", "creases"])
def test_lines_of_curvature_neither_reach_others_nor_are_reached(other: str) -> None:
    family = "suggestive" if other == "creases" else "creases"
    parts = [edge((-50.0, 0.0), (-8.0, 0.0), family), edge((0.0, -40.0), (0.0, 40.0), other)]
    assert meet(parts, 12.0, view(front())) == tuple(parts)


def test_two_edges_that_end_before_their_corner_meet_in_it() -> None:
    parts = [edge((-50.0, 0.0), (-6.0, 0.0)), edge((0.0, 50.0), (0.0, 6.0))]
    one, other = meet(parts, 12.0, view(front()))
    assert last_of(one) == pytest.approx([-1.5, 1.5])  # halfway on an arc
    np.testing.assert_allclose(one.points[-1], other.points[-1])


def test_a_line_reaches_none_that_lies_elsewhere_in_space() -> None:
    parts = [edge((-50.0, 0.0), (-8.0, 0.0)), edge((0.0, -40.0), (0.0, 40.0), z=0.2)]
    assert meet(parts, 12.0, view(front())) == tuple(parts)


@pytest.mark.parametrize(("off", "reached"), [(0.0, True), (20.0, False)])
def test_contours_go_on_along_the_outline_only(off: float, reached: bool) -> None:
    """Beside the front of a box is background; inside, a contour ends in a cusp."""
    side = 0.5 * CAMERA.focal_pixels / 2.5 - off
    parts = [edge((side, -50.0), (side, -8.0), "contours"), edge((side - 30.0, 0.0), (side + 30.0, 0.0))]
    found = meet(parts, 12.0, view(front()))
    assert last_of(found[0]) == pytest.approx([side, 0.0 if reached else -8.0])


def test_a_line_that_ends_on_itself_is_not_led_on() -> None:
    loop = [(-40.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0), (0.0, 0.0)]
    pixel = 2.5 / CAMERA.focal_pixels
    sigma = dash(*((x * pixel, y * pixel, 0.5) for x, y in loop), family="creases")
    parts = [sigma, edge((-20.0, -8.0), (20.0, -8.0))]
    assert meet(parts, 12.0, view(front())) == tuple(parts)


def test_nothing_is_no_trouble() -> None:
    assert join([], 12.0, view(front())) == ()
    assert meet([], 12.0, view(front())) == ()
