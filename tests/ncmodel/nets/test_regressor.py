"""The Geometry-Regressor: as the appendix has it, blind to the order of vertices, its thresholds in range."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from ncmodel.nets.blocks import ResidualBlock, initialise
from ncmodel.nets.losses import ink_cross_entropy
from ncmodel.nets.presets import PRESETS, RankingDims
from ncmodel.nets.regressor import GeometryRegressor, MeshGraph, bounded
from ncmodel.types import Floats, Ints
from tests.helpers.analytic import ellipsoid, torus
from tests.helpers.micro_training import MICRO

NARROW = replace(MICRO, ranking=RankingDims(size=32, width=4, blocks=(1, 1)))


def graph_of(surface: tuple[Floats, Ints]) -> MeshGraph:
    vertices, faces = surface
    return MeshGraph.of(vertices, vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces)


@pytest.fixture(scope="module")
def network() -> GeometryRegressor:
    network = GeometryRegressor(NARROW)
    initialise(network, torch.Generator().manual_seed(0))
    return network.eval()


@pytest.fixture(scope="module")
def maps() -> Tensor:
    return torch.rand(2, len(NARROW.inputs), 32, 32, generator=torch.Generator().manual_seed(1))


LARGEST = torch.tensor([[2.0, 1.0, 0.5, 30.0], [1.0, 0.0, 3.0, 1.0]])


def test_the_paper_s_has_vectors_of_1024_a_resnet_34_and_three_layers() -> None:
    with torch.device("meta"):
        network = GeometryRegressor(PRESETS["paper"])
    assert network.size == 768
    assert (network.mesh.head.out_features, network.image.head.out_features) == (1024, 1024)
    layers = [layer for layer in network.layers if isinstance(layer, nn.Linear)]
    assert (len(layers), layers[0].in_features, layers[-1].out_features) == (3, 2048, 4)
    stages = [stage for stage in network.image.stages if isinstance(stage, nn.Sequential)]
    assert [len(stage) for stage in stages] == [3, 4, 6, 3]
    assert all(isinstance(block, ResidualBlock) for stage in stages for block in stage)
    assert stages[-1][-1].second[0].out_channels == 512  # type: ignore[union-attr, index]


def test_the_order_of_vertices_and_faces_makes_no_difference(network: GeometryRegressor, maps: Tensor) -> None:
    rng = np.random.default_rng(0)
    vertices, faces = torus(12, 8)
    order = rng.permutation(len(vertices))
    place = np.argsort(order)
    shuffled = vertices[order], np.roll(place[faces][rng.permutation(len(faces))], 1, axis=1)
    with torch.no_grad():
        before, after = (network(graph_of(mesh), maps[:1], LARGEST[:1]) for mesh in ((vertices, faces), shuffled))
        other = network(graph_of((vertices * [1.0, 1.5, 1.0], faces)), maps[:1], LARGEST[:1])
    torch.testing.assert_close(after, before, rtol=1e-4, atol=1e-5)
    # The mesh isn't ignored.
    assert (other - before).abs().max() > 1e-3


def test_views_beside_each_other_are_as_alone(network: GeometryRegressor, maps: Tensor) -> None:
    graphs = [graph_of(torus(12, 8)), graph_of(ellipsoid(1))]
    with torch.no_grad():
        both = network(MeshGraph.together(graphs), maps, LARGEST)
        alone = [network(graph, maps[n : n + 1], LARGEST[n : n + 1]) for n, graph in enumerate(graphs)]
    torch.testing.assert_close(both, torch.cat(alone), rtol=1e-4, atol=1e-5)


def test_neighbours_are_known_in_both_directions_once() -> None:
    graph = MeshGraph.of(np.eye(4, 3), np.eye(4, 3), np.array([[0, 1, 2], [2, 1, 3]]))
    pairs = {tuple(pair) for pair in graph.neighbours.T.tolist()}
    assert pairs == {(a, b) for a in range(4) for b in range(4) if a != b and {a, b} != {0, 3}}
    assert graph.neighbours.shape == (2, 10)


@pytest.mark.parametrize("raw", [-20.0, 0.0, 3.0, 1e3])
def test_thresholds_stay_in_range_and_keep_their_gradients(raw: float) -> None:
    asked = torch.full((2, 4), raw, requires_grad=True)
    t = bounded(asked, LARGEST)
    assert bool((t >= 0).all())
    assert bool((t < LARGEST)[LARGEST > 0].all())
    assert bool((t == 0)[LARGEST == 0].all())
    (slope,) = torch.autograd.grad(t.sum(), asked)
    assert bool((slope > 0)[LARGEST > 0].all())
    assert bool(slope.isfinite().all())


def test_small_thresholds_are_softplus() -> None:
    t = bounded(torch.tensor([[0.0, 1.0, 2.0, -3.0]]), torch.full((1, 4), 1e6))
    torch.testing.assert_close(t, nn.functional.softplus(torch.tensor([[0.0, 1.0, 2.0, -3.0]])), rtol=1e-4, atol=0.0)


def test_ink_of_exactly_0_and_1_has_a_gradient() -> None:
    ink = torch.tensor([0.0, 1.0, 0.0, 1.0, 0.5], dtype=torch.float64, requires_grad=True)
    target = torch.tensor([1.0, 0.0, 0.0, 1.0, 0.25], dtype=torch.float64)
    loss = ink_cross_entropy(ink, target)
    (slope,) = torch.autograd.grad(loss, ink)
    assert loss.item() == pytest.approx((2 * -np.log(0.01) + 2 * -np.log(0.99) + np.log(2)) / 5)
    assert slope.sign().tolist() == [-1, 1, 1, -1, 1]
    with torch.autocast("cpu", torch.bfloat16):
        assert ink_cross_entropy(ink, target).item() == pytest.approx(loss.item(), rel=1e-6)
    inner = torch.rand(6, dtype=torch.float64, generator=torch.Generator().manual_seed(0), requires_grad=True)
    wanted = torch.rand(6, dtype=torch.float64, generator=torch.Generator().manual_seed(1))
    assert torch.autograd.gradcheck(lambda drawn: ink_cross_entropy(drawn, wanted), inner)
