"""pix2pixHD as an objective: who learns from what, and a training that goes on where it stopped."""

from pathlib import Path

import pytest
import torch
from torch import Tensor

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.pairs import read_pairs
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import load_checkpoint
from ncmodel.nets.presets import MAPS
from ncmodel.nets.translation import TranslationBranch
from ncmodel.training.adversarial import Pix2pixHDObjective
from ncmodel.training.batches import Batch
from ncmodel.training.dataset import ViewImages
from tests.helpers.micro_training import MICRO, run

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture
def objective(data: Path) -> Pix2pixHDObjective:
    translator = TranslationBranch(MICRO.translation, MICRO.inputs)
    initialise(translator, torch.Generator().manual_seed(0))
    images = ViewImages(DataFolder(data), (MICRO.translation.size,))
    return Pix2pixHDObjective(MICRO, translator, images, read_pairs(data / "pairs.jsonl"))


@pytest.fixture
def batch() -> Batch:
    generator = torch.Generator().manual_seed(1)
    maps, drawings = (torch.rand(2, channels, 32, 32, generator=generator) for channels in (len(MAPS), 1))
    return Batch(maps, drawings.round(), torch.arange(2))


def slopes(objective: Pix2pixHDObjective, loss: Tensor) -> dict[str, float]:
    """How much a loss moves each network."""
    for network in objective.networks.values():
        network.zero_grad()
    torch.autograd.backward(loss)
    grads = {name: [p.grad for p in network.parameters()] for name, network in objective.networks.items()}
    return {name: sum(float(g.abs().sum()) for g in found if g is not None) for name, found in grads.items()}


def test_each_loss_moves_one_of_them_alone(objective: Pix2pixHDObjective, batch: Batch) -> None:
    drawn = objective.translator(batch.maps)
    moved = slopes(objective, objective.generator_loss(batch, drawn))
    assert moved["translator"] > 0 == moved["discriminator"]
    moved = slopes(objective, objective.discriminator_loss(batch, objective.translator(batch.maps)))
    assert moved["discriminator"] > 0 == moved["translator"]
    moved = slopes(objective, objective.loss(batch))
    assert min(moved.values()) > 0


def test_a_drawing_that_is_the_real_one_matches_all_features(objective: Pix2pixHDObjective, batch: Batch) -> None:
    said = objective.discriminator(batch.maps, batch.drawings)
    adversarial = torch.stack([(layers[-1] - 1).square().mean() for layers in said]).mean()
    torch.testing.assert_close(objective.generator_loss(batch, batch.drawings), adversarial)


def test_discriminators_learn_to_tell_drawings_apart(objective: Pix2pixHDObjective, batch: Batch) -> None:
    drawn = objective.translator(batch.maps).detach()
    optimiser = torch.optim.Adam(objective.discriminator.parameters(), lr=2e-3)
    losses = []
    for _ in range(60):
        optimiser.zero_grad()
        loss = objective.discriminator_loss(batch, drawn)
        torch.autograd.backward(loss)
        optimiser.step()
        losses.append(loss.item())
    assert losses[-1] < 0.1 < losses[0]


def test_the_generator_comes_nearer_to_the_drawings(objective: Pix2pixHDObjective, batch: Batch) -> None:
    optimiser = torch.optim.Adam([p for net in objective.networks.values() for p in net.parameters()], lr=1e-2)
    before = (objective.translator(batch.maps) - batch.drawings).abs().mean().item()
    for _ in range(80):
        optimiser.zero_grad()
        torch.autograd.backward(objective.loss(batch))
        optimiser.step()
    assert (objective.translator(batch.maps) - batch.drawings).abs().mean().item() < 0.95 * before


def test_a_training_goes_on_to_the_same_bytes_and_says_what_it_was(data: Path, tmp_path: Path) -> None:
    options = {"stages": ("translator",), "objective": "pix2pixhd"}
    report = run(data, tmp_path / "whole", epochs=2, **options)
    assert [sorted(record) for record in report.history["translator"]] == [["epoch", "loss"]] * 2
    assert report.stages[0].best_epoch == 2
    run(data, tmp_path / "parts", epochs=1, **options)
    run(data, tmp_path / "parts", epochs=2, **options)
    assert (tmp_path / "parts").read_bytes() == (tmp_path / "whole").read_bytes()
    checkpoint = load_checkpoint(tmp_path / "whole")
    assert list(checkpoint.networks) == ["translator"]
    said = checkpoint.training["stages"]["translator"]["objective"]
    assert said == "ncmodel.training.adversarial:Pix2pixHDObjective"
