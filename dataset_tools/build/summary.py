"""What a build came to, for people and for programs."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from dataset_tools.build.build import Summary
from dataset_tools.build.store import ViewStatus
from dataset_tools.build.threshold_study import PERCENTILES, ThresholdStudy
from dataset_tools.cleaning.repair import CleanReport
from ncmodel.report.text import text_table

_FAULTS = ("border_edges", "touching_vertices", "non_manifold_edges", "non_manifold_vertices", "inconsistent_edges")

SHOWN = 20
"""Failures listed for people; the index has them all."""


def summary_record(summary: Summary) -> dict[str, Any]:
    """A build as a JSON object."""
    return {**status_record(summary.rows), "made": summary.made, "seconds": round(summary.seconds, 2)}


def summary_text(summary: Summary) -> str:
    """A build for people."""
    return f"{summary.made} views made in {summary.seconds:.0f} s\n{status_text(summary.rows)}"


def status_record(rows: Sequence[ViewStatus]) -> dict[str, Any]:
    """The state of a data folder as a JSON object."""
    counts = _counts(rows)
    problems = [
        {"shape": row.shape, "view": row.view, "status": row.status, "reason": row.reason}
        for row in rows
        if row.status in ("failed", "damaged")
    ]
    return {**counts, "views": len(rows), "problems": problems}


def status_text(rows: Sequence[ViewStatus]) -> str:
    """The state of a data folder for people."""
    counts = ", ".join(f"{number} {status}" for status, number in _counts(rows).items())
    problems = [row for row in rows if row.status in ("failed", "damaged")]
    lines = [f"{len(rows)} views: {counts}"]
    lines += [f"  {row.item.name}: {row.status}: {row.reason}" for row in problems[:SHOWN]]
    if len(problems) > SHOWN:
        lines.append(f"  and {len(problems) - SHOWN} more")
    return "\n".join(lines)


def clean_text(report: CleanReport) -> str:
    """The cleaning of one mesh for people."""
    found, left = asdict(report.found), asdict(report.left)
    lines = [f"{found['vertices']} vertices, {found['faces']} faces -> {left['vertices']}, {left['faces']}"]
    lines += [f"  {step.step}: {step.count}" for step in report.done] or ["  nothing to repair"]
    still = [f"{number} {name.replace('_', ' ')}" for name, number in left.items() if number and name in _FAULTS]
    return "\n".join([*lines, f"left: {', '.join(still) if still else 'no fault'}"])


def thresholds_text(study: ThresholdStudy) -> str:
    """Measured thresholds for people."""
    head = [["family", "threshold", *(f"{percentile}th" for percentile in PERCENTILES)]]
    nothing = ["-"] * len(PERCENTILES)
    rows = [
        [kept.family, f"{kept.threshold:g}", *([f"{s:.2f}" for s in kept.shares] or nothing)] for kept in study.kept
    ]
    return "\n".join(
        [
            f"share of visible length kept on {study.views} views, its percentiles",
            text_table([*head, *rows]),
            f"different ones of 256 drawings of lines: {', '.join(f'{n:.0f}' for n in study.distinct)}",
        ]
    )


def _counts(rows: Sequence[ViewStatus]) -> dict[str, int]:
    counts = Counter(row.status for row in rows)
    return {status: counts[status] for status in ("done", "failed", "skipped", "damaged", "pending")}
