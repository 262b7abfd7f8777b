"""One view: drawn by all methods, measured, and kept in a file, so that an interrupted comparison goes on.

Under REPORT/views lies a file for each view that is done, under REPORT/drawings what was drawn of it.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Any

from eval.baselines.decision_tree import Tree
from eval.comparison import candidates as oracle
from eval.comparison.candidates import BEST_OF_8, BEST_OF_ALL, CHOSEN, FAVOURITE, Judged, rank_correlation
from eval.comparison.methods import Drawn, classic_methods, learned_methods, row_name
from eval.comparison.opinions import WHOLE, Opinion, opinions, settings_of
from eval.comparison.tuning import Tuned
from eval.comparison.views import References, open_as_drawn, target_of
from eval.measures.evaluation import Score, Settings
from eval.measures.references import most_consistent
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.drawing.plan import Plan
from ncmodel.drawing.settings import Levels, draw_layers
from ncmodel.files import write_bytes, write_text
from ncmodel.images import png_ink
from ncmodel.model.maps import network_maps
from ncmodel.model.predictor import Model, load_model

VERSION = 2
"""Of what a view's file holds. What was measured by other versions is measured again."""


@dataclass(frozen=True)
class Bench:
    """What all views are measured with.

    Attributes:
        root: The data folder.
        out: REPORT.
        references: What drawings are judged by.
        models: Label -> checkpoint.
        tree: A trained decision tree, if there is one.
        preset: Of the models' search.
        device: Where the models compute; measures don't depend on it by more than rounding.
        tuned: The parameters of the tuned baselines.
        settings: How drawings are compared; the tolerance is in pixels of pictures 768 wide.
        whole: Keep silhouettes.
    """

    root: Path
    out: Path
    references: References
    models: Mapping[str, Path]
    tree: Tree | None
    preset: str
    device: str
    tuned: Tuned
    settings: Settings
    whole: bool

    def record_path(self, item: Item) -> Path:
        """Where the measures of a view lie."""
        return self.out / "views" / f"{item.name}.json"

    def drawing_path(self, row: str, item: Item) -> Path:
        """Where a method's drawing of a view lies."""
        return self.out / "drawings" / row.replace(" ", "-") / f"{item.name}.png"


@dataclass(frozen=True)
class ViewTask:
    """One view to measure.

    Attributes:
        bench: What with.
        item: The view.
        chosen: The drawing that voters chose, if they agreed.
        identity: Tells the outcome from that of other settings.
    """

    bench: Bench
    item: Item
    chosen: int | None
    identity: str

    @staticmethod
    def of(bench: Bench, item: Item, chosen: int | None, checksums: Mapping[str, str]) -> "ViewTask":
        """The task, with its identity.

        Args:
            bench: What with.
            item: The view.
            chosen: The drawing that voters chose, if they agreed.
            checksums: Label -> checksum of the checkpoint.
        """
        data = DataFolder(bench.root)
        parts = {
            "version": VERSION,
            "models": dict(checksums),
            "preset": bench.preset,
            "tuned": bench.tuned.to_record(),
            "settings": [asdict(bench.settings), bench.whole],
            "references": bench.references.identity(item),
            "chosen": chosen,
            "view": [
                checksum(path)
                for path in (data.mesh_path(item.shape), data.camera_path(item), data.selection_path(item))
            ],
        }
        if bench.tree is not None:
            parts["tree"] = asdict(bench.tree)
        return ViewTask(bench, item, chosen, _hash(json.dumps(parts, sort_keys=True).encode()))

    def done(self) -> dict[str, Any] | None:
        """The record of a view that has been measured with the same settings."""
        path = self.bench.record_path(self.item)
        if not path.is_file():
            return None
        record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return record if record["identity"] == self.identity else None


def checksum(path: Path) -> str:
    """Tells a file's content from others."""
    return _hash(path.read_bytes())


