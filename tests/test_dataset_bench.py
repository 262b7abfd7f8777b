"""The benchmark's ways to the distances agree, and it measures what it says."""

import numpy as np
import pytest

from dataset_tools.bench import by_gathering, by_product, by_trees, compare_distances, measure_view
from dataset_tools.chamfer import chamfer_matrix
from dataset_tools.settings import BuildConfig
from ncmodel.geometry.mesh import make_mesh
from ncmodel.types import Mask, Mesh
from tests import dirty

CONFIG = BuildConfig(width=64, height=64, render_size=32)


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    vertices, faces = dirty.sphere(fineness=3)
    return make_mesh(vertices * (1 + 0.2 * np.sin(5 * vertices[:, :1])), faces, "lump")


def random_masks(count: int) -> Mask:
    return np.asarray(np.random.default_rng(0).random((count, 30, 40)) < 0.02)


def test_the_obvious_ways_give_the_same_distances() -> None:
    masks = random_masks(9)
    layered = chamfer_matrix(masks, np.eye(9, dtype=bool))
    off = ~np.eye(9, dtype=bool)
    assert by_product(masks)[off] == pytest.approx(layered[off], abs=1e-4)
    assert by_gathering(masks)[off] == pytest.approx(layered[off], abs=1e-4)
    assert by_trees(masks, 36) == pytest.approx(layered[np.triu_indices(9, 1)], abs=1e-4)


def test_a_view_is_measured_by_stage(mesh: Mesh) -> None:
    cost = measure_view(mesh, CONFIG)
    assert cost.faces == 1280
    assert {"chamfer", "select", "renders", "encode maps", "buffers"} <= set(cost.stages)
    assert cost.output_bytes > 1000
    assert cost.cpu_seconds > 0


def test_every_way_is_timed_on_real_candidates(mesh: Mesh) -> None:
    costs = compare_distances(mesh, CONFIG)
    assert [cost.way for cost in costs] == ["layers", "one product", "transform a drawing", "KD-tree a pair"]
    assert all(cost.difference < 1e-4 for cost in costs)
