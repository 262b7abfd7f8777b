"""What each stage learns: losses reach the networks they should, and held-out accuracy rises."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.pairs import read_pairs
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import load_checkpoint
from ncmodel.nets.presets import PRESETS, RankingDims, Rates, TranslationDims
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from ncmodel.training.batches import load_pairs
from ncmodel.training.dataset import ViewImages
from ncmodel.training.objectives import finetune_losses
from ncmodel.training.train import TrainOptions, run_training
from tests.helpers.micro_training import MICRO
from tests.helpers.training_data import make_data

pytestmark = pytest.mark.usefixtures("one_thread")


def test_finetuning_reaches_the_translator_through_the_merged_drawing(data: Path) -> None:
    ranker, translator = RankingModule(MICRO.ranking), TranslationBranch(MICRO.translation)
    for network in (ranker, translator):
        initialise(network, torch.Generator().manual_seed(0))
    pairs = load_pairs(ViewImages(DataFolder(data), (32,)), read_pairs(data / "pairs.jsonl")[:14], 32).on(
        torch.device("cpu")
    )
    # In evaluation mode, where drawings of a batch don't influence each other through its statistics.
    losses = finetune_losses(ranker.eval(), translator, pairs)
    for loss, reached in ((losses.ranking, False), (losses.merged_ranking, True), (losses.cross_entropy, True)):
        found = torch.autograd.grad(loss, list(translator.parameters()), retain_graph=True, allow_unused=True)
        assert any(g is not None and bool(g.abs().sum() > 0) for g in found) == reached


def test_a_translator_that_draws_nothing_leaves_the_ranking_loss_as_it_is(data: Path) -> None:
    ranker, translator = RankingModule(MICRO.ranking), TranslationBranch(MICRO.translation).eval()
    translator.expect_ink(0.0)
    translator.layers[-1].weight.data.zero_()  # type: ignore[operator]
    pairs = load_pairs(ViewImages(DataFolder(data), (32,)), read_pairs(data / "pairs.jsonl")[:7], 32).on(
        torch.device("cpu")
    )
    losses = finetune_losses(ranker.eval(), translator, pairs)
    torch.testing.assert_close(losses.merged_ranking, losses.ranking, rtol=1e-3, atol=1e-3)


def test_the_ranker_learns_what_people_like_on_shapes_it_never_saw(tmp_path: Path) -> None:
    """The tiny preset's narrow network, on smaller pictures, from 30 shapes: far over chance within a minute."""
    make_data(tmp_path, shapes=42, views=2, held_out=12)
    dims = RankingDims(size=48, width=8)
    preset = replace(PRESETS["tiny"], ranking=dims, translation=TranslationDims(size=48, width=2))
    options = TrainOptions(stages=("ranker",), epochs=12)
    report = run_training(tmp_path, tmp_path / "pairs.jsonl", tmp_path / "m.ckpt", preset, options)
    accuracy = [record["accuracy"] for record in report.history["ranker"]]
    # 168 held-out pairs: chance would be within 0.5 +- 0.12 (three standard deviations) on any one pass.
    assert np.mean(accuracy[-4:]) > 0.65
    assert report.history["ranker"][-1]["loss"] < report.history["ranker"][0]["loss"]


def test_the_translator_learns_to_draw_the_outline(data: Path, tmp_path: Path) -> None:
    rates, dims = Rates(5e-3, batch=2, epochs=12), TranslationDims(size=48, width=4, levels=2, blocks=1)
    preset = replace(MICRO, translation=dims, ranking=RankingDims(48, 2, (1, 1)), translator=rates)
    options = TrainOptions(stages=("translator",))
    report = run_training(data, data / "pairs.jsonl", tmp_path / "m.ckpt", preset, options)
    folder, translator = ViewImages(DataFolder(data), (48,)), load_checkpoint(tmp_path / "m.ckpt").translator
    assert translator is not None
    entropy = [record["cross_entropy"] for record in report.history["translator"]]
    assert min(entropy) < 0.8 * entropy[0]
    pair = read_pairs(data / "pairs.jsonl")[0]
    ink = folder.drawing(pair.item, pair.better, 48)
    probability = translator(torch.from_numpy(folder.maps(pair.item, 48))[None])[0, 0].numpy()
    assert probability[ink > 0.5].mean() > 2 * probability[ink < 0.1].mean()
