"""The benchmark's ways to the distances agree, and it measures what it says."""

from dataclasses import replace

import numpy as np
import pytest

from dataset_tools.build.config import BuildConfig
from dataset_tools.build.costs import (
    BuildCost,
    build_rows,
    by_gathering,
    by_product,
    by_trees,
    compare_distances,
    measure_builds,
    measure_view,
)
from ncmodel.chamfer import chamfer_matrix
from ncmodel.mesh.load import make_mesh
from ncmodel.types import Mask, Mesh
from tests.helpers import dirty

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
    assert 50e6 < cost.peak_bytes < 1.5e9


def test_builds_are_timed_and_compared(mesh: Mesh) -> None:
    notes: list[str] = []
    costs = measure_builds([mesh], (1, 2), notes.append, replace(CONFIG, min_faces=100))
    assert [(cost.workers, cost.shapes) for cost in costs] == [(1, 1), (2, 1)]
    assert len(notes) == 2
    assert build_rows([BuildCost(1, 8, 30.0), BuildCost(2, 8, 15.0)])[2] == ["2", "8", "15.0", "2.00"]


def test_every_way_is_timed_on_real_candidates(mesh: Mesh) -> None:
    costs = compare_distances(mesh, CONFIG)
    assert [cost.way for cost in costs] == ["layers", "one product", "transform a drawing", "KD-tree a pair"]
    assert all(cost.difference < 1e-4 for cost in costs)
