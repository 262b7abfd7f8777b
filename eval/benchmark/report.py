"""The benchmark's tables, plots and page: speed, its growth, and what accuracy costs."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from eval.benchmark.presets import BEST, NEAR, Effort, mean_efforts
from eval.benchmark.processes import ProcessRun
from eval.benchmark.scaling import CLASSIC, Scaling
from ncmodel.files import write_text
from ncmodel.report.html import Block, Cell, Fold, Section, Table, Text, write_report
from ncmodel.report.part import Part
from ncmodel.report.plots import Axis, Series, line_plot
from ncmodel.report.text import text_table

LEAD = (
    "Speed of the geometry stages and of whole commands over the size of the mesh, and what the faster presets cost in "
    "accuracy. Times hold for the machine they were taken on."
)


@dataclass(frozen=True)
class Bench:
    """Everything that was measured.

    Attributes:
        scaling: Stages over face counts.
        processes: Whole commands over face counts.
        efforts: Shapes at each preset, at fixed thresholds.
        machine: What it ran on.
        searches: The same with thresholds chosen by a model, if there is one.
        parts: What else was measured.
        failures: A line for each mesh that could not be measured.
    """

    scaling: Sequence[Scaling]
    processes: Sequence[ProcessRun]
    efforts: Sequence[Effort]
    machine: Mapping[str, str]
    searches: Sequence[Effort] = ()
    parts: Sequence[Part] = ()
    failures: Sequence[str] = ()

    def to_record(self) -> dict[str, object]:
        """All numbers as one JSON object."""
        return {
            "machine": dict(self.machine),
            "scaling": [_scaling_record(stage) for stage in self.scaling],
            "processes": [asdict(run) for run in self.processes],
            "presets": [asdict(effort) for effort in self.efforts],
            "presets_with_model": [asdict(effort) for effort in self.searches],
            **{part.name: part.record for part in self.parts},
            "failures": list(self.failures),
        }

    def to_text(self) -> str:
        """The tables for a terminal."""
        tables = [scaling_rows(self.scaling)] if self.scaling else []
        tables += [process_rows(self.processes)] if self.processes else []
        tables += [effort_rows(mean_efforts(efforts)) for efforts in (self.efforts, self.searches) if efforts]
        tables += [[list(row) for row in part.rows] for part in self.parts]
        return "\n\n".join(text_table(rows) for rows in tables)

    def sections(self) -> list[Section]:
        """The parts of the page."""
        parts = [_scaling_section(self.scaling)] if self.scaling else []
        parts += [_process_section(self.processes)] if self.processes else []
        if self.efforts:
            parts.append(_effort_section("Speed against accuracy", "all families at fixed thresholds", self.efforts))
        if self.searches:
            chosen = "families and thresholds chosen by the model"
            parts.append(_effort_section("Speed against accuracy with a model", chosen, self.searches))
        if self.failures:
            parts.append(Section("Not measured", [Text(line, "warning") for line in self.failures]))
        return parts + [Section(part.title, [Text(part.text), _table(part.rows)]) for part in self.parts]

    def write(self, folder: Path) -> None:
        """Write bench.json and bench.html into a folder, which is made if needed."""
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / "bench.json", json.dumps(self.to_record(), indent=1, allow_nan=False) + "\n")
        machine = ", ".join(f"{name} {value}" for name, value in self.machine.items())
        write_report(folder / "bench.html", "Benchmark", self.sections(), f"{LEAD} ({machine}.)")


def scaling_rows(times: Sequence[Scaling]) -> list[list[str]]:
    """One row a stage: milliseconds at every size, their growth, and the classic program's milliseconds."""
    sizes = list(times[0].milliseconds)
    classic = sorted({faces for row in CLASSIC.values() for faces in row})
    rows = [["stage (ms)", *map(_faces, sizes), "growth", *(f"C++ {_faces(size)}" for size in classic)]]
    for time in times:
        published = CLASSIC.get(time.stage, {})
        ours = [_three_digits(time.milliseconds[size]) for size in sizes]
        theirs = [_three_digits(published[size]) if size in published else "" for size in classic]
        rows.append([time.stage, *ours, "" if math.isnan(time.exponent) else f"{time.exponent:.2f}", *theirs])
    return rows


