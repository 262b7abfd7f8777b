"""The demo's page: methods beside simulated artists on held-out shapes, and all that led there."""

import json
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from dataset_tools.simulation.artists import ArtistDrawings, crowd_artists
from dataset_tools.votes.consensus import Rules, aggregate
from dataset_tools.votes.votes import read_votes
from eval.comparison import tables
from eval.demo.pipeline import Plan
from eval.demo.stages import Stage, StageRun
from eval.measures.comparison import Comparison, comparison_table, comparison_text, difference_table
from eval.measures.evaluation import Settings
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.files import write_text
from ncmodel.images import from_brightness as grey
from ncmodel.images import from_ink, read_grey
from ncmodel.report.contact_sheet import Tile
from ncmodel.report.html import Block, Cell, Facts, Fold, Grid, Section, Table, Text, write_report
from ncmodel.report.plots import Axis, Plot, Series, line_plot

TRAINED, SHIPPED = "model", "default"
"""The labels of the two models: the one that the demo trains, and the one that comes with the package."""

THUMB = 208
SIMULATED = (
    "All votes, artists and participants on this page are simulated: programs that follow a written rule with noise. "
    "They show that the pipeline works and how its parts compare; they say nothing about what people prefer."
)
SMOKE = (
    "This is a smoke test. It shows that every part works. It can't show which method is better: a model that learnt "
    "from so few views isn't one to judge, and over so few shapes an interval says little."
)


@dataclass(frozen=True)
class Outcome:
    """What the demo found on held-out shapes.

    Attributes:
        comparison: Every method against the simulated artists.
        scores: The same, view by view.
        record: The content of compare.json.
        folder: Where the comparison lies.
    """

    comparison: Comparison
    scores: pd.DataFrame
    record: dict[str, Any]
    folder: Path

    @staticmethod
    def read(folder: Path) -> "Outcome":
        """What `ncontours compare` wrote."""
        record = json.loads((folder / "compare.json").read_text(encoding="utf-8"))
        scores = pd.read_csv(folder / "tables" / "scores.csv", dtype=tables.SCORES)
        settings = Settings(**{key: record["settings"][key] for key in asdict(Settings())})
        return Outcome(tables.comparison_of(scores, settings, record["settings"]["seed"]), scores, record, folder)

    @property
    def methods(self) -> list[str]:
        """The rows that draw, in the table's order."""
        return [row for row in self.comparison.evaluations if not tables.is_oracle(row)]

    @property
    def pair_accuracy(self) -> dict[str, Any] | None:
        """How the trained model orders held-out pairs; None where voters agreed on no held-out view."""
        found: dict[str, Any] | None = self.record["rankers"][TRAINED]["accuracy"]
        return found


def write_demo_report(out: Path, plan: Plan, stages: Sequence[tuple[Stage, StageRun]]) -> dict[str, Any]:
    """Write `out`/report.html and `out`/summary.json, and return the summary."""
    begin = time.perf_counter()
    outcome = Outcome.read(out / "comparison")
    summary = _summary(out, plan, outcome, stages)
    sections = [
        Section("Result", _result(outcome, summary)),
        Section("Held-out shapes", _held_out(out, outcome)),
        Section("Candidates and votes", _votes(out, summary["held_out"])),
        Section("Training", _curves(out)),
    ]
    seconds = time.perf_counter() - begin
    summary["seconds"]["report"] = round(seconds, 1)
    summary["total_seconds"] = round(sum(summary["seconds"].values()), 1)
    sections.append(Section("Stages", _stages(stages, seconds)))
    write_report(out / "report.html", "Neural Contours: the whole pipeline", sections, _lead(summary))
    write_text(out / "summary.json", json.dumps(summary, indent=1) + "\n")
    return summary


