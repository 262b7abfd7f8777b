"""Polygons into triangles: concave, huge, of any size, crossing themselves."""

import numpy as np
import pytest

from ncmodel.readers.corner_tree import corner_tree, corners_within, take_away, turn_of
from ncmodel.readers.triangulate import triangulate


def test_concave_polygons_keep_their_area() -> None:
    """A comb of 26 corners in a tilted plane, where a fan would cover what the polygon doesn't."""
    teeth = 6
    outline = [(0.0, 0.0), (2.0 * teeth, 0.0)]
    for n in reversed(range(teeth)):
        outline += [(2 * n + 2, 3), (2 * n + 1.5, 3), (2 * n + 1.5, 1), (2 * n + 0.5, 1)]
    flat = np.array(outline)
    area = abs(
        float(np.cross(np.pad(flat, ((0, 0), (0, 1))), np.pad(np.roll(flat, -1, 0), ((0, 0), (0, 1))))[:, 2].sum())
    )
    tilt = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    points = np.pad(flat, ((0, 0), (0, 1))) @ tilt
    faces = triangulate(points, np.arange(len(points)), np.array([len(points)]))
    corners = points[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert len(faces) == len(points) - 2
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(area, rel=1e-9)
    assert (areas @ areas[0] > 0).all()


@pytest.mark.parametrize("scale", [1e300, 1e-300])
def test_polygons_of_any_size(scale: float) -> None:
    outline = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.5, 0], [0, 2, 0], [0, 5, 0], [0.1, 2, 0], [0, 1, 0]])
    for corners, sizes in ((np.arange(5), [5]), (np.array([0, 4, 5, 6]), [4])):
        expected = triangulate(outline, corners, np.array(sizes))
        np.testing.assert_array_equal(triangulate(outline * scale, corners, np.array(sizes)), expected)


@pytest.mark.parametrize("turned", [False, True])
def test_a_polygon_of_thousands_of_corners(turned: bool) -> None:
    """A star of 5000 rays, either way round: covered once, in time."""
    angle = np.linspace(0, 2 * np.pi, 10_000, endpoint=False)
    radius = np.where(np.arange(10_000) % 2, 1.0, 0.3)
    star = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)[:: -1 if turned else 1]
    a, b, c = star[triangulate(star, np.arange(10_000), np.array([10_000]))].transpose(1, 0, 2)
    areas = np.cross(b - a, c - a)[:, 2] / 2 * (-1 if turned else 1)
    assert (areas >= 0).all()
    assert areas.sum() == pytest.approx(10_000 * 0.3 * np.sin(2 * np.pi / 10_000) / 2, rel=1e-9)


def test_many_corners_are_looked_at_by_few_ears() -> None:
    """A triangle is held against the corners around it: hardly more of 20,000 than of 2,000."""
    looks = []
    for count in (2_000, 20_000):
        angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
        radius = np.where(np.arange(count) % 2, 1.0, 0.9)
        star = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
        tree, taken = corner_tree(star), np.zeros(1, np.int64)
        for n in range(1, count - 1, count // 100):
            assert corners_within(tree, star, star[n - 1], star[n], star[n + 1], 0.0, taken) == (n % 2 == 0)
        looks.append(int(taken[0]))
    assert looks[1] < 3 * looks[0]


@pytest.mark.parametrize("slack", [0.0, 1e-3])
def test_corners_in_a_triangle_are_those_of_a_search_through_all(slack: float) -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(size=(100, 2))
    tree, taken = corner_tree(points), np.zeros(1, np.int64)
    left = np.ones(100, dtype=bool)
    for n in rng.permutation(100):
        a, b, c = rng.uniform(size=(3, 2)) if n % 2 else rng.uniform(size=2) + rng.uniform(-0.1, 0.1, size=(3, 2))
        if turn_of(a, b, c) < 0:
            a, b = b, a
        inside = [min(turn_of(a, b, p), turn_of(b, c, p), turn_of(c, a, p)) >= -slack for p in points[left]]
        assert corners_within(tree, points, a, b, c, slack, taken) == any(inside)
        take_away(tree, n)
        left[n] = False


def test_polygons_that_cross_themselves_are_cut_somehow() -> None:
    bow = np.array([[0.0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.5, 1]])
    line = np.array([[float(n), 0, 0] for n in range(6)])
    for points in (bow, line, bow[[0, 0, 0, 1, 1, 2]]):
        faces = triangulate(points, np.arange(len(points)), np.array([len(points)]))
        assert len(faces) == len(points) - 2
        assert set(faces.ravel()) == set(range(len(points)))
