"""Ridge detection on pictures whose lines are known."""

import itertools

import cv2
import numpy as np
import pytest

from ncmodel.export.rasterize import draw_segments
from ncmodel.model.letterbox import Square
from ncmodel.model.ridge_detection import IMAGE_FAMILY, RidgeOptions, _pruned, find_ridges, polylines
from ncmodel.types import Image
from tests.helpers.segments import length

SIDE = 96


def lines(*ends: tuple[float, float, float, float], strength: float = 1.0, blur: float = 1.0) -> Image:
    """A blurred picture of straight lines (u0, v0, u1, v1)."""
    points = np.array(ends, dtype=np.float64).reshape(-1, 2, 2)
    sharp = draw_segments(points, np.ones(points.shape[:2]), 1.5, (SIDE, SIDE))
    return np.asarray(strength * cv2.GaussianBlur(sharp, (0, 0), blur), dtype=np.float32)


def circle(radius: float) -> Image:
    angle = np.linspace(0, 2 * np.pi, 200)
    around = SIDE / 2 + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return lines(*(tuple(np.concatenate(pair).tolist()) for pair in itertools.pairwise(around)))


@pytest.mark.parametrize("angle", [0, 10, 30, 45, 60, 80, 90, 135, 170])
@pytest.mark.parametrize("offset", [0.0, 0.3, 0.5])
def test_a_straight_line_is_found_where_it_is(angle: float, offset: float) -> None:
    direction = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    normal = np.array([-direction[1], direction[0]])
    middle = SIDE / 2 + offset * normal
    ends = np.concatenate([middle - 30 * direction, middle + 30 * direction])
    found = find_ridges(lines(tuple(ends.tolist())))
    off, along = np.abs((found.points - middle) @ normal), np.abs((found.points - middle) @ direction)
    assert off[along < 28].max() < 0.3
    assert off.max() < 2.5  # spurs at the rounded ends
    assert 58 < length(found.points) < 72


def test_a_circle_is_one_closed_line() -> None:
    found = find_ridges(circle(30))
    distance = np.linalg.norm(found.points - SIDE / 2, axis=2)
    assert np.abs(distance - 30).max() < 0.3
    assert length(found.points) == pytest.approx(2 * np.pi * 30, rel=0.03)
    strokes = polylines(found, Square(SIDE, SIDE, SIDE))
    assert len(strokes) == 1
    np.testing.assert_array_equal(strokes[0].points[0], strokes[0].points[-1])


def test_ink_follows_the_probability() -> None:
    options = RidgeOptions(full=0.4)
    faint, strong = (find_ridges(lines((20, 48, 76, 48), strength=s), options) for s in (0.5, 1.0))
    middle = faint.alpha[np.abs(faint.points[:, 0, 0] - 48) < 10]
    peak = float(lines((20, 48, 76, 48), strength=0.5).max())
    assert np.median(middle) == pytest.approx(peak / 0.4, rel=0.1)
    assert strong.alpha.max() == 1.0
    assert strong.alpha.min() > 0


def test_faint_lines_and_specks_are_dropped() -> None:
    options = RidgeOptions(low=0.1, high=0.3, length=10)
    assert len(find_ridges(lines((20, 48, 76, 48), strength=0.3), options).points) == 0
    assert len(find_ridges(lines((20, 48, 24, 48)), options).points) == 0
    assert len(find_ridges(lines((20, 48, 76, 48)), options).points) > 0


def test_a_line_that_grows_faint_is_kept_where_it_hangs_together() -> None:
    ramp = np.linspace(0.3, 1.0, SIDE, dtype=np.float32)
    found = find_ridges(lines((10, 48, 86, 48)) * ramp, RidgeOptions(low=0.1, high=0.35))
    assert found.points[..., 0].min() < 20


def test_parallel_lines_stay_apart() -> None:
    found = find_ridges(lines((10, 40, 86, 40), (10, 48, 86, 48)))
    rows = found.points[..., 1]
    assert set(np.rint(rows).astype(int).ravel().tolist()) <= {39, 40, 41, 47, 48, 49}
    assert length(found.points) == pytest.approx(152, abs=8)


@pytest.mark.parametrize("value", [0.0, 0.5, 1.0])
def test_an_even_map_has_no_lines(value: float) -> None:
    found = find_ridges(np.full((20, 30), value, np.float32))
    assert found.points.shape == (0, 2, 2)
    assert found.alpha.shape == (0, 2)
    assert polylines(found, Square(20, 30, 30)) == ()


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (1, 9), (3, 2)])
def test_tiny_maps(shape: tuple[int, int]) -> None:
    found = find_ridges(np.random.default_rng(0).random(shape).astype(np.float32))
    assert np.isfinite(found.points).all()


def test_noise_gives_finite_lines_inside_the_map() -> None:
    found = find_ridges(np.random.default_rng(0).random((SIDE, SIDE)).astype(np.float32))
    assert np.isfinite(found.points).all()
    assert -1 <= found.points.min() <= found.points.max() <= SIDE + 1
    assert 0 < found.alpha.min() <= found.alpha.max() <= 1


def test_strokes_are_in_the_pictures_pixels() -> None:
    """A map of a picture twice as wide as high: the picture's rows lie in the middle half of the map."""
    square = Square(height=2 * SIDE, width=4 * SIDE, size=SIDE)
    strokes = polylines(find_ridges(lines((20, 48, 76, 48))), square)
    assert [stroke.family for stroke in strokes] == [IMAGE_FAMILY]
    np.testing.assert_allclose(strokes[0].points[:, 1], SIDE, atol=2.0)
    assert strokes[0].points[:, 0].min() == pytest.approx(4 * 20, abs=8)
    assert len(strokes[0].alpha) == len(strokes[0].points)


def test_wrong_input_is_refused() -> None:
    with pytest.raises(ValueError, match=r"\(1, 4, 4\)"):
        find_ridges(np.zeros((1, 4, 4), np.float32))
    with pytest.raises(ValueError, match="finite"):
        find_ridges(np.full((4, 4), np.nan, np.float32))
    with pytest.raises(ValueError, match="expected sigma > 0"):
        RidgeOptions(low=0.5, high=0.2)


def test_short_side_branches_go_and_ends_stay() -> None:
    thin = np.zeros((40, 60), dtype=np.bool_)
    thin[20, 5:55] = True
    plain = thin.copy()
    thin[17:20, 30] = True  # a spur
    np.testing.assert_array_equal(_pruned(thin, 4), plain)
    thin[10:17, 30] = True  # long enough to be a line
    np.testing.assert_array_equal(_pruned(thin, 4), thin)
    np.testing.assert_array_equal(_pruned(plain, 4), plain)


def test_a_forked_end_keeps_its_longer_tine() -> None:
    thin = np.zeros((40, 60), dtype=np.bool_)
    thin[20, 5:50] = True
    plain = thin.copy()
    for step in range(1, 4):
        plain[20 + step, 49 + step] = True
    thin |= plain
    thin[18:20, 51:49:-1] |= np.eye(2, dtype=np.bool_)[::-1]
    assert thin.sum() > plain.sum()
    np.testing.assert_array_equal(_pruned(thin, 4), plain)


def test_lines_that_cross_closely_leave_no_rings() -> None:
    picture = lines((10, 48, 86, 48), (45, 10, 51, 86), (51, 10, 45, 86), (10, 51, 86, 45))
    ends = [[tuple(point) for point in segment] for segment in find_ridges(picture).points.tolist()]
    assert len(ends) == len({point for segment in ends for point in segment}) - 1  # one piece, and no way round
