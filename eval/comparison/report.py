"""A comparison as files: a page, tables for programs and papers, compare.json."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import pandas as pd

from eval.comparison import tables
from eval.comparison.candidates import BEST_OF_ALL, CHOSEN
from eval.comparison.measuring import Bench
from eval.comparison.paper_tables import NOTE, TABLES, PaperTable, consistent, paper_frame, paper_latex, paper_table
from eval.comparison.rankers import RankerReport, judge_rankers
from eval.measures.comparison import Comparison, comparison_table, comparison_text
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair
from ncmodel.files import write_text
from ncmodel.images import from_brightness, read_grey
from ncmodel.report.contact_sheet import Tile
from ncmodel.report.html import Block, Cell, Facts, Fold, Grid, Section, Table, Text, write_report
from ncmodel.report.plots import Axis, Plot, Series, line_plot

SHOWN_FAILURES = 12
"""Views whose pictures are shown at once; the others fold away."""
PICTURE_SIDE = 320
"""Longest side of the pictures, pixels."""

SIMULATED = (
    "The references are simulated: programs that follow a written rule with noise drew them. They show how methods "
    "compare under that rule, not what people prefer."
)


@dataclass(frozen=True)
class Outcome:
    """All that a comparison found.

    Attributes:
        bench: What views were measured with.
        records: Of the views that could be measured, as `measure_view` wrote them.
        pairs: Ranking pairs.
        baseline: The row that others are compared with.
        failed: One line for each view that couldn't be measured.
        seed: Of the resampling.
    """

    bench: Bench
    records: Sequence[Mapping[str, Any]]
    pairs: Sequence[Pair]
    baseline: str
    failed: Sequence[str] = ()
    seed: int = 0

    @cached_property
    def scores(self) -> pd.DataFrame:
        """Every method's measures on every view, against every reference."""
        return tables.scores_frame(self.records)

    @cached_property
    def comparison(self) -> Comparison:
        """The methods beside each other."""
        return tables.comparison_of(self.scores, self.bench.settings, self.seed)

    @cached_property
    def paper_frames(self) -> list[tuple[PaperTable, pd.DataFrame]]:
        """The paper's tables with our means, of those that we have a row for."""
        nearest = tables.comparison_of(consistent(self.scores, self.records), self.bench.settings, self.seed)
        frames = [(t, paper_frame(nearest if t.most_consistent else self.comparison, t)) for t in TABLES]
        return [(table, frame) for table, frame in frames if frame["f1"].notna().any()]

    @cached_property
    def differences(self) -> pd.DataFrame:
        """Paired differences in F1."""
        return tables.differences_frame(self.comparison, self.baseline)

    @cached_property
    def rankers(self) -> dict[str, RankerReport]:
        """How far each ranking module is a judge."""
        return judge_rankers(self.records, self.pairs)

    @cached_property
    def learned(self) -> list[str]:
        """The rows of models."""
        return tables.learned_rows(list(self.comparison.evaluations))

    @cached_property
    def failures(self) -> dict[str, pd.DataFrame]:
        """Model's row -> the views, the worst first."""
        return {row: tables.failures_frame(self.scores, row, self.baseline) for row in self.learned}

    def to_record(self) -> dict[str, Any]:
        """The content of compare.json."""
        frame = tables.methods_frame(self.comparison).set_index("method")
        measures = [column for column in frame.columns if not column.endswith(("_low", "_high"))]
        methods = {
            str(method): {
                **{measure: row[measure] for measure in measures},
                "interval": {m: {"low": row[f"{m}_low"], "high": row[f"{m}_high"]} for m in measures},
            }
            for method, row in frame.iterrows()
        }
        return {
            "methods": methods,
            "differences": tables.json_rows(self.differences),
            "verdicts": [tables.verdict(self.differences, row) for row in self.learned],
            "way": {row: asdict(tables.way(self.comparison, row, self.baseline)) for row in self.learned},
            "baseline": self.baseline,
            "rankers": {label or "model": report.to_record() for label, report in self.rankers.items()},
            "failures": {row: tables.json_rows(frame) for row, frame in self.failures.items()},
            "tuned": self.bench.tuned.to_record(),
            "references": "simulated" if self.bench.references.simulated else "drawn",
            "views": len(self.records),
            "shapes": len({record["shape"] for record in self.records}),
            "failed": list(self.failed),
            "settings": {
                **asdict(self.bench.settings),
                "silhouettes_removed": not self.bench.whole,
                "preset": self.bench.preset,
                "seed": self.seed,
            },
        }

    def to_text(self) -> str:
        """The table of methods and how modules rank, for a terminal."""
        lines = [comparison_text(self.comparison), *(tables.verdict(self.differences, row) for row in self.learned)]
        for label, report in self.rankers.items():
            lines.append(": ".join([label or "Ranking module", "; ".join(f"{k} {v}" for k, v in _judge(report))]))
        return "\n".join(lines)

    def write(self) -> dict[str, Any]:
        """Write compare.json, report.html and the tables; returns the content of compare.json."""
        out, record = self.bench.out, self.to_record()
        frames = {
            "scores": self.scores,
            "methods": tables.methods_frame(self.comparison),
            "differences": self.differences,
            "views": tables.views_frame(self.scores).reset_index(),
            **{f"failures {row}": frame for row, frame in self.failures.items()},
            **{f"paper {table.name}": frame for table, frame in self.paper_frames},
        }
        (out / "tables").mkdir(parents=True, exist_ok=True)
        for name, frame in frames.items():
            write_text(out / "tables" / f"{name.replace(' ', '-')}.csv", frame.to_csv(index=False, lineterminator="\n"))
        for table, frame in self.paper_frames:
            write_text(out / "tables" / f"paper-{table.name}.tex", paper_latex(frame, table))
        write_text(out / "tables" / "methods.tex", tables.to_latex(self.comparison, self._lead()))
        write_text(out / "compare.json", json.dumps(record, indent=1, allow_nan=False) + "\n")
        write_report(out / "report.html", "Line drawings compared", self._sections(), self._lead())
        return record

    def _lead(self) -> str:
        shapes, labels = len({record["shape"] for record in self.records}), self.scores["reference"].nunique()
        who = "simulated artists" if self.bench.references.simulated else "people"
        return (
            f"{len(self.records)} views of {shapes} shapes against {len(self.scores.drop_duplicates(_REFERENCE))} "
            f"drawings by {who} ({labels} to a view at most), silhouettes {'kept' if self.bench.whole else 'removed'}."
        )

    def _sections(self) -> list[Section]:
        sections = [Section("Methods", self._methods()), Section("The paper's tables", self._paper())]
        if self.rankers:
            sections.append(Section("Ranking modules", self._ranking()))
        sections += [Section(f"Where {row} fails", self._failing(row)) for row in self.learned]
        return sections

    def _methods(self) -> list[Block]:
        blocks: list[Block] = [Text(SIMULATED, "warning")] if self.bench.references.simulated else []
        if self.failed:
            blocks.append(Text(f"{len(self.failed)} views not measured: {'; '.join(self.failed)}", "warning"))
        blocks.append(comparison_table(self.comparison, _CAPTION))
        blocks.append(Text(_TUNED.format(self.bench.tuned.views, _tuned(self.bench.tuned.to_record())), "note"))
        apart = self.differences["against"] == self.baseline
        blocks.append(_difference_table(self.differences[apart]))
        if not apart.all():
            blocks.append(Fold("Models against every other row", [_difference_table(self.differences[~apart])]))
        blocks += [Text(tables.verdict(self.differences, row)) for row in self.learned]
        ways = {row: tables.way(self.comparison, row, self.baseline) for row in self.learned}
        facts = [
            (row, f"{way.value:.0%} ({way.interval.low:.0%} to {way.interval.high:.0%})")
            for row, way in ways.items()
            if way.value is not None and way.interval is not None
        ]
        if facts:
            blocks += [Text(f"The way in F1 from {self.baseline} to the {BEST_OF_ALL}:", "note"), Facts(facts)]
        chosen = tables.agreed(self.scores)
        if len(chosen):
            comparison = tables.comparison_of(chosen, self.bench.settings, self.seed)
            if CHOSEN in comparison.evaluations:
                title = f"The same on the {len(set(_names(chosen)))} views whose voters agreed on a drawing"
                blocks.append(Fold(title, [comparison_table(comparison, _CAPTION)]))
        return blocks

    def _paper(self) -> list[Block]:
        return [Text(NOTE, "note"), *(paper_table(frame, table) for table, frame in self.paper_frames)]

    def _ranking(self) -> list[Block]:
        blocks: list[Block] = []
        for label, report in self.rankers.items():
            blocks.append(Facts([("model", label), *_judge(report)] if label else _judge(report)))
            if report.reliability is not None:
                blocks.append(_diagram(report))
        return blocks

    def _failing(self, row: str) -> list[Block]:
        grids = [self._failure(row, failure) for failure in self.failures[row].to_dict("records")]
        rest = grids[SHOWN_FAILURES:]
        more: list[Block] = [Fold(f"The other {len(rest)} views", rest)] if rest else []
        return [Text(f"Views by how far F1 lies below the {BEST_OF_ALL}, the worst first.", "note"), *grids, *more]

    def _failure(self, row: str, failure: Mapping[Any, Any]) -> Grid:
        item, out = Item(failure["shape"], failure["view"]), self.bench.out
        shown = {
            "reference": out / "references" / item.name / "0.png",
            f"{row}  F1 {100 * failure['f1']:.0f}": self.bench.drawing_path(row, item),
            f"{BEST_OF_ALL}  F1 {100 * failure['best']:.0f}": self.bench.drawing_path(BEST_OF_ALL, item),
            f"{self.baseline}  F1 {100 * failure['baseline']:.0f}": self.bench.drawing_path(self.baseline, item),
        }
        tiles = [
            Tile(from_brightness(read_grey(path)), caption, f"{item.name}: {caption}")
            for caption, path in shown.items()
        ]
        return Grid(tiles, f"{item.name}: {100 * failure['shortfall']:.0f} below", columns=4, max_side=PICTURE_SIDE)


