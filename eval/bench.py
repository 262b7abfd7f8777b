"""The benchmark's tables, plots and pages: speed, its growth, and what accuracy costs."""

import json
import math
from collections.abc import Sequence
from pathlib import Path

from eval.scaling import CLASSIC, Scaling
from ncmodel.files import write_text
from ncmodel.plots import Axis, Series, line_plot
from ncmodel.report import Cell, Section, Table, Text, write_report


def scaling_rows(times: Sequence[Scaling]) -> list[list[str]]:
    """The table of stages as text: one row a stage, milliseconds a size, the classic program's beside them."""
    sizes = list(times[0].milliseconds)
    classic = sorted({faces for row in CLASSIC.values() for faces in row})
    head = ["stage", *(_thousands(size) for size in sizes), "growth", *(f"C++ {_thousands(size)}" for size in classic)]
    rows = [head]
    for time in times:
        published = CLASSIC.get(time.stage, {})
        ours = [_milliseconds(time.milliseconds[size]) for size in sizes]
        theirs = [_milliseconds(published[size]) if size in published else "" for size in classic]
        rows.append([time.stage, *ours, _exponent(time.exponent), *theirs])
    return rows


def scaling_section(times: Sequence[Scaling]) -> Section:
    """Stages over face counts: table and plot."""
    head, *body = scaling_rows(times)
    cells: list[list[Cell | str]] = [[row[0], *(Cell(text, _number(text)) for text in row[1:])] for row in body]
    series = [
        Series(time.stage, list(time.milliseconds), list(time.milliseconds.values()), style="line+points")
        for time in times
    ]
    return Section(
        "Geometry, stage by stage",
        [
            Text(
                "Milliseconds of processor time (all threads) on a closed surface with lines of every family; the "
                "fastest of several runs. Growth is p of time ~ faces^p: 1 is linear. C++ is the classic program, one "
                "thread, on the same kind of machine."
            ),
            Table(head, cells, "Milliseconds by number of faces."),
            line_plot(series, Axis("faces", "log"), Axis("milliseconds", "log"), size=(7.0, 4.2)),
        ],
    )


def write_bench(folder: Path, sections: Sequence[Section], record: dict[str, object], lead: str) -> None:
    """Write bench.json and bench.html into a folder, which is made if needed."""
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "bench.json", json.dumps(record, indent=1, allow_nan=False) + "\n")
    write_report(folder / "bench.html", "Benchmark", sections, lead)


def scaling_record(times: Sequence[Scaling]) -> list[dict[str, object]]:
    """The times as JSON objects, one a stage."""
    return [
        {
            "stage": time.stage,
            "milliseconds": {str(faces): value for faces, value in time.milliseconds.items()},
            "exponent": None if math.isnan(time.exponent) else time.exponent,
            "classic_milliseconds": {str(faces): value for faces, value in CLASSIC.get(time.stage, {}).items()},
        }
        for time in times
    ]


def _thousands(faces: int) -> str:
    return f"{faces / 1e6:.3g}M" if faces >= 950_000 else f"{faces / 1e3:.3g}k"


def _milliseconds(value: float) -> str:
    return f"{value:.1f}" if value < 100.0 else f"{value:.0f}"


def _exponent(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.2f}"


def _number(text: str) -> float | None:
    return float(text) if text else None