def _hash(content: bytes) -> str:
    return blake2b(content, digest_size=8).hexdigest()


def measure_view(task: ViewTask) -> dict[str, Any]:
    """Draw, measure, and write the view's files; returns its record.

    The record holds `scores`, a row for each method and reference; `consistent`, the reference nearest to the others;
    `choices`, what models decided; `candidates`, F1 of
    the 256; and `rankers`, what models say of the eight and of the 256, by all they go by and by pictures alone.
    """
    bench, item = task.bench, task.item
    data, models = DataFolder(bench.root), models_of(tuple(bench.models.items()), bench.device)
    view = open_as_drawn(data, item)
    references = bench.references.of(item)
    target = target_of(view, item.name, references, bench.settings, bench.whole)
    scores: dict[str, tuple[Score, ...]] = {}
    choices: dict[str, dict[str, Any]] = {}

    def keep(row: str, drawn: Drawn, found: tuple[Score, ...] | None = None) -> None:
        scores[row] = target.scores(target.prepare(drawn.ink)) if found is None else found
        path = bench.drawing_path(row, item)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, drawn.png)

    for method in [*classic_methods(bench.tuned, bench.tree), *learned_methods(models, bench.preset)]:
        drawn = method.draw(view)
        keep(method.name, drawn)
        if drawn.plan is not None and drawn.plan.score is not None:
            choices[method.name] = _choice(drawn.plan)
    selected = oracle.judge_selected(data, item, target)
    settings = draw_layers(view, Levels())
    everything = oracle.judge_candidates(settings, target)
    wanted = [(BEST_OF_8, selected, selected.best), (BEST_OF_ALL, everything, everything.best)]
    if task.chosen is not None:
        wanted.append((CHOSEN, selected, task.chosen))
    rankers: dict[str, dict[str, Any]] = {}
    eight = [selected.drawing(number) for number in range(len(selected.scores))]
    for label, model in models.items():
        preset = model.checkpoint.preset
        seen = network_maps(view, preset.inputs, preset.percentile)
        for by, said in opinions(model, seen, eight, settings_of(data, item), settings).items():
            name = " ".join(part for part in (label, by) if part)
            rankers[name] = _ranked(said, everything)
            if by == WHOLE:
                wanted.append((row_name(FAVOURITE, label), everything, rankers[name]["favourite"]))
    for row, among, number in wanted:
        keep(row, among.drawn(number), among.scores[number])
    for number, ink in enumerate(references.values()):
        path = bench.out / "references" / item.name / f"{number}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, png_ink(ink))
    record = {
        "identity": task.identity,
        "shape": item.shape,
        "view": item.view,
        "consistent": list(target.references)[most_consistent(list(target.references.values()))],
        "scores": [
            {"method": row, "reference": score.reference, **asdict(score.measures)}
            for row, found in scores.items()
            for score in found
        ],
        "choices": choices,
        "candidates": {"f1": everything.f1.tolist(), "best": everything.best},
        "rankers": rankers,
    }
    bench.record_path(item).parent.mkdir(parents=True, exist_ok=True)
    write_text(bench.record_path(item), json.dumps(record, allow_nan=False) + "\n")
    return record


@cache
def models_of(checkpoints: tuple[tuple[str, Path], ...], device: str) -> dict[str, Model]:
    """The models, read once a process."""
    return {label: load_model(path, device) for label, path in checkpoints}


def _choice(plan: Plan) -> dict[str, Any]:
    """What a model decided."""
    families = [family.value for family in plan.drawn]
    return {"families": families, "thresholds": plan.filtered, "score": plan.score, "evaluations": plan.evaluations}


def _ranked(said: Opinion, everything: Judged) -> dict[str, Any]:
    """What a view's record keeps of an opinion."""
    return {
        "scores": list(said.selected),
        "favourite": int(said.candidates.argmax()),
        "rank_correlation": rank_correlation(said.candidates, everything.f1),
    }