_REFERENCE = ["shape", "view", "reference"]

_CAPTION = (
    "IoU, F1, P (precision) and R (recall) in per cent, CD (symmetric Chamfer distance) in pixels; in small print the "
    "95 % confidence interval over resampled shapes. The best IoU, CD and F1 are bold. “Best of” rows are no methods: "
    "they choose by the references."
)

_TUNED = "Thresholds with the least Chamfer distance to the drawings that voters chose on {} training views. {}."


def _names(scores: pd.DataFrame) -> list[str]:
    return [f"{shape}_{view}" for shape, view in zip(scores["shape"], scores["view"], strict=True)]


def _tuned(record: Mapping[str, Any]) -> str:
    return "; ".join(
        f"{method}: " + ", ".join(f"{family} {value:.2f}" for family, value in plan["thresholds"].items())
        for method, plan in record["plans"].items()
    )


def _judge(report: RankerReport) -> list[tuple[str, str]]:
    """What a ranking module is worth, in words."""
    facts = []
    if (accuracy := report.accuracy) is not None:
        low, high = (100 * end for end in (accuracy.bootstrap.low, accuracy.bootstrap.high))
        between = f" ({low:.1f} to {high:.1f})" if accuracy.shapes > 1 else ""
        share = f"{100 * accuracy.accuracy:.1f} %{between}"
        facts.append(("pairs in the right order", f"{share}, {accuracy.pairs} pairs of {accuracy.shapes} shapes"))
    correlation = report.correlation
    if correlation.value is not None and correlation.interval is not None:
        between = f"({correlation.interval.low:.2f} to {correlation.interval.high:.2f})"
        words = f"{correlation.value:.2f} {between}, {correlation.views} views"
        facts.append(("rank correlation with F1 over the 256", words))
    if report.preference is not None and report.reliability is not None:
        facts.append(("temperature", f"{report.preference.temperature:.3g}"))
        facts.append(("expected calibration error", f"{100 * report.reliability.error:.1f} %"))
    return facts


