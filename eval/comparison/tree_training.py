"""The decision tree, trained on the drawings that voters chose of training views: nothing else is seen.

The leaves are learnt on some shapes, and what counts as a line in what they predict on the others: a tree is surer of
what it has seen.
"""

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from dataset_tools.build.runners import Runner
from eval.baselines.decision_tree import Tree
from eval.baselines.tree_fitting import RIDGES, Examples, examples_of, fit, ridge_costs
from eval.comparison.tuning import LIMITS
from eval.comparison.views import open_as_drawn, target_of
from eval.measures.evaluation import Settings
from eval.measures.thinning import read_ink
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import best_drawings, read_pairs
from ncmodel.errors import ArgumentError, InputError
from ncmodel.progress import Progress, silent
from ncmodel.types import Floats

PIXELS = 40_000
"""Examples in all, unless told otherwise."""

EVERY = 5
"""Each so manieth training shape says what counts as a line."""

T = TypeVar("T", bound="_OneView")
R = TypeVar("R")


@dataclass(frozen=True)
class _OneView:
    """A training view.

    Attributes:
        root: The data folder.
        item: The view.
        chosen: Which of its eight drawings voters chose.
    """

    root: Path
    item: Item
    chosen: int


@dataclass(frozen=True)
class _Sampling(_OneView):
    count: int
    seed: int


@dataclass(frozen=True)
class _Judging(_OneView):
    tree: Tree
    settings: Settings


def train_tree(
    data_dir: str | Path,
    pairs: str | Path,
    runner: Runner,
    pixels: int = PIXELS,
    seed: int = 0,
    settings: Settings | None = None,
    progress: Progress = silent,
) -> Tree:
    """Train a decision tree on the training views' chosen drawings.

    Args:
        data_dir: DATA_DIR.
        pairs: pairs.jsonl; the split "train" is learnt from.
        runner: Works off the views.
        pixels: Examples in all, shared out evenly among views.
        seed: Of the examples.
        settings: How drawings are compared when it is decided what counts as a line.
        progress: Is told about every view.

    Raises:
        ArgumentError: Too few pixels, or a negative seed.
        InputError: The data can't be used, or holds fewer than two training shapes.
        UsageError: Cubist isn't installed.
    """
    if pixels < 100:
        raise ArgumentError("pixels", str(pixels), "100 or more")
    if seed < 0:
        raise ArgumentError("seed", str(seed), "0 or more")
    data, read = DataFolder(data_dir), read_pairs(pairs)
    training = {pair.item for pair in read if pair.split == "train"}
    data.require(sorted(training), pairs)
    best = {item: chosen for item, chosen in best_drawings(read).items() if item in training}
    shapes = sorted({item.shape for item in best})
    if len(shapes) < 2:
        raise InputError(pairs, f"{len(shapes)} training shapes", 'pairs with "split": "train" of two or more shapes')
    judges = set(shapes[EVERY - 1 :: EVERY] or shapes[-1:])
    views = [_OneView(data.root, item, chosen) for item, chosen in sorted(best.items())]
    learnt = [view for view in views if view.item.shape not in judges]
    judging = [view for view in views if view.item.shape in judges]
    each = -(-pixels // len(learnt))
    sampling = [_Sampling(view.root, view.item, view.chosen, each, seed) for view in learnt]
    samples = _all(_examples, sampling, runner, progress, "Decision tree: pixels of views")
    tree = fit(Examples.together(samples))
    tasks = [_Judging(view.root, view.item, view.chosen, tree, settings or Settings()) for view in judging]
    costs = np.mean(_all(_costs, tasks, runner, progress, "Decision tree: what counts as a line"), axis=0)
    record: Mapping[str, Any] = {
        "shapes": len(shapes) - len(judges),
        "views": len(learnt),
        "pixels": sum(len(part.ink) for part in samples),
        "seed": seed,
        "lines_chosen_on_views": len(judging),
        "chamfer": float(costs.min()),
    }
    return replace(tree, ridges=RIDGES[int(np.argmin(costs))], training=record)


def _examples(task: _Sampling) -> Examples:
    data = DataFolder(task.root)
    rng = np.random.default_rng([task.seed, zlib.crc32(task.item.name.encode())])
    ink = read_ink(data.drawing_path(task.item, task.chosen))
    return examples_of(open_as_drawn(data, task.item), ink, task.count, rng)


def _costs(task: _Judging) -> Floats:
    data = DataFolder(task.root)
    view = open_as_drawn(data, task.item)
    reference = {"chosen": read_ink(data.drawing_path(task.item, task.chosen))}
    return ridge_costs(view, target_of(view, task.item.name, reference, task.settings, whole=False), task.tree)


def _all(function: Callable[[T], R], tasks: Sequence[T], runner: Runner, progress: Progress, title: str) -> list[R]:
    """The results of all views, in their order, whoever was ready first."""
    found: dict[Item, R] = {}
    with progress(title, len(tasks)) as advance:
        for outcome in runner.run(function, tasks, LIMITS):
            item = outcome.task.item
            if outcome.result is None:
                folder = DataFolder(outcome.task.root).view_folder(item)
                raise InputError(folder, outcome.reason, "a view that lines can be drawn of")
            found[item] = outcome.result
            advance(item.name)
    return [found[task.item] for task in tasks]
