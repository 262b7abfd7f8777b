"""The outcome of a trial as tables, in an HTML report and as text."""

from collections.abc import Sequence
from pathlib import Path

from dataset_tools.simulation.rule_trial import HONEST, Trial
from ncmodel.report.html import Cell, Section, Table, Text, write_report
from ncmodel.report.text import text_table

KIND_COLUMNS = ("kind", "participants", "excluded by the paper's rule", "excluded when strict", "should be excluded")
RULE_COLUMNS = (
    "rule", "items kept", "of those with 3 votes", "kept are right", "pairs right", "votes that count",
    "wrongly excluded", "wrongly kept",
)  # fmt: skip


def _kind_rows(found: Trial) -> list[Sequence[Cell | str]]:
    return [
        (
            kind.kind,
            Cell(str(kind.participants), kind.participants),
            Cell(str(kind.excluded), kind.excluded),
            Cell(str(kind.excluded_strict), kind.excluded_strict),
            "no" if kind.kind in HONEST else "yes",
        )
        for kind in found.kinds
    ]


def _rule_rows(found: Trial) -> list[Sequence[Cell | str]]:
    return [
        (
            rule.rule,
            Cell(f"{100 * rule.kept:.1f} %", rule.kept),
            Cell(f"{100 * rule.kept_of_full:.1f} %", rule.kept_of_full),
            Cell(f"{100 * rule.right:.1f} %", rule.right),
            Cell(f"{100 * rule.pairs_right:.1f} %", rule.pairs_right),
            Cell(str(rule.votes), rule.votes),
            Cell(str(rule.wrongly_excluded), rule.wrongly_excluded),
            Cell(str(rule.wrongly_kept), rule.wrongly_kept),
        )
        for rule in found.rules
    ]


def as_text(found: Trial) -> str:
    """Both tables as aligned text."""
    return "\n\n".join(
        text_table([columns, *([cell if isinstance(cell, str) else cell.text for cell in row] for row in rows)])
        for columns, rows in ((KIND_COLUMNS, _kind_rows(found)), (RULE_COLUMNS, _rule_rows(found)))
    )


def write_trial(found: Trial, path: Path) -> None:
    """Write the outcome as one HTML file."""
    warning = Text("All participants are simulated: nobody gave these answers.", "warning")
    sections = [
        Section("Who is excluded", [warning, Table(KIND_COLUMNS, _kind_rows(found))]),
        Section("What is kept", [Table(RULE_COLUMNS, _rule_rows(found))]),
    ]
    lead = f"{found.participants} simulated participants and accounts, {found.items} made-up items with 3 votes each."
    write_report(path, "A trial of the rules", sections, lead)
