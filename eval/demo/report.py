"""The demo's last stage: methods against simulated artists on held-out shapes, and everything as one page."""

import json
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from dataset_tools.votes.consensus import Rules, aggregate
from dataset_tools.votes.votes import read_votes
from eval.demo.stages import Stage, StageRun
from eval.measures.bootstrap import PairAccuracy
from eval.measures.comparison import Comparison, compare, comparison_table, comparison_text, difference_table
from eval.measures.evaluation import Settings
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.files import write_text
from ncmodel.images import from_brightness as grey
from ncmodel.images import from_ink, read_grey
from ncmodel.report.contact_sheet import Tile
from ncmodel.report.html import Block, Cell, Facts, Fold, Grid, Section, Table, Text, write_report
from ncmodel.report.plots import Axis, Plot, Series, line_plot

DEFAULTS = ("SC-rtsc", "RV-rtsc", "AR-rtsc", "all-rtsc")
TUNED = ("SC-grid", "RV-grid", "AR-grid", "all-grid")
FIXED = DEFAULTS + TUNED
"""The rows whose thresholds are the same for every shape: rtsc's, and those that suit training views best."""
METHODS = ("contours", *FIXED, "Canny", "NC-geometry", "NC-image", "NCs")

REFERENCE_WIDTH = 768
"""The tolerance below is in pixels of a drawing this wide."""
TOLERANCE = 5.0

THUMB = 208
SIMULATED = (
    "All votes, artists and participants on this page are simulated: programs that follow a written rule with noise. "
    "They show that the pipeline works and how its parts compare; they say nothing about what people prefer."
)


@dataclass(frozen=True)
class Outcome:
    """What the demo found on held-out shapes.

    Attributes:
        comparison: Every method against the simulated artists.
        accuracy: Of the ranking module on held-out pairs; None where voters agreed on no held-out view.
        model: What the model chose on each held-out view, as `draw_held_out` wrote it.
    """

    comparison: Comparison
    accuracy: PairAccuracy | None
    model: dict[str, Any]


def judge(out: Path) -> Outcome:
    """Measure the held-out drawings that lie in `out`/held-out."""
    held_out = out / "held-out"
    names = sorted(path.name for path in (held_out / "references").iterdir())
    references = {
        name: [_ink(path) for path in sorted((held_out / "references" / name).glob("*.png"))] for name in names
    }
    methods = {method: {name: _ink(held_out / method / f"{name}.png") for name in names} for method in METHODS}
    silhouettes = {name: _ink(held_out / "silhouettes" / f"{name}.png") > 0.5 for name in names}
    side = next(iter(references.values()))[0].shape[1]
    settings = Settings(tolerance_pixels=TOLERANCE * side / REFERENCE_WIDTH)
    model = json.loads((held_out / "model.json").read_text(encoding="utf-8"))
    accuracy = _pair_accuracy(model["pairs"])
    return Outcome(compare(methods, references, settings, silhouettes), accuracy, model)


def _ink(path: Path) -> Any:
    return 1.0 - read_grey(path)


def _pair_accuracy(pairs: Sequence[dict[str, Any]]) -> PairAccuracy | None:
    if not pairs:
        return None
    from eval.measures.bootstrap import pair_accuracy

    better, worse = ([pair[key] for pair in pairs] for key in ("better_score", "worse_score"))
    return pair_accuracy(better, worse, [pair["shape"] for pair in pairs])


def write_demo_report(out: Path, stages: Sequence[tuple[Stage, StageRun]]) -> dict[str, Any]:
    """Judge, write `out`/report.html and `out`/summary.json, and return the summary."""
    begin = time.perf_counter()
    outcome = judge(out)
    summary = _summary(out, outcome, stages)
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


def _summary(out: Path, outcome: Outcome, stages: Sequence[tuple[Stage, StageRun]]) -> dict[str, Any]:
    comparison = outcome.comparison
    votes = aggregate(read_votes(out / "votes.csv"), Rules()).summary()
    items = DataFolder(out / "data").items()
    return {
        "participants": "simulated",
        "report": str(out / "report.html"),
        "shapes": len({item.shape for item in items}),
        "views": len(items),
        "held_out": sorted(dict.fromkeys(comparison.shapes)),
        "votes": votes,
        "pair_accuracy": None if outcome.accuracy is None else asdict(outcome.accuracy),
        "methods": {method: asdict(comparison.mean(method)) for method in comparison.evaluations},
        "table": comparison_text(comparison),
        "nc_geometry_minus_fixed_f1": {
            method: asdict(comparison.difference("NC-geometry", method)) for method in FIXED
        },
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
            f"All participants are simulated. {summary['total_seconds']:.0f} s in all. Report: {summary['report']}",
        ]
    )


