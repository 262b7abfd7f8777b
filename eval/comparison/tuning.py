"""Thresholds and parameters that suit training views best: what the -grid rows and Canny are drawn with.

The references are the drawings that voters chose, as in the paper; nothing of what methods are evaluated on is seen.
What was found is kept in the data folder, where other comparisons find it; a search that was interrupted goes on.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset_tools.build.runners import Runner
from eval.baselines import canny, grid
from eval.comparison.views import open_as_drawn, target_of
from eval.measures.evaluation import Settings
from eval.measures.thinning import read_ink
from ncmodel.chamfer import STEPS
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.drawing.plan import Plan
from ncmodel.errors import InputError
from ncmodel.files import atomic, write_text
from ncmodel.limits import Limits
from ncmodel.progress import Progress, silent
from ncmodel.types import LineFamily, Thresholds

LIMITS = Limits(seconds=1800.0, memory_gb=24.0)
"""Of one view. Networks reserve far more address space than they use."""

SAVE_EVERY = 8
"""Views after which sums are kept, so that not all is lost when a search is interrupted."""

Sums = NDArray[np.int64]


@dataclass(frozen=True)
class Tuned:
    """What suits training views best.

    Attributes:
        plans: The appendix's four -grid methods by name.
        canny: The edge detector's parameters.
        views: How many training views it was found on.
    """

    plans: Mapping[str, Plan]
    canny: canny.CannySettings
    views: int

    def to_record(self) -> dict[str, Any]:
        """JSON-ready values."""
        plans = {
            name: {"families": [family.value for family in plan.families], "thresholds": plan.filtered}
            for name, plan in self.plans.items()
        }
        return {"plans": plans, "canny": asdict(self.canny), "views": self.views}

    @staticmethod
    def from_record(record: Mapping[str, Any]) -> "Tuned":
        """What `to_record` gave."""
        plans = {
            name: Plan(
                tuple(LineFamily(family) for family in plan["families"]),
                Thresholds(None, None, None, None).with_values(**plan["thresholds"]),
            )
            for name, plan in record["plans"].items()
        }
        return Tuned(plans, canny.CannySettings(**record["canny"]), record["views"])


@dataclass(frozen=True)
class Example:
    """A training view and the drawing that voters chose.

    Attributes:
        root: The data folder.
        item: The view.
        chosen: Which of its eight drawings.
        settings: How drawings are compared.
        levels: Thresholds tried per kind of line.
    """

    root: Path
    item: Item
    chosen: int
    settings: Settings
    levels: int

    @property
    def reference(self) -> Path:
        """The picture of the drawing that voters chose."""
        return DataFolder(self.root).drawing_path(self.item, self.chosen)


def tune(
    data: DataFolder,
    best: Mapping[Item, int],
    settings: Settings,
    runner: Runner,
    levels: int = grid.THRESHOLDS,
    progress: Progress = silent,
) -> Tuned:
    """Find the parameters with the least mean Chamfer distance to the chosen drawings of training views.

    Args:
        data: The data folder; what is found is kept in its folder `tuned`.
        best: Training view -> the drawing that voters chose; at least one.
        settings: How drawings are compared.
        runner: Works off the views.
        levels: Thresholds tried per kind of line.
        progress: Is told about every view.

    Raises:
        InputError: A view can't be read, or takes too long.
    """
    examples = [Example(data.root, item, chosen, settings, levels) for item, chosen in sorted(best.items())]
    kept = data.root / "tuned" / f"{_identity(examples)}.json"
    if kept.is_file():
        return Tuned.from_record(json.loads(kept.read_text(encoding="utf-8")))
    kept.parent.mkdir(parents=True, exist_ok=True)
    tuned = _best(_summed(examples, kept.with_suffix(".npz"), runner, progress), levels, len(examples))
    write_text(kept, json.dumps(tuned.to_record(), indent=1) + "\n")
    kept.with_suffix(".npz").unlink()
    return tuned


def example_costs(example: Example) -> tuple[Sums, Sums]:
    """Chamfer distances of all combinations of thresholds and of all of Canny's parameters, in whole steps."""
    view = open_as_drawn(DataFolder(example.root), example.item)
    reference = {"chosen": read_ink(example.reference)}
    target = target_of(view, example.item.name, reference, example.settings, whole=False)
    tried = np.linspace(0.0, 1.0, example.levels).tolist()
    found = grid.example_costs(view, target, tried), canny.example_costs(view, target)
    lines, edges = (np.rint(costs * STEPS).astype(np.int64) for costs in found)
    return lines, edges


def _summed(examples: Sequence[Example], partial: Path, runner: Runner, progress: Progress) -> tuple[Sums, Sums]:
    """The costs of all examples added up. Sums of whole numbers don't depend on who was ready first."""
    done, lines, edges = _read_partial(partial, examples[0].levels)
    left = [example for example in examples if example.item.name not in done]
    with progress("Baselines' parameters: training views", len(examples)) as advance:
        for name in done:
            advance(name)
        for outcome in runner.run(example_costs, left, LIMITS):
            name = outcome.task.item.name
            if outcome.result is None:
                folder = DataFolder(outcome.task.root).view_folder(outcome.task.item)
                raise InputError(folder, outcome.reason, "a view that lines can be drawn of")
            lines, edges = lines + outcome.result[0], edges + outcome.result[1]
            done.append(name)
            if len(done) % SAVE_EVERY == 0 or len(done) == len(examples):
                with atomic(partial) as aside:
                    np.savez(aside, done=np.array(done), lines=lines, edges=edges)
            advance(name)
    return lines, edges


def _read_partial(path: Path, levels: int) -> tuple[list[str], Sums, Sums]:
    """The views that are done, and their sums so far."""
    if not path.is_file():
        return [], np.zeros((levels + 1,) * 3, np.int64), np.zeros(len(canny.GRID), np.int64)
    with np.load(path) as kept:
        return kept["done"].tolist(), kept["lines"], kept["edges"]


def _best(sums: tuple[Sums, Sums], levels: int, views: int) -> Tuned:
    lines, edges = (total / (STEPS * views) for total in sums)
    found = grid.Search(tuple(np.linspace(0.0, 1.0, levels).tolist()), lines)
    return Tuned(found.methods, canny.GRID[int(np.argmin(edges))], views)


def _identity(examples: Sequence[Example]) -> str:
    """Tells this search from others: by the chosen drawings, the views, and how they are compared."""
    digest = blake2b(f"{examples[0].settings} {examples[0].levels}".encode(), digest_size=8)
    data = DataFolder(examples[0].root)
    for example in examples:
        try:
            content = example.reference.read_bytes() + data.camera_path(example.item).read_bytes()
        except OSError as error:
            raise InputError(example.reference, f"can't be read ({error.strerror})", "a finished view") from error
        digest.update(f"{example.item.name} {example.chosen}".encode() + content)
    return digest.hexdigest()