def process_rows(runs: Sequence[ProcessRun]) -> list[list[str]]:
    """One row a run of the command."""
    head = ["ncontours draw", "faces", "seconds", "processor s", "peak MB"]
    return [
        head,
        *(
            [
                run.case,
                _faces(run.faces),
                f"{run.seconds:.2f}",
                f"{run.processor_seconds:.2f}",
                f"{run.peak_megabytes:.0f}",
            ]
            for run in runs
        ),
    ]


def effort_rows(efforts: Sequence[Effort]) -> list[list[str]]:
    """One row a shape and preset; what concerns a model's search only where there was one."""
    head = ["shape", "preset", "ms", f"F1 in {NEAR:g} px", "Chamfer px", "strokes", "SVG kB"]
    searched = any(effort.evaluations for effort in efforts)
    rows = [[*head, *(["drawings scored", "score short by"] if searched else [])]]
    for effort in efforts:
        search = [f"{effort.evaluations:.0f}", f"{effort.shortfall:.3g}"] if searched else []
        rows.append(
            [
                effort.shape,
                effort.preset,
                _three_digits(1000.0 * effort.seconds),
                f"{100.0 * effort.f1:.2f}",
                f"{effort.chamfer:.3f}",
                f"{effort.strokes:.0f}",
                _three_digits(effort.kilobytes),
                *search,
            ]
        )
    return rows


def _scaling_section(times: Sequence[Scaling]) -> Section:
    series = [
        Series(time.stage, list(time.milliseconds), list(time.milliseconds.values()), style="line+points")
        for time in times
    ]
    text = (
        "Milliseconds of processor time (all threads) on a closed surface with lines of every family; the fastest of "
        "several runs. Growth is p of time ~ faces^p: 1 is linear. C++ is the classic program, one thread, on the same "
        "kind of machine."
    )
    plot = line_plot(series, Axis("faces", "log"), Axis("milliseconds", "log"), size=(7.0, 4.4))
    return Section("Geometry, stage by stage", [Text(text), _table(scaling_rows(times)), plot])


def _process_section(runs: Sequence[ProcessRun]) -> Section:
    text = "Whole processes, start-up and reading of the mesh included; the faster of two runs, so with warm caches."
    blocks: list[Block] = [Text(text), _table(process_rows(runs))]
    for label, measure in (("seconds", "seconds"), ("peak memory, MB", "peak_megabytes")):
        series = []
        for case in dict.fromkeys(run.case for run in runs):
            mine = [run for run in runs if run.case == case]
            values = [float(getattr(run, measure)) for run in mine]
            series.append(Series(case, [run.faces for run in mine], values, style="line+points"))
        blocks.append(line_plot(series, Axis("faces", "log"), Axis(label)))
    return Section("The whole command", blocks)


def _effort_section(title: str, what: str, efforts: Sequence[Effort]) -> Section:
    text = (
        f"From mesh to SVG at each preset, {what}; F1 and Chamfer distance are between its lines and those of the "
        f"preset '{BEST}'."
    )
    means = _table(effort_rows(mean_efforts(efforts)))
    return Section(title, [Text(text), means, Fold("Each shape", [_table(effort_rows(efforts))])])


def _table(rows: Sequence[Sequence[str]]) -> Table:
    head, *body = rows
    return Table(head, [[Cell(text, _number(text)) for text in row] for row in body])


def _scaling_record(time: Scaling) -> dict[str, object]:
    return {
        "stage": time.stage,
        "milliseconds": {str(faces): value for faces, value in time.milliseconds.items()},
        "exponent": None if math.isnan(time.exponent) else time.exponent,
        "classic_milliseconds": {str(faces): value for faces, value in CLASSIC.get(time.stage, {}).items()},
    }


def _faces(count: int) -> str:
    return f"{count / 1e6:.3g}M" if count >= 950_000 else f"{count / 1e3:.0f}k"


def _three_digits(value: float) -> str:
    return f"{value:.1f}" if value < 100.0 else f"{value:.0f}"


def _number(text: str) -> float | None:
    """What a cell is sorted by, thousands and millions written out; `None` for words."""
    scale = {"k": 1e3, "M": 1e6}.get(text[-1:], 1.0)
    try:
        return scale * float(text.rstrip("kM"))
    except ValueError:
        return None
