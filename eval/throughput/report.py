"""What was measured, as JSON, as a table in Markdown, and as a page."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from eval.throughput.drawing import Agreement
from eval.throughput.growth import EXCHANGE, ITEMS, PROCESSES, Growth, growth_of
from eval.throughput.training import Speed
from ncmodel.files import write_text
from ncmodel.report.html import Facts, Section, Table, Text, write_report

LEAD = (
    "Steps of training on made-up views of 768 pixels, each decoded anew; there is nothing to learn from them. In "
    "float32 a GPU's convolutions may round to TF32, as PyTorch has it by default."
)


@dataclass(frozen=True)
class Throughput:
    """Everything that was measured.

    Attributes:
        machine: What it ran on.
        speeds: Training steps.
        left_out: Setups that time didn't suffice for.
        drawing: The same drawing on CPU and device, if it was made.
        no_drawing: Why it wasn't.
    """

    machine: Mapping[str, str]
    speeds: Sequence[Speed]
    left_out: Sequence[str] = ()
    drawing: Agreement | None = None
    no_drawing: str = ""

    def to_record(self) -> dict[str, object]:
        """All numbers as one JSON object."""
        return {
            "machine": dict(self.machine),
            "training": [asdict(speed) for speed in self.speeds],
            "growth": [asdict(growth) for growth in growth_of(self.speeds)],
            "left_out": list(self.left_out),
            "drawing": None if self.drawing is None else asdict(self.drawing),
            "no_drawing": self.no_drawing,
        }

    def write(self, folder: Path) -> None:
        """Write throughput.json, throughput.md and throughput.html."""
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / "throughput.json", json.dumps(self.to_record(), indent=1, allow_nan=False) + "\n")
        speeds, growth = speed_rows(self.speeds), growth_rows(growth_of(self.speeds))
        drawing = drawing_rows(self.drawing) if self.drawing else []
        tables = [markdown(rows) for rows in (speeds, growth, drawing) if len(rows) > 1]
        machine = ", ".join(f"{name} {value}" for name, value in self.machine.items())
        notes = [f"Left out for want of time: {'; '.join(self.left_out)}."] if self.left_out else []
        notes += [f"No drawing: {self.no_drawing}."] if self.no_drawing else []
        write_text(folder / "throughput.md", "\n\n".join([machine, *tables, *notes]) + "\n")
        sections = [
            Section("Machine", [Facts(list(self.machine.items()))]),
            Section("Training steps", [Table(speeds[0], speeds[1:]), *(Text(note, "note") for note in notes)]),
            Section(f"On {ITEMS:,} views", [Table(growth[0], growth[1:]), Text(GROWTH)]),
        ]
        if drawing:
            sections.append(Section("A drawing on the CPU and on the device", [Table(drawing[0], drawing[1:])]))
        write_report(folder / "throughput.html", "Throughput", sections, LEAD)


GROWTH = (
    f"Computed: passes of the preset over {ITEMS:,} views of seven pairs each, validation not counted. On {PROCESSES} "
    f"devices from the measured time of one device's part of a step, plus adding up gradients at an assumed "
    f"{EXCHANGE / 1e9:.0f} GB/s."
)


def speed_rows(speeds: Sequence[Speed]) -> list[list[str]]:
    """A row a setup."""
    head = ["preset", "stage", "numbers", "workers", "a step", "s a step", "views/s", "pairs/s", "GiB at most"]
    rows = []
    for speed in speeds:
        setup = speed.setup
        numbers = "bfloat16" if setup.bfloat16 else "float32"
        what = f"{speed.batch} {'views' if setup.stage == 'translator' else 'pairs'}"
        row = [setup.preset, setup.stage, numbers, str(setup.workers), what]
        pairs = "" if setup.stage == "translator" else f"{speed.pairs:.3g}"
        measured = [f"{speed.seconds:.3g}", f"{speed.views:.3g}", pairs, f"{speed.memory:.2f}"]
        rows.append([*row, *(measured if speed.steps else [speed.failure, "", "", ""])])
    return [head, *rows]


def growth_rows(growth: Sequence[Growth]) -> list[list[str]]:
    """A row a stage and setup."""
    head = ["preset", "stage", "numbers", "workers", "passes", "steps a pass", "hours on 1", f"hours on {PROCESSES}"]
    rows = [
        [
            g.setup.preset,
            g.setup.stage,
            "bfloat16" if g.setup.bfloat16 else "float32",
            str(g.setup.workers),
            str(g.passes),
            f"{g.steps:,}",
            f"{g.hours:.3g}",
            f"{g.hours_on_many:.3g}" if g.hours_on_many else "",
        ]
        for g in growth
    ]
    return [head, *rows]


def drawing_rows(agreement: Agreement) -> list[list[str]]:
    """A row a figure."""
    chosen = [" ".join("–" if t is None else f"{t:.3f}" for t in thresholds) for thresholds in agreement.thresholds]
    return [
        ["figure", agreement.budget],
        ["seconds on the CPU", f"{agreement.cpu_seconds:.1f}"],
        ["seconds on the device", f"{agreement.device_seconds:.1f}"],
        ["scores differ by, of their range", f"{agreement.score_error:.1e}"],
        ["probabilities differ by", f"{agreement.probability_error:.1e}"],
        ["thresholds on the CPU", chosen[0]],
        ["thresholds on the device", chosen[1]],
        ["inked pixels in one drawing only", f"{agreement.ink_error:.2%}"],
    ]


def markdown(rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown, its head first."""
    lines = [rows[0], ["---"] * len(rows[0]), *rows[1:]]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines)
