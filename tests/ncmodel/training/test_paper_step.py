"""One real training step of the paper's networks at their size: it learns, in parts that fit a small machine."""

import resource
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.pairs import read_pairs
from ncmodel.nets.blocks import initialise
from ncmodel.nets.presets import PRESETS
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from ncmodel.training.dataset import ViewImages
from ncmodel.training.loader import Loader
from ncmodel.training.loop import Means, Trainer
from ncmodel.training.objectives import Objective, RankerObjective, TranslatorObjective
from tests.helpers.training_data import make_data

PAPER = PRESETS["paper"]
MOST_GIB = {"ranker": 6.0, "translator": 12.0}
"""Of the process, with a pair or a view at a time."""


@pytest.mark.slow
@pytest.mark.parametrize(("stage", "parameters"), [("ranker", 73_744_513), ("translator", 182_492_289)])
def test_a_step_of_the_papers_networks(tmp_path: Path, stage: str, parameters: int) -> None:
    make_data(tmp_path, shapes=1, views=1, side=768)
    images, pairs = ViewImages(DataFolder(tmp_path), (768,)), read_pairs(tmp_path / "pairs.jsonl")
    objective: Objective
    if stage == "ranker":
        ranker = RankingModule(PAPER.ranking)
        objective = RankerObjective(PAPER, ranker, images, pairs[:2])
    else:
        objective = TranslatorObjective(PAPER, TranslationBranch(PAPER.translation), images, pairs)
    initialise(objective.networks[stage], torch.Generator().manual_seed(0))
    objective.prepare()
    trainer = Trainer(objective, Means(micro_batch=1))
    trainer.learn()
    before = {name: p.detach().clone() for name, p in trainer.networks.named_parameters()}
    assert sum(p.numel() for p in before.values()) == parameters
    parts = trainer.parts(objective.steps(np.random.default_rng(0))[0])
    loss = trainer.step([share for _, share in parts], Loader(images).load([part for part, _ in parts]))
    assert np.isfinite(loss)
    moved = {name for name, p in trainer.networks.named_parameters() if not torch.equal(p, before[name])}
    # Residual blocks begin as the identity: in the first step their last gain moves, and what is outside of them.
    gains = {name for name in before if name.endswith("second.1.weight")}
    ends = {"ranker": ("stem.weight", "head.weight"), "translator": ("layers.0.0.0.weight", "layers.10.weight")}[stage]
    assert gains | {f"{stage}.{name}" for name in ends} <= moved
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1 << 20) < MOST_GIB[stage]