def _diagram(report: RankerReport) -> Plot:
    """The reliability diagram."""
    assert report.reliability is not None
    bins = report.reliability.bins
    x, y = [100 * b.predicted for b in bins], [100 * b.observed for b in bins]
    band = [100 * b.interval.low for b in bins], [100 * b.interval.high for b in bins]
    series = [
        Series("votes", x, y, band, style="line+points"),
        Series("as predicted", [50, 100], [50, 100], dashed=True),
    ]
    caption = (
        "Reliability: the share of votes for the drawing that the module prefers, over the share that it predicts. "
        "Its temperature was fitted to the votes on other shapes."
    )
    return line_plot(series, Axis("predicted share, %"), Axis("share of votes, %"), caption)


def _difference_table(differences: pd.DataFrame) -> Table:
    rows: list[list[Cell | str]] = []
    for row in differences.to_dict("records"):
        text, low, high = (f"{100 * row[key]:+.1f}" for key in ("difference", "low", "high"))
        wins = Cell(f"{row['wins']} of {row['shapes']}", row["wins"] / row["shapes"])
        shown = Cell(text, row["difference"], row["clear"], f"{low} to {high}" if row["shapes"] > 1 else "")
        rows.append([row["method"], row["against"], shown, wins])
    caption = "Paired by drawing; bold where the 95 % interval over shapes leaves out 0."
    return Table(["Method", "against", "Difference in F1", "Shapes won"], rows, caption)
