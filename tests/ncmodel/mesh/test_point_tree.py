"""Points near segments, against all of them."""

import numpy as np

from ncmodel.mesh.point_tree import LEAF, PointTree, near_segment
from ncmodel.types import Floats, Ints


def distances(points: Floats, start: Floats, axis: Floats) -> Floats:
    share = np.clip((points - start) @ axis / max(float(axis @ axis), 1e-300), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - start - share[:, None] * axis, axis=1))


def found(tree: PointTree, start: Floats, axis: Floats, reach: float) -> Ints:
    near = np.empty(len(tree.order), np.int64)
    return near[: near_segment(tree, start, axis, reach, near)]


def test_no_point_within_reach_is_missed() -> None:
    rng = np.random.default_rng(0)
    for count in (1, LEAF, LEAF + 1, 500):
        points = rng.uniform(size=(count, 3)) * [1.0, 1.0, rng.integers(2)]
        tree = PointTree.of(points)
        for start, axis in zip(
            rng.uniform(size=(50, 3)), rng.normal(size=(50, 3)) * rng.integers(2, size=(50, 3)), strict=True
        ):
            within = np.flatnonzero(distances(points, start, axis) <= 0.05)
            near = found(tree, start, axis, 0.05)
            assert len(np.unique(near)) == len(near)
            assert set(within) <= set(near)


def test_few_points_are_looked_at_where_thousands_of_edges_meet() -> None:
    angle = np.linspace(0, np.pi, 4000)
    points = np.concatenate([[np.zeros(3)], np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)])
    tree = PointTree.of(points)
    looked_at = [len(found(tree, points[0], points[n], 1e-4)) for n in range(1, 4001, 40)]
    assert np.mean(looked_at) < 8 * LEAF
