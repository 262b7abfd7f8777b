"""The Geometry-Regressor learns the thresholds that drew what people chose; its training goes on where it stopped."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import InputError, UsageError
from ncmodel.model.filters import line_drawing
from ncmodel.model.predictor import load_model
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import load_checkpoint
from ncmodel.nets.presets import MAPS
from ncmodel.nets.regressor import GeometryRegressor, MeshGraph
from ncmodel.training.dataset import ViewImages
from ncmodel.training.regression import LineBatch, LineImages, LinePart, RegressorObjective, ViewLines, drawing_loss
from ncmodel.training.train import TrainOptions, TrainReport, run_training
from tests.helpers.micro_training import MICRO
from tests.helpers.training_data import add_meshes, make_data

pytestmark = pytest.mark.usefixtures("one_thread")

ITEM = Item("s000", "0")
TRUTH = torch.tensor([0.3, 0.6, 0.15, 0.9])


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A made-up data folder with meshes, and pairs."""
    root = tmp_path_factory.mktemp("regression")
    make_data(root, shapes=2, views=1, held_out=1)
    add_meshes(root)
    return root


def train(root: Path, out: Path, epochs: int = 2) -> TrainReport:
    options = TrainOptions(stages=("regressor",), epochs=epochs)
    return run_training(root, root / "pairs.jsonl", out, MICRO, options)


def made_lines(seed: int = 0, pixels: int = 400) -> ViewLines:
    """Lines of all families, each pixel of one, with features of 0 to 2."""
    generator = torch.Generator().manual_seed(seed)
    family = torch.arange(pixels) % 4
    lines = torch.nn.functional.one_hot(family, 4).T.float()
    features = lines * 2 * torch.rand(pixels, generator=generator)
    corners = np.random.default_rng(seed).standard_normal((12, 3))
    graph = MeshGraph.of(corners, corners, np.arange(12).reshape(4, 3))
    return ViewLines(graph, np.arange(pixels), (20, pixels // 20), lines, features, torch.zeros(pixels))


def test_thresholds_of_the_chosen_drawing_are_learnt() -> None:
    network = GeometryRegressor(replace(MICRO, ranking=replace(MICRO.ranking, width=4)))
    initialise(network, torch.Generator().manual_seed(0))
    view = made_lines()
    ink = line_drawing(view.lines, view.features, view.always, TRUTH[None])[0]
    maps = torch.rand(2, len(MAPS), 32, 32, generator=torch.Generator().manual_seed(1))
    graph = MeshGraph.together([view.graph, view.graph])
    objective = RegressorObjective(MICRO, network, None, [])  # type: ignore[arg-type]  # it loads nothing here
    batch = LineBatch(maps, graph, (view, view), (ink, ink))
    optimiser = torch.optim.Adam(network.parameters(), lr=1e-2)
    losses = []
    for _ in range(150):
        optimiser.zero_grad()
        loss = objective.loss(batch)
        torch.autograd.backward(loss)
        optimiser.step()
        losses.append(loss.item())
    found = network(graph, maps, view.largest.expand(2, -1)).detach()
    torch.testing.assert_close(found, TRUTH.expand(2, -1), atol=0.05, rtol=0.0)
    assert losses[-1] < 0.8 * losses[0]


def test_the_loss_s_gradient_is_that_of_differences() -> None:
    view = made_lines(1)
    exact = replace(view, lines=view.lines.double(), features=view.features.double(), always=view.always.double())
    ink = torch.rand(400, dtype=torch.float64, generator=torch.Generator().manual_seed(2))
    t = torch.tensor([0.31, 0.62, 0.11, 0.93], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda thresholds: drawing_loss(exact, thresholds, ink), t, eps=1e-7)


def test_just_below_the_last_line_there_is_a_gradient_still() -> None:
    view = made_lines(2)
    t = (view.largest * 0.999).requires_grad_()
    (slope,) = torch.autograd.grad(drawing_loss(view, t, torch.ones(400)), t)
    assert bool((slope > 0).all())  # fewer lines, a larger loss
    beyond = (view.largest * 1.001).requires_grad_()
    (none,) = torch.autograd.grad(drawing_loss(view, beyond, torch.ones(400)), beyond)
    assert not none.any()


def test_a_view_without_lines_costs_nothing() -> None:
    view = made_lines(3)
    empty = replace(view, lines=view.lines[:, :0], features=view.features[:, :0], always=view.always[:0])
    bare = replace(empty, pixels=view.pixels[:0])
    t = torch.full((4,), 0.1, requires_grad=True)
    loss = drawing_loss(bare, t, torch.zeros(0))
    assert loss.item() == 0.0
    assert not torch.autograd.grad(loss, t)[0].any()
    assert not bare.largest.any()


def test_lines_are_those_of_the_drawing(root: Path) -> None:
    images = LineImages(ViewImages(DataFolder(root), (32,)))
    item = ITEM
    view, ink = images.view_lines(item), images.chosen(item, 2)
    assert view.lines.shape == view.features.shape == (4, len(view.pixels))
    assert ink.shape == view.always.shape == (len(view.pixels),)
    assert 0.0 <= ink.min().item() <= ink.max().item() <= 1.0
    assert images.view_lines(item) is view
    assert bool((view.largest > 0).any())


def test_a_worker_loads_the_same(root: Path) -> None:
    images, part = LineImages(ViewImages(DataFolder(root), (32,))), LinePart(((ITEM, 2),), 32, {})
    copy = pickle.loads(pickle.dumps(images.for_one_of(2)))
    assert copy.cache_bytes == images.cache_bytes // 2
    here, there = part.load(images), part.load(copy)
    assert torch.equal(here.pictures.maps, there.pictures.maps)
    assert torch.equal(here.ink[0], there.ink[0])
    assert torch.equal(here.views[0].features, there.views[0].features)
    assert torch.equal(here.views[0].graph.neighbours, there.views[0].graph.neighbours)


def test_training_makes_a_checkpoint_and_goes_on_to_the_same_bytes(root: Path, tmp_path: Path) -> None:
    report = train(root, tmp_path / "whole.safetensors")
    history = report.history["regressor"]
    assert [sorted(record) for record in history] == [["cross_entropy", "epoch", "loss"]] * 2
    assert load_checkpoint(tmp_path / "whole.safetensors").regressor is not None
    train(root, tmp_path / "parts.safetensors", epochs=1)
    train(root, tmp_path / "parts.safetensors")
    assert (tmp_path / "parts.safetensors").read_bytes() == (tmp_path / "whole.safetensors").read_bytes()


def test_it_is_no_model_to_draw_with_alone(root: Path, tmp_path: Path) -> None:
    train(root, tmp_path / "r.safetensors", epochs=1)
    model = load_model(tmp_path / "r.safetensors")
    assert model.variants == ()
    with pytest.raises(UsageError, match="holds regressor; expected a ranker or a translator"):
        model.known_variant(None)


def test_a_drawing_of_another_size_is_named(root: Path, tmp_path: Path) -> None:
    item, data = ITEM, DataFolder(root)
    images = LineImages(ViewImages(data, (32,)))
    lines = images.view_lines(item)
    images._lines[item] = replace(lines, shape=(lines.shape[0], lines.shape[1] + 1))
    with pytest.raises(InputError, match=r"2\.png: \d+ x \d+ pixels; expected \d+ x \d+ pixels, as the view's camera"):
        images.chosen(item, 2)
