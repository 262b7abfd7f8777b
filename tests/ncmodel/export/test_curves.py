"""Curves along polylines: within the tolerance, smooth, and short."""

import math
import re

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ncmodel.export.curves import Path, fitted, parts_of
from ncmodel.types import Floats
from tests.helpers.pictures import scribbles

TOLERANCE = 0.2


def sampled(path: Path, tolerance: float, count: int = 1500) -> Floats:
    """Points along a path, from its own control points."""
    t = np.linspace(0.0, 1.0, count)[None, :, None]
    p, q, r, s = (path.points[:, k, None, :] / parts_of(tolerance) for k in range(4))
    cubic = (1 - t) ** 3 * p + 3 * (1 - t) ** 2 * t * q + 3 * (1 - t) * t**2 * r + t**3 * s
    straight = (1 - t) * p + t * s
    return np.where(path.straight[:, None, None], straight, cubic).reshape(-1, 2)


def finely(points: Floats, step: float = 0.02) -> Floats:
    """Points along a polyline."""
    travelled = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0, travelled[-1], max(int(travelled[-1] / step), 2))
    return np.stack([np.interp(at, travelled, axis) for axis in points.T], axis=1)


def apart(points: Floats, path: Path, tolerance: float) -> float:
    """How far a polyline and a path stray from each other (Hausdorff)."""
    a, b = finely(points), sampled(path, tolerance)
    return float(max(cKDTree(a).query(b)[0].max(), cKDTree(b).query(a)[0].max()))


def circle(radius: float, count: int) -> Floats:
    phi = np.linspace(0, 2 * np.pi, count)
    return 100 + radius * np.stack([np.cos(phi), np.sin(phi)], axis=1)


@pytest.mark.parametrize("tolerance", [0.04, 0.2, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_curves_stay_within_the_tolerance(tolerance: float, seed: int) -> None:
    """Of wild polylines, and of smooth ones of any bend."""
    rng = np.random.default_rng(seed)
    phase = np.linspace(0, 12, 300)
    wave = np.stack([30 * phase, 100 + 60 * np.sin(phase * rng.uniform(0.3, 4)) * np.cos(phase)], axis=1)
    for points in (*(stroke.points for stroke in scribbles(9, seed=seed)), wave, circle(rng.uniform(1, 80), 200)):
        assert apart(points, fitted(points, tolerance), tolerance) <= tolerance + 0.02  # steps that are compared


def test_a_circle_takes_few_curves() -> None:
    path = fitted(circle(80.0, 400), TOLERANCE)
    assert len(path.points) <= 8
    assert not path.straight.any()


def test_curves_go_on_smoothly_where_there_is_no_corner() -> None:
    path = fitted(circle(80.0, 400), TOLERANCE)
    control = path.points.astype(float)
    arriving, leaving = control[:-1, 3] - control[:-1, 2], control[1:, 1] - control[1:, 0]
    cosine = (arriving * leaving).sum(axis=1) / np.linalg.norm(arriving, axis=1) / np.linalg.norm(leaving, axis=1)
    assert (cosine > math.cos(math.radians(1.0))).all()


def test_corners_stay_sharp_and_straight_lines_straight() -> None:
    corner = np.array([[0.0, 0.0], [50.0, 0.0], [50.0, 30.0]])
    path = fitted(corner, TOLERANCE)
    assert path.straight.tolist() == [True, True]
    assert path.svg() == "M0 0l500 0 0 300"
    assert path.pdf() == "0 0 m 500 0 l 500 300 l"


def test_what_is_written_is_what_was_fitted() -> None:
    path = fitted(np.stack([np.linspace(0, 40, 60), -8 * np.sin(np.linspace(0, 3, 60))], axis=1), TOLERANCE)
    words = re.findall(r"[Mlc]|-?\d+", path.svg())
    place, at, mode = np.array([float(words[1]), float(words[2])]), 3, ""
    ends = [place]
    while at < len(words):
        if words[at] in "lc":
            mode, at = words[at], at + 1
        count = 2 if mode == "l" else 6
        place = place + np.array(words[at + count - 2 : at + count], dtype=float)
        ends.append(place)
        at += count
    assert np.array(ends[1:]) == pytest.approx(path.points[:, 3])
    assert path.pdf().count("c") == (~path.straight).sum()


def test_parts_of_a_pixel_are_as_few_as_the_tolerance_allows() -> None:
    assert [parts_of(tolerance) for tolerance in (2.0, 0.2, 0.04)] == [1, 10, 100]


@pytest.mark.parametrize("points", [[[1.0, 1.0], [1.0, 1.0]], [[1.0, 2.0], [1.2, 2.0]], [[0, 0], [5, 0], [0, 0]]])
def test_tiny_and_folded_strokes(points: list[list[float]]) -> None:
    path = fitted(np.array(points, dtype=float), TOLERANCE)
    assert apart(np.array(points, dtype=float), path, TOLERANCE) <= TOLERANCE