def _summary(out: Path, plan: Plan, outcome: Outcome, stages: Sequence[tuple[Stage, StageRun]]) -> dict[str, Any]:
    comparison = outcome.comparison
    votes = aggregate(read_votes(out / "votes.csv"), Rules()).summary()
    items = DataFolder(out / "data").items()
    return {
        "participants": "simulated",
        "smoke_test": plan.smoke,
        "report": str(out / "report.html"),
        "shapes": len({item.shape for item in items}),
        "views": len(items),
        "held_out": sorted(dict.fromkeys(comparison.shapes)),
        "votes": votes,
        "pair_accuracy": outcome.pair_accuracy,
        "methods": {method: asdict(comparison.mean(method)) for method in comparison.evaluations},
        "table": comparison_text(comparison),
        "verdicts": outcome.record["verdicts"],
        "seconds": {stage.name: round(measured.seconds, 1) for stage, measured in stages},
    }


def summary_text(summary: dict[str, Any]) -> str:
    """The summary for a terminal."""
    return "\n".join(
        [
            f"{summary['shapes']} shapes, {summary['views']} views; held out: {', '.join(summary['held_out'])}",
            f"Held-out pairs in the right order: {_order(summary['pair_accuracy'])}",
            "Held-out drawings against simulated artists (* best):",
            summary["table"],
            *([SMOKE] if summary["smoke_test"] else summary["verdicts"]),
            f"All participants are simulated. {summary['total_seconds']:.0f} s in all. Report: {summary['report']}",
        ]
    )


def _order(accuracy: dict[str, Any] | None) -> str:
    """How many pairs the trained model orders rightly, of how many."""
    if accuracy is None:
        return "there are none: voters agreed on no held-out view"
    share = f"{100 * accuracy['accuracy']:.1f} %"
    if accuracy["shapes"] > 1:
        low, high = (100 * accuracy["bootstrap"][end] for end in ("low", "high"))
        share += f" ({low:.1f} to {high:.1f})"
    return f"{share}, {accuracy['pairs']} pairs, {accuracy['shapes']} shapes"


def _lead(summary: dict[str, Any]) -> str:
    return (
        f"From mesh files to an evaluated model: {summary['shapes']} shapes, two views each, 264 candidate drawings a "
        f"view of which 8 were voted on, a model ({TRAINED}) trained on the votes, and its drawings of "
        f"{len(summary['held_out'])} shapes that no model has seen: real ones, which pymeshlab's package bundles, and "
        f"made ones of families that nothing is trained on. Beside it the model that ships ({SHIPPED}) and the classic "
        "lines."
    )


def _result(outcome: Outcome, summary: dict[str, Any]) -> list[Block]:
    votes, comparison = summary["votes"], outcome.comparison
    facts = [
        ("Held-out pairs that the trained model orders rightly", f"{_order(summary['pair_accuracy'])}; chance is 50 %"),
        ("Simulated participants", f"{votes['participants']}, of whom {votes['reliable']} reliable by the sentinels"),
        ("Items with a consensus", f"{votes['accepted']} of {votes['items']}"),
    ]
    caption = (
        "Held-out drawings against those of the simulated artists, silhouettes removed; 95 % intervals over resampled "
        "shapes. Percentages; CD is the Chamfer distance in pixels. Bold: best. Rows of the model trained here end in "
        f"@{TRAINED}, those of the one that ships in @{SHIPPED}; “Best of” rows are no methods, they choose by the "
        "artists' drawings."
    )
    said = [SMOKE] if summary["smoke_test"] else summary["verdicts"]
    tuned = outcome.record["tuned"]
    return [
        Text(SIMULATED, "warning"),
        *(Text(sentence, "warning" if summary["smoke_test"] else "plain") for sentence in said),
        Facts(facts),
        comparison_table(comparison, caption),
        Text(
            f"Thresholds with the least Chamfer distance on {tuned['views']} training views. {_tuned(tuned)}.", "note"
        ),
        *(difference_table(comparison, row, "f1", "Paired by drawing.") for row in _shown(outcome)),
    ]


def _shown(outcome: Outcome) -> list[str]:
    """The rows whose differences are shown: each model's geometry branch."""
    wanted = [f"NC-geometry@{label}" for label in (TRAINED, SHIPPED)]
    return [row for row in wanted if row in outcome.comparison.evaluations]


def _tuned(tuned: dict[str, Any]) -> str:
    return "; ".join(
        f"{method}: " + ", ".join(f"{family} {value:.2f}" for family, value in plan["thresholds"].items())
        for method, plan in tuned["plans"].items()
    )