def _order(accuracy: dict[str, Any] | None) -> str:
    """How many pairs the ranking module orders rightly, of how many."""
    if accuracy is None:
        return "there are none: voters agreed on no held-out view"
    low, high = (100 * accuracy["bootstrap"][end] for end in ("low", "high"))
    share = f"{100 * accuracy['accuracy']:.1f} % ({low:.1f} to {high:.1f}"
    return f"{share}, {accuracy['pairs']} pairs of {accuracy['shapes']} shapes)"


def _lead(summary: dict[str, Any]) -> str:
    return (
        f"From mesh files to an evaluated model: {summary['shapes']} shapes (those that pymeshlab's package bundles, "
        "and shapes made in code), two views each, 264 candidate drawings a view of which 8 were voted on, a model "
        f"trained on the votes, and its drawings of {len(summary['held_out'])} shapes that it never saw, beside the "
        "classic lines."
    )


def _result(outcome: Outcome, summary: dict[str, Any]) -> list[Block]:
    votes, order = summary["votes"], _order(summary["pair_accuracy"])
    chosen = outcome.model["views"].values()
    facts = [
        ("Held-out pairs that the ranking module orders rightly", f"{order}; chance is 50 %"),
        ("Simulated participants", f"{votes['participants']}, of whom {votes['reliable']} reliable by the sentinels"),
        ("Items with a consensus", f"{votes['accepted']} of {votes['items']}"),
        (
            "Score evaluations a view, in the search for thresholds",
            _mean(view["evaluations"] for view in chosen),
        ),
        ("Seconds a view, drawing included", _mean(view["seconds"] for view in chosen)),
    ]
    caption = (
        "Held-out drawings against those of the simulated artists, silhouettes removed; 95 % intervals over resampled "
        "shapes. Percentages; CD is the Chamfer distance in pixels. Bold: best."
    )
    return [
        Text(SIMULATED, "warning"),
        Facts(facts),
        comparison_table(outcome.comparison, caption),
        Text(
            f"Thresholds with the least Chamfer distance on training views. {_tuned(outcome.model['tuned'])}.", "note"
        ),
        difference_table(outcome.comparison, "NC-geometry", "f1", "Paired by drawing."),
    ]


def _tuned(methods: dict[str, dict[str, float]]) -> str:
    return "; ".join(
        f"{method}: " + ", ".join(f"{family} {value:.2f}" for family, value in thresholds.items())
        for method, thresholds in methods.items()
    )


def _mean(values: Any) -> str:
    numbers = list(values)
    return f"{sum(numbers) / len(numbers):.1f}"


def _held_out(out: Path, outcome: Outcome) -> list[Block]:
    blocks: list[Block] = []
    data, folder = DataFolder(out / "data"), out / "held-out"
    for name, view in sorted(outcome.model["views"].items()):
        scores = {method: _f1(outcome.comparison, method, name) for method in METHODS}
        best = max(scores.values())
        tiles = [Tile(grey(read_grey(data.own_render(Item.named(name)))), "shape")]
        tiles += [Tile(from_ink(_ink(folder / "references" / name / "0.png")), "a simulated artist")]
        tiles += [
            Tile(
                from_ink(_ink(folder / method / f"{name}.png")),
                f"{method}  F1 {100 * score:.0f}",
                highlight=score == best,
            )
            for method, score in reversed(scores.items())
        ]
        blocks.append(Grid(tiles, f"{name}: {_choice(view)}", columns=5, max_side=384))
    return blocks


def _choice(view: dict[str, Any]) -> str:
    parts = [
        f"{family} {round(value, 3):g}" if value is not None else f"no {family}"
        for family, value in view["thresholds"].items()
    ]
    return f"with both branches, the model chose {', '.join(parts)}"


def _f1(comparison: Comparison, method: str, name: str) -> float:
    from eval.measures.metrics import mean_measures

    scores = [score.measures for score in comparison.evaluations[method].scores if score.name == name]
    return mean_measures(scores).f1


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
