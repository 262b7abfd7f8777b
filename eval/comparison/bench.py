"""A whole comparison: which views, baselines tuned, every view measured by a pool of processes, resumable."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dataset_tools.build.runners import Runner
from eval.baselines import grid
from eval.baselines.decision_tree import Tree
from eval.comparison.measuring import Bench, ViewTask, checksum, measure_view, models_of
from eval.comparison.methods import labels, row_names
from eval.comparison.report import Outcome
from eval.comparison.tuning import LIMITS, tune
from eval.comparison.views import references_of, views_to_compare
from eval.measures.evaluation import Settings
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, best_drawings, read_pairs
from ncmodel.errors import ArgumentError, InputError
from ncmodel.model.threshold_search import budget_named
from ncmodel.nets.devices import device_named
from ncmodel.nets.shipped import checkpoint_path
from ncmodel.progress import Progress, silent


@dataclass(frozen=True)
class Options:
    """How to compare.

    Attributes:
        models: Checkpoints, or "default" for the one that ships; none compares the classic methods alone.
        tree: A decision tree that was trained; None compares without.
        references: "simulated", or a folder of people's drawings.
        views: Which shapes' views: "held-out", "validation", "train" or "all".
        shapes: Of these only those of some shapes; of all by default.
        baseline: The row that others are compared with.
        preset: Of the models' search.
        device: Where the models compute.
        levels: Thresholds that the -grid rows are tuned through.
        tuning_views: At most so many training views to tune on, evenly spread; all by default.
        settings: How drawings are compared; the tolerance is in pixels of pictures 768 wide.
        whole: Keep silhouettes.
        seed: Of the resampling.
    """

    models: Sequence[Path] = ()
    tree: Path | None = None
    references: str = "simulated"
    views: str = "held-out"
    shapes: Sequence[str] = ()
    baseline: str = "all-grid"
    preset: str = "balanced"
    device: str = "cpu"
    levels: int = grid.THRESHOLDS
    tuning_views: int | None = None
    settings: Settings = field(default_factory=Settings)
    whole: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        budget_named(self.preset)
        device_named(self.device)
        if self.levels < 2:
            raise ArgumentError("levels", str(self.levels), "2 or more")
        if self.tuning_views is not None and self.tuning_views < 1:
            raise ArgumentError("tuning_views", str(self.tuning_views), "1 or more")
        if self.seed < 0:
            raise ArgumentError("seed", str(self.seed), "0 or more")


def compare_methods(
    data_dir: str | Path,
    pairs: str | Path,
    out: str | Path,
    options: Options,
    runner: Runner,
    progress: Progress = silent,
) -> Outcome:
    """Draw and measure all methods on all views; write nothing but what views leave behind.

    Args:
        data_dir: DATA_DIR.
        pairs: pairs.jsonl.
        out: REPORT; views that an earlier comparison measured there in the same way aren't measured again.
        options: How to compare.
        runner: Works off the views.
        progress: Is told about every view.

    Raises:
        InputError: Data, pairs, models, tree or references can't be used, or no view could be measured.
        UsageError: An option makes no sense.
    """
    data, read = DataFolder(data_dir), read_pairs(pairs)
    data.require(sorted({pair.item for pair in read}), pairs)
    checkpoints = [checkpoint_path(path) for path in options.models]
    models = dict(zip(labels(checkpoints), checkpoints, strict=True))
    tree = None if options.tree is None else Tree.load(options.tree)
    rows = row_names(models_of(tuple(models.items()), options.device), tree is not None)
    if options.baseline not in rows:
        raise ArgumentError("baseline", repr(options.baseline), f"one of {', '.join(rows)}")
    references = references_of(options.references, data)
    items = views_to_compare(data, read, references, options.views, options.shapes)
    best = best_drawings(read)
    training = _tuned_on(read, best, options.tuning_views, pairs)
    tuned = tune(data, training, options.settings, runner, options.levels, progress)
    bench = Bench(
        root=data.root,
        out=Path(out),
        references=references,
        models=models,
        tree=tree,
        preset=options.preset,
        device=options.device,
        tuned=tuned,
        settings=options.settings,
        whole=options.whole,
    )
    sums = {label: checksum(path) for label, path in models.items()}
    tasks = [ViewTask.of(bench, item, best.get(item), sums) for item in items]
    records, failed = _measured(tasks, runner, progress)
    if not records:
        raise InputError(data.root, f"no view could be measured ({failed[0]})", "views that can be drawn")
    return Outcome(bench, records, read, options.baseline, failed, options.seed)


def _tuned_on(pairs: Sequence[Pair], best: Mapping[Item, int], most: int | None, path: str | Path) -> dict[Item, int]:
    """Training views, with the drawings that voters chose."""
    items = sorted({pair.item for pair in pairs if pair.split == "train"})
    if not items:
        raise InputError(path, f"{len(pairs)} pairs, none to tune baselines on", 'pairs with "split": "train"')
    step = 1 if most is None else max(1, len(items) // most)
    return {item: best[item] for item in items[::step][:most]}


def _measured(tasks: Sequence[ViewTask], runner: Runner, progress: Progress) -> tuple[list[dict[str, Any]], list[str]]:
    """The records of the views, in their order, and one line for each view that couldn't be measured."""
    records = {task.item: record for task in tasks if (record := task.done()) is not None}
    failed: dict[Item, str] = {}
    with progress("Views", len(tasks)) as advance:
        for item in records:
            advance(item.name)
        for outcome in runner.run(measure_view, [task for task in tasks if task.item not in records], LIMITS):
            item = outcome.task.item
            if outcome.result is None:
                failed[item] = f"{item.name}: {outcome.reason}"
            else:
                records[item] = outcome.result
            advance(item.name)
    order = [task.item for task in tasks]
    return [records[item] for item in order if item in records], [failed[item] for item in order if item in failed]