def _held_out(out: Path, outcome: Outcome) -> list[Block]:
    blocks: list[Block] = []
    data = DataFolder(out / "data")
    artists = ArtistDrawings(data, crowd_artists())
    f1 = tables.views_frame(outcome.scores)
    for name in f1.index:
        item, of_view = Item(*name), f1.loc[name]
        best = max(of_view[method] for method in outcome.methods)
        tiles = [Tile(grey(read_grey(data.own_render(item))), "shape")]
        tiles += [Tile(from_ink(_ink(artists.paths(item)[0])), "a simulated artist")]
        tiles += [
            Tile(
                from_ink(_ink(outcome.folder / "drawings" / method / f"{item.name}.png")),
                f"{method}  F1 {100 * of_view[method]:.0f}",
                highlight=of_view[method] == best,
            )
            for method in reversed(outcome.methods)
        ]
        blocks.append(Grid(tiles, item.name, columns=5, max_side=384))
    return blocks


def _ink(path: Path) -> Any:
    return 1.0 - read_grey(path)


def _votes(out: Path, held_out: Sequence[str]) -> list[Block]:
    everything, data = read_votes(out / "votes.csv"), DataFolder(out / "data")
    votes = everything[~everything["sentinel"]]
    counts = Counter(zip(votes["shape"], votes["view"], votes["choice"], strict=True))
    first: list[Grid] = []
    rest: list[Grid] = []
    for item in data.items():
        (first if item.shape in held_out else rest).append(_candidates(data, item, counts))
    note = Text("Votes of simulated participants; those who failed a sentinel are counted here too.", "note")
    return [note, *first, Fold(f"The other {len(rest)} views", rest)]


def _candidates(data: DataFolder, item: Item, counts: Counter[tuple[str, str, int]]) -> Grid:
    none, *votes = (counts[item.shape, item.view, choice] for choice in range(-1, DRAWINGS))
    tiles = [Tile(grey(read_grey(data.own_render(item))), "shape")]
    for path, count in zip(data.drawing_paths(item), votes, strict=True):
        ink = from_ink(_ink(path))
        tiles.append(Tile(ink, f"{count} vote{'s' if count != 1 else ''}", highlight=0 < count == max(votes)))
    return Grid(tiles, f"{item.name}{f' ({none} x none of these)' if none else ''}", columns=9, max_side=THUMB)


def _curves(out: Path) -> list[Block]:
    history = json.loads((out / "model.safetensors.history.json").read_text(encoding="utf-8"))
    blocks: list[Block] = []
    for stage, records in history.items():
        blocks += _stage_plots(stage, records)
    return blocks


def _stage_plots(stage: str, records: Sequence[dict[str, Any]]) -> list[Plot]:
    epochs = [record["epoch"] for record in records]
    measures = sorted({key for record in records for key, value in record.items() if isinstance(value, float)})
    losses = [key for key in measures if "accuracy" not in key and "seconds" not in key]
    shares = [key for key in measures if "accuracy" in key]
    plots = []
    for keys, label in ((losses, "loss"), (shares, "share of pairs in the right order")):
        if keys:
            series = [Series(key, epochs, [record[key] for record in records], style="line+points") for key in keys]
            plots.append(line_plot(series, Axis("pass over the training data"), Axis(label), f"{stage}: {label}"))
    return plots


def _stages(stages: Sequence[tuple[Stage, StageRun]], report_seconds: float) -> list[Block]:
    rows: list[Sequence[Cell | str]] = [
        [
            stage.title,
            Cell(f"{measured.seconds:.1f}", measured.seconds),
            Cell(f"{measured.peak_bytes / 2**20:.0f}", measured.peak_bytes),
            stage.command or "",
            measured.note,
        ]
        for stage, measured in stages
    ]
    rows.append(["Evaluate and write this page", Cell(f"{report_seconds:.1f}", report_seconds), "", "", ""])
    caption = "Seconds by the clock, the start of the process included; memory of the largest process of the stage."
    return [Table(["Stage", "Seconds", "MiB", "Command", "Note"], rows, caption)]
