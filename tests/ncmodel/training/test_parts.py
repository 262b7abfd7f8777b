"""Steps in parts: their gradients add up to the whole step's; bfloat16 learns what float32 does."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.pairs import read_pairs
from ncmodel.nets.blocks import initialise
from ncmodel.nets.presets import RankingDims, Rates, TranslationDims
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from ncmodel.training.dataset import ViewImages
from ncmodel.training.loader import Loader
from ncmodel.training.loop import Means, Trainer
from ncmodel.training.objectives import FinetuneObjective, Objective, RankerObjective, TranslatorObjective
from ncmodel.training.train import TrainOptions, run_training
from tests.helpers.micro_training import MICRO, run

pytestmark = pytest.mark.usefixtures("one_thread")


def objective_of(stage: str, data: Path) -> Objective:
    """A stage's objective, batch norms with gains and running statistics that aren't the initial ones."""
    ranker, translator = RankingModule(MICRO.ranking), TranslationBranch(MICRO.translation)
    generator = torch.Generator().manual_seed(0)
    for network in (ranker, translator):
        initialise(network, generator)
        for module in network.modules():
            if isinstance(module, torch.nn.BatchNorm2d):
                assert module.running_mean is not None
                assert module.running_var is not None
                module.weight.data.uniform_(0.5, 1.5, generator=generator)
                module.running_mean.normal_(0, 0.1, generator=generator)
                module.running_var.uniform_(0.5, 1.5, generator=generator)
    images, pairs = ViewImages(DataFolder(data), (32,)), read_pairs(data / "pairs.jsonl")
    if stage == "ranker":
        return RankerObjective(MICRO, ranker, images, pairs)
    if stage == "translator":
        return TranslatorObjective(MICRO, translator, images, pairs)
    return FinetuneObjective(MICRO, ranker, translator, images, pairs)


def one_step(stage: str, data: Path, means: Means) -> tuple[float, list[torch.Tensor], int]:
    """Loss and gradients of the first step, and in how many parts it was taken."""
    objective = objective_of(stage, data)
    trainer = Trainer(objective, means)
    trainer.learn()
    assert objective.images is not None
    parts = trainer.parts(objective.steps(np.random.default_rng(3))[0])
    loaded = Loader(objective.images).load([part for part, _ in parts])
    loss = trainer.step([share for _, share in parts], loaded)
    return loss, [p.grad for p in trainer.networks.parameters() if p.grad is not None], len(parts)


@pytest.mark.parametrize("stage", ["ranker", "translator", "finetune"])
@pytest.mark.parametrize("micro_batch", [1, 3])
def test_parts_add_up_to_the_whole_step(data: Path, stage: str, micro_batch: int) -> None:
    whole, expected, one = one_step(stage, data, Means(batch_norm="frozen"))
    loss, found, several = one_step(stage, data, Means(micro_batch=micro_batch, batch_norm="frozen"))
    assert one == 1
    assert several > 1 or (stage == "translator" and micro_batch == 3)
    assert loss == pytest.approx(whole, rel=1e-5)
    scale = max(float(g.abs().max()) for g in expected)
    for ours, theirs in zip(found, expected, strict=True):
        torch.testing.assert_close(ours, theirs, rtol=1e-4, atol=1e-5 * scale)


def test_parts_of_a_step_show_views_as_the_whole_does(data: Path) -> None:
    objective = objective_of("finetune", data)
    step = objective.steps(np.random.default_rng(3))[0]
    halves = step.cut(2)
    assert [len(half) for half in halves] == [len(step) // 2, -(-len(step) // 2)]
    assert all(half.poses == step.poses for half in halves)  # type: ignore[attr-defined]


def test_own_statistics_of_parts_are_others_than_the_whole_s(data: Path) -> None:
    whole, _, _ = one_step("ranker", data, Means())
    loss, _, _ = one_step("ranker", data, Means(micro_batch=2))
    assert loss != pytest.approx(whole, rel=1e-5)


def test_frozen_statistics_stay_and_gains_learn(data: Path) -> None:
    objective = objective_of("ranker", data)
    before = {name: value.clone() for name, value in objective.networks["ranker"].state_dict().items()}
    trainer = Trainer(objective, Means(batch_norm="frozen"))
    trainer.learn()
    step = objective.steps(np.random.default_rng(3))[0]
    trainer.step([1.0], Loader(objective.images).load([step]))
    after = objective.networks["ranker"].state_dict()
    same = {name for name, value in before.items() if torch.equal(value, after[name])}
    assert {name for name in before if "running" in name} <= same
    assert "stem_norm.weight" not in same


def test_bfloat16_learns_what_float32_does(data: Path, tmp_path: Path) -> None:
    """Weights stay in float32, losses fall alike; and it isn't float32 under another name."""
    rates, dims = Rates(5e-3, batch=2, epochs=6), TranslationDims(size=32, width=4, levels=2, blocks=1)
    preset = replace(MICRO, translation=dims, ranking=RankingDims(32, 4, (1, 1)), translator=rates)
    curves = {}
    for precision in ("float32", "bfloat16"):
        options = TrainOptions(stages=("ranker", "translator"), epochs=6, precision=precision)
        report = run_training(data, data / "pairs.jsonl", tmp_path / precision, preset, options)
        curves[precision] = {stage: [r["loss"] for r in records] for stage, records in report.history.items()}
    for stage in ("ranker", "translator"):
        exact, rough = (np.array(curves[precision][stage]) for precision in ("float32", "bfloat16"))
        assert exact[-1] < exact[0]
        np.testing.assert_allclose(rough, exact, rtol=0.05)
        assert not np.array_equal(rough, exact)


def test_bfloat16_is_taken_on_a_cpu_only_if_asked_for(data: Path, tmp_path: Path) -> None:
    for name, precision in (("asked", "float32"), ("default", None)):
        run(data, tmp_path / name, stages=("ranker",), epochs=1, precision=precision)
    assert (tmp_path / "asked").read_bytes() == (tmp_path / "default").read_bytes()
