"""From measured views and simulated votes to the ranker on numbers."""

import random
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import torch

from dataset_tools.collection.families import split_of
from dataset_tools.collection.selection import shape_names
from dataset_tools.simulation.participants import Crowd
from eval.default_model.views import MeasuredView
from eval.default_model.votes import rounds
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, Split
from ncmodel.model.statistics import Statistics
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.presets import Preset
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.progress import Progress, silent
from ncmodel.training.loop import Plan, fit
from ncmodel.training.statistics import StatisticsObjective, learn_habit, learn_mix
from ncmodel.types import Ints

POOL = 520
"""Made shapes of training families that the training shapes are taken from, in random order, so that any number of them
has some of all families. The test families' shapes among the same draw are a tenth as many."""

WATCHING = 10
"""Of the shapes that may be trained on, every so many-th watches over training instead."""


class MeasuredNumbers:
    """The numbers of measured views, whose drawings are all 256.

    Args:
        views: The views.
    """

    def __init__(self, views: Sequence[MeasuredView]) -> None:
        self._known: Mapping[Item, Statistics] = {view.item: view.statistics for view in views}

    def of(self, item: Item) -> Statistics:
        """The numbers of all drawings of an item."""
        return self._known[item]

    def settings(self, item: Item) -> Ints:
        """(256,) which setting each of its drawings has."""
        return np.arange(len(self._known[item].drawings))


def training_shapes(count: int) -> list[str]:
    """The names of the first made shapes to train on.

    Args:
        count: Up to `POOL`.
    """
    pool = shape_names(POOL, split="training") + shape_names(POOL // 10, split="test")
    random.Random(0).shuffle(pool)
    return [name for name in pool if split_of(name) == "training"][:count]


def split_for(shape: str) -> Split | None:
    """What a shape's votes are for, by its name alone; None for those that are only tested on."""
    if split_of(shape) == "test":
        return None
    return "validation" if zlib.crc32(shape.encode()) % WATCHING == 0 else "train"


def simulated_pairs(views: Sequence[MeasuredView], questions: int, crowd: Crowd, seed: int) -> list[Pair]:
    """Ranking pairs of all views that may be trained on."""
    pairs: list[Pair] = []
    for view in views:
        split = split_for(view.item.shape)
        if split is not None:
            rng = np.random.default_rng([seed, zlib.crc32(view.item.name.encode())])
            pairs += rounds(view, questions, crowd, split, rng)
    return pairs


def train_statistics(
    views: Sequence[MeasuredView],
    pairs: Sequence[Pair],
    preset: Preset,
    state: Path,
    seed: int,
    progress: Progress = silent,
) -> Checkpoint:
    """Train the ranker on numbers, its habit and its mix.

    Args:
        views: All views that the pairs speak of.
        pairs: Of settings.
        preset: With the ranker's dimensions and rates.
        state: File that the training goes on from.
        seed: Of weights and order.
        progress: Is told about every pass.
    """
    assert preset.statistics is not None
    ranker = StatisticsRanker(preset.statistics)
    ranker.initialise(torch.Generator().manual_seed(seed))
    objective = StatisticsObjective(preset, ranker, MeasuredNumbers(views), pairs, progress)
    plan = Plan(state, {"seed": seed, "pairs": len(pairs)}, preset.counting.epochs, seed)
    done = fit(objective, plan, progress)
    learn_habit(objective)
    learn_mix(objective, None, None)
    record = {
        "epochs": len(done.history),
        "best_epoch": done.best_epoch,
        "seed": seed,
        "pairs": {split: sum(pair.split == split for pair in pairs) for split in ("train", "validation")},
        "views": len({pair.item for pair in pairs}),
        "validation": done.validation,
    }
    return Checkpoint(preset, statistics=ranker, training={"stages": {"statistics": record}})
