"""Zigzags of lines of curvature: hops go, quivers become smooth, and waves and curls of the surface stay."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from ncmodel.drawing.zigzags import straightened
from ncmodel.types import Floats, Stroke

Path = Callable[[Floats], Floats]


def stroke(path: Path, length: float = 200.0, family: str = "suggestive") -> Stroke:
    """Points about a pixel apart, x from 0 to a length."""
    x = np.linspace(0.0, length, int(length) + 1)
    return Stroke(family, np.stack([x, path(x)], axis=1), np.ones(len(x)), 3.0 + 0.001 * x)


def saw(teeth: float, wide: float, begin: float = 0.0, end: float = math.inf) -> Path:
    """Teeth of a height and a width between two places, straight elsewhere."""
    return lambda x: np.where((x > begin) & (x < end), teeth * np.abs((x / wide) % 1.0 - 0.5) * 2.0, 0.0)


def to_and_fro(line: Stroke) -> float:
    """Degrees that a line turns beyond what its turns come to, on 100 pixels."""
    way = np.diff(line.points, axis=0)
    turn = np.diff(np.unwrap(np.arctan2(way[:, 1], way[:, 0])))
    return math.degrees(np.abs(turn).sum() - abs(turn.sum())) / float(np.linalg.norm(way, axis=1).sum()) * 100.0


@pytest.mark.parametrize("family", ["suggestive", "apparent", "ridges", "valleys"])
def test_what_hops_between_rows_is_left_out_and_the_rest_stays(family: str) -> None:
    left, right = straightened([stroke(saw(12.0, 9.0, 90.0, 150.0), family=family)], 1.0)
    assert left.points[0, 0] == 0.0
    assert right.points[-1, 0] == 200.0
    assert 70.0 < left.points[-1, 0] < 100.0 < 140.0 < right.points[0, 0] < 170.0
    assert max(np.ptp(part.points[:, 1]) for part in (left, right)) < 4.5
    assert left.depth is not None
    np.testing.assert_allclose(left.depth, 3.0 + 0.001 * left.points[:, 0], atol=1e-3)


def test_what_quivers_becomes_smooth() -> None:
    line = stroke(lambda x: 40.0 * np.sin(x / 60.0) + saw(2.5, 6.0)(x))
    (smooth,) = straightened([line], 1.0)
    assert to_and_fro(line) > 1000.0
    assert to_and_fro(smooth) < 100.0
    np.testing.assert_allclose(smooth.points[[0, -1]], line.points[[0, -1]], atol=0.1)
    middle = np.interp(smooth.points[:, 0], line.points[:, 0], 40.0 * np.sin(line.points[:, 0] / 60.0) + 1.25)
    assert np.abs(smooth.points[:, 1] - middle).max() < 2.0


def circle(radius: float) -> Stroke:
    angle = np.linspace(0.0, 2 * math.pi, 40)
    return Stroke("suggestive", radius * np.stack([np.cos(angle), np.sin(angle)], axis=1), np.ones(40))


@pytest.mark.parametrize(
    "line",
    [
        stroke(lambda x: 12.0 * np.sin(x / 10.0)),  # waves of the surface
        stroke(lambda x: 0.3 * np.sin(1.7 * x)),  # nothing that is seen
        stroke(lambda x: np.abs(x - 100.0)),  # a corner
        stroke(saw(12.0, 9.0), family="contours"),
        stroke(saw(12.0, 9.0), family="creases"),
        circle(3.0),  # an eye
        circle(40.0),
    ],
)
def test_others_are_as_they_were(line: Stroke) -> None:
    assert straightened([line], 1.0) == (line,)


@pytest.mark.parametrize("scale", [0.5, 3.0])
def test_the_same_is_left_out_at_any_size(scale: float) -> None:
    line = stroke(saw(12.0, 9.0, 90.0, 150.0))
    large = Stroke(line.family, line.points * scale, line.alpha, line.depth)
    for one, other in zip(straightened([line], 1.0), straightened([large], scale), strict=True):
        np.testing.assert_allclose(one.points[[0, -1]] * scale, other.points[[0, -1]], atol=2.0 * scale)


def test_nothing_is_no_trouble() -> None:
    assert straightened([], 1.0) == ()
    short = Stroke("apparent", np.array([(0.0, 0.0), (1.0, 0.0)]), np.ones(2))
    assert straightened([short], 1.0) == (short,)
