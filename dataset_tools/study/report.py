"""The perceptual study as an HTML report: the paper's bar chart with counts and confidence intervals."""

from collections.abc import Mapping
from dataclasses import astuple
from pathlib import Path

from scipy.stats import binomtest

from dataset_tools.study.analysis import StudyResult
from dataset_tools.study.design import Preference
from ncmodel.report.html import Block, Cell, Facts, Section, Table, Text, write_report
from ncmodel.report.intervals import wilson_interval
from ncmodel.report.plots import bar_plot


def summary(found: StudyResult, ours: str) -> dict[str, object]:
    """The figures, for `--json`."""
    return {
        "ours": ours,
        "simulated": found.simulated,
        "participants": len(found.inconsistent),
        "unreliable": sorted(found.unreliable),
        "comparisons": len(found.comparisons),
        "short_of_answers": len(found.short),
        "answers_lacking": sum(found.short.values()),
        "rivals": {rival: _figures(counts) for rival, counts in found.counts.items()},
    }


def _figures(counts: Mapping[Preference, int]) -> dict[str, object]:
    total = sum(counts.values())
    decided = counts.get(Preference.OURS, 0) + counts.get(Preference.RIVAL, 0)
    test = binomtest(counts.get(Preference.OURS, 0), decided) if decided else None
    return {
        "answers": total,
        "p_value": float(test.pvalue) if test else None,
        **{
            preference.value: {
                "count": counts.get(preference, 0),
                "share": counts.get(preference, 0) / max(1, total),
                "interval": list(astuple(wilson_interval(counts.get(preference, 0), total))),
            }
            for preference in Preference
        },
    }


def write_study_report(found: StudyResult, ours: str, path: Path) -> None:
    """Write the report as one HTML file."""
    people = len(found.inconsistent)
    facts = Facts(
        [
            ("participants", str(people)),
            ("unreliable", f"{len(found.unreliable)} ({100 * len(found.unreliable) / max(1, people):.1f} %)"),
            ("comparisons", str(len(found.comparisons))),
            ("short of consistent answers", str(len(found.short))),
        ]
    )
    warning = (
        [Text("These participants are simulated: nobody gave their answers.", "warning")] if found.simulated else []
    )
    sections = [Section("Participants", [*warning, facts])]
    sections += [
        Section(f"{ours} against {rival}", _against(ours, rival, counts)) for rival, counts in found.counts.items()
    ]
    rows = [(one.case, one.rival, Cell(str(lacking), lacking)) for one, lacking in found.short.items()]
    caption = "Ask again about these, with ncontours crowd study topup." if rows else "None."
    sections.append(Section("Short of answers", [Table(["case", "rival", "lacks"], rows, caption)]))
    write_report(path, "Which drawing conveys the shape better?", sections, f"{ours} beside other methods' drawings.")


def _against(ours: str, rival: str, counts: Mapping[Preference, int]) -> list[Block]:
    total = sum(counts.values())
    names = {Preference.OURS: ours, Preference.RIVAL: rival, Preference.BOTH: "both", Preference.NONE: "none"}
    shares = [100 * counts.get(preference, 0) / max(1, total) for preference in names]
    intervals = [wilson_interval(counts.get(preference, 0), total) for preference in names]
    decided = counts.get(Preference.OURS, 0) + counts.get(Preference.RIVAL, 0)
    p_value = binomtest(counts.get(Preference.OURS, 0), decided).pvalue if decided else 1.0
    caption = f"{total} consistent answers; sign test of {ours} against {rival}: p = {p_value:.2g}."
    rows = [
        (name, Cell(str(counts.get(preference, 0)), counts.get(preference, 0)), Cell(f"{share:.1f} %", share,
         note=f"{100 * interval.low:.0f} to {100 * interval.high:.0f}"))
        for (preference, name), share, interval in zip(names.items(), shares, intervals, strict=True)
    ]  # fmt: skip
    return [
        bar_plot(
            list(names.values()),
            shares,
            [(100 * interval.low, 100 * interval.high) for interval in intervals],
            y_label="% of answers",
            caption=caption,
        ),
        Table(["answer", "count", "share"], rows, "With 95 % confidence intervals (Wilson)."),
    ]
