"""A page with the curves of a training, which may be open while it runs: it loads itself anew."""

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ncmodel.report.html import Block, Section, Text, write_report
from ncmodel.report.plots import Axis, Series, line_plot

RELOAD = 10
"""Seconds after which an open page loads itself anew while training runs, and after which it is written anew."""

Histories = Mapping[str, Sequence[Mapping[str, Any]]]
"""Stage -> one record a pass: "epoch", "loss" and the validation measures."""


class Curves:
    """Keeps a page of curves.

    Args:
        path: The page.
        notes: What the reader must know.
    """

    def __init__(self, path: Path, notes: Sequence[str] = ()) -> None:
        self.path, self.notes = path, notes
        self._written = float("-inf")

    def show(self, histories: Histories) -> None:
        """Write the page of a training that runs, unless that was done a moment ago."""
        if time.monotonic() - self._written >= RELOAD:
            self._write(histories, RELOAD)
            self._written = time.monotonic()

    def finish(self, histories: Histories) -> None:
        """Write the page of a training that has ended; it stays as it is."""
        self._write(histories, None)

    def _write(self, histories: Histories, reload: int | None) -> None:
        known = {stage: records for stage, records in histories.items() if records}
        warned = [Text(note, "warning") for note in self.notes]
        sections = [Section(stage.capitalize(), curves_of(records)) for stage, records in known.items()]
        if sections and warned:
            sections[0] = Section(sections[0].title, [*warned, *sections[0].blocks])
        lead = "Training runs; this page loads itself anew." if reload else "Training has ended."
        write_report(self.path, f"Curves of {self.path.name.removesuffix('.curves.html')}", sections, lead, reload)


def curves_of(records: Sequence[Mapping[str, Any]]) -> list[Block]:
    """The curves of a stage: what it minimises, on training and held-out items, and its accuracy on the latter."""
    passes = [float(record["epoch"]) for record in records]
    # Records that were read from a file have their names in another order.
    names = ["loss", *sorted(records[0].keys() - {"epoch", "loss"})]

    def series(name: str) -> Series:
        label = "loss on training items" if name == "loss" else f"{name.replace('_', ' ')} on held-out items"
        return Series(label, passes, [float(record[name]) for record in records], style="line+points")

    last = records[-1]
    said = ", ".join(f"{name.replace('_', ' ')} {last[name]:.4f}" for name in names)
    blocks: list[Block] = [Text(f"Pass {last['epoch']}: {said}.")]
    blocks.append(line_plot([series(name) for name in names if name != "accuracy"], Axis("pass"), Axis("loss")))
    if "accuracy" in names:
        blocks.append(line_plot([series("accuracy")], Axis("pass"), Axis("accuracy")))
    return blocks
