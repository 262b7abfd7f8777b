"""Feature sizes and the smallest enclosing sphere."""

from itertools import combinations

import numpy as np
import pytest

from ncmodel.geometry.feature_size import enclosing_radius, feature_size_of_all, sampled_feature_size
from ncmodel.scene.surface import Surface
from ncmodel.types import Mesh
from tests.helpers import analytic


@pytest.mark.parametrize("seed", range(20))
def test_enclosing_radius_by_trying_all_supports(seed: int) -> None:
    """No sphere through two, three or four of the points that holds all of them is smaller."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(7, 3)) * rng.uniform(0.01, 1, 3)
    candidates = []
    for size in (2, 3, 4):
        for chosen in combinations(points, size):
            edges = np.array(chosen[1:]) - chosen[0]
            gram = 2 * edges @ edges.T
            if np.linalg.cond(gram) < 1e12:
                centre = chosen[0] + np.linalg.solve(gram, (edges**2).sum(axis=1)) @ edges
                radius = np.linalg.norm(chosen[0] - centre)
                if np.linalg.norm(points - centre, axis=1).max() <= radius * (1 + 1e-9):
                    candidates.append(radius)
    assert enclosing_radius(points) == pytest.approx(min(candidates), rel=1e-9)


def test_enclosing_radius_of_known_shapes() -> None:
    assert enclosing_radius(analytic.icosphere(3, 0.37)[0]) == pytest.approx(0.37, rel=1e-9)
    assert enclosing_radius(analytic.cube()[0]) == pytest.approx(np.sqrt(3) / 2, rel=1e-9)
    assert enclosing_radius(np.array([[0.0, 0, 0], [1, 0, 0], [0.4, 0, 0]])) == pytest.approx(0.5, rel=1e-9)
    assert enclosing_radius(np.zeros((4, 3))) == 0
    grid = np.stack(np.meshgrid(*[np.arange(5.0)] * 3), axis=-1).reshape(-1, 3)
    assert enclosing_radius(grid) == pytest.approx(np.sqrt(12), rel=1e-9)
    phi = np.linspace(0, 2 * np.pi, 100)
    assert enclosing_radius(np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=1)) == pytest.approx(1, rel=1e-9)


def test_sampled_size_takes_the_vertices_it_says() -> None:
    """The first samples of 10 vertices are 0, 3, 6, .. by the congruential sequence modulo 2^32 and then 10."""
    curvatures = np.zeros((10, 2))
    state, picked = 0, []
    for _ in range(10):
        state = (1664525 * state + 1013904223) % 2**32
        picked.append(state % 10)
    curvatures[:, 0] = np.arange(10) + 1
    samples = sorted([c for v in picked for c in (v + 1.0, 0.0)])
    assert samples[2] == 0
    assert sampled_feature_size(curvatures, 2.0) == 0.1
    curvatures[:, 1] = -np.arange(10) - 1
    samples = sorted([c for v in picked for c in (v + 1.0, v + 1.0)])
    assert sampled_feature_size(curvatures, 2.0) == pytest.approx(min(0.01 / samples[2], 0.1))


def test_sizes_of_a_sphere() -> None:
    """0.01 R, capped by 0.05 R."""
    surface = Surface(Mesh(*analytic.icosphere(4, 0.5)))
    assert surface.feature_size == pytest.approx(0.005, rel=1e-9)
    assert Surface(surface.mesh, sizing="sampled").feature_size == pytest.approx(0.005, rel=1e-9)


def test_all_vertices_count_in_any_order() -> None:
    """The 10th percentile, to the bit, in any order; the sampled one is an estimate of it that depends on the order."""
    rng = np.random.default_rng(2)
    curvatures = rng.exponential(size=(20_000, 2))
    whole = feature_size_of_all(curvatures, 100.0)
    assert whole == pytest.approx(0.01 / np.quantile(curvatures, 0.1), rel=1e-3)
    samples = []
    for _ in range(20):
        rng.shuffle(curvatures)
        assert feature_size_of_all(curvatures, 100.0) == whole
        samples.append(sampled_feature_size(curvatures, 100.0))
    assert np.ptp(samples) > 0.1 * whole
    assert np.median(samples) == pytest.approx(whole, rel=0.1)


def test_no_curvature_leaves_the_cap() -> None:
    assert sampled_feature_size(np.zeros((3, 2)), 2.0) == 0.1
    assert feature_size_of_all(np.zeros((3, 2)), 2.0) == 0.1
