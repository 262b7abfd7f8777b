"""The audit of a study as an HTML report: agreement, consensus, biases, times, participants, contested items."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from dataset_tools.votes.agreement import PositionBias, krippendorff_alpha, position_bias
from dataset_tools.votes.careless_responding import flags
from dataset_tools.votes.consensus import Aggregated, Rules, Verdict, aggregate
from dataset_tools.votes.reliability import counted
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import DRAWINGS
from ncmodel.images import from_brightness, read_grey
from ncmodel.report.contact_sheet import Tile
from ncmodel.report.html import Block, Cell, Facts, Fold, Grid, Section, Table, Text, write_report
from ncmodel.report.plots import bar_plot

MOST_CONTESTED = 12
"""Items that are shown with their drawings."""

TIME_EDGES = (0, 2, 4, 6, 8, 10, 15, 20, 30, 60, 120)
"""Seconds that the histogram of times counts between; what is longer comes last."""


@dataclass(frozen=True, eq=False)
class Audit:
    """What the audit is about.

    Attributes:
        votes: All votes.
        kept: The votes that count.
        aggregated: Verdicts and participants.
        alpha: Krippendorff's alpha of the votes that count; None where it isn't defined.
        bias: Positions chosen, of the votes that count.
        signs: Worker -> signs of not looking.
    """

    votes: pd.DataFrame
    kept: pd.DataFrame
    aggregated: Aggregated
    alpha: float | None
    bias: PositionBias
    signs: Mapping[str, Sequence[str]]

    def summary(self) -> dict[str, object]:
        """The figures, for `--json`."""
        figures = {key: value for key, value in self.aggregated.summary().items() if key != "unreliable"}
        seconds = self.kept["seconds"].dropna()
        return {
            **figures,
            "unreliable_share": 1 - self.aggregated.reliable_share,
            "alpha": self.alpha,
            "positions": list(self.bias.counts),
            "position_p_value": self.bias.p_value,
            "median_seconds": float(seconds.median()) if len(seconds) else None,
            "flagged": {worker: list(signs) for worker, signs in self.signs.items()},
        }


def audit(votes: pd.DataFrame, rules: Rules) -> Audit:
    """Look into the votes of a study."""
    found = aggregate(votes, rules)
    kept = counted(votes, found.participants)
    return Audit(votes, kept, found, krippendorff_alpha(kept), position_bias(kept), flags(votes))


def write_audit(found: Audit, path: Path, data_dir: Path | None) -> None:
    """Write the audit as one HTML file.

    Args:
        found: The audit.
        path: Where to.
        data_dir: The data folder, to show contested items' drawings; without it they are only listed.

    Raises:
        InputError: A picture of the data folder can't be read.
    """
    sections = [
        Section("Overview", _overview(found)),
        Section("Answers", _answers(found)),
        Section("Participants", _participants(found)),
        Section("Items that participants disagree on", _contested(found, data_dir)),
    ]
    write_report(path, "Audit of the votes", sections, "Who answered, how far they agree, and what to look at.")


def _overview(found: Audit) -> list[Block]:
    now = found.aggregated
    accepted = sum(verdict.best is not None for verdict in now.verdicts)
    none = int((found.kept["choice"] < 0).sum())
    alpha = "not defined" if found.alpha is None else f"{found.alpha:.2f}"
    facts = Facts(
        [
            ("participants", str(len(now.participants))),
            ("reliable", f"{100 * now.reliable_share:.1f} %"),
            ("votes that count", f"{len(found.kept)} of {int((~found.votes['sentinel']).sum())}"),
            ("items", str(len(now.verdicts))),
            ("accepted by consensus", f"{accepted} ({100 * accepted / max(1, len(now.verdicts)):.1f} %)"),
            ("agreed that none is good", str(sum(verdict.choice == -1 for verdict in now.verdicts))),
            ("answers 'none of these'", f"{100 * none / max(1, len(found.kept)):.1f} %"),
            ("Krippendorff's alpha", alpha),
        ]
    )
    simulated = any("simulated" in participant.sources for participant in now.participants.values())
    warning = (
        [Text("Some of these participants are simulated: nobody gave their answers.", "warning")] if simulated else []
    )
    return [*warning, facts]


def _answers(found: Audit) -> list[Block]:
    places = [str(place) for place in range(1, DRAWINGS + 1)]
    p_value = found.bias.p_value
    test = "no votes" if p_value is None else f"chi-square test that all are equal: p = {p_value:.2g}"
    agreeing = Counter(max(verdict.votes.values(), default=0) for verdict in found.aggregated.verdicts)
    most = range(max(agreeing, default=0) + 1)
    blocks: list[Block] = [
        bar_plot(places, found.bias.counts, y_label="votes", caption=f"Votes by position on the page; {test}."),
        bar_plot(
            [str(count) for count in most],
            [agreeing[count] for count in most],
            y_label="items",
            caption="Votes for an item's favourite answer.",
        ),
    ]
    seconds = found.kept["seconds"].dropna().to_numpy(np.float64)
    if len(seconds):
        counts, _ = np.histogram(seconds, [*TIME_EDGES, np.inf])
        labels = [f"{low}+" for low in TIME_EDGES]
        caption = f"Time for a question; the median is {np.median(seconds):.1f} s."
        blocks.append(bar_plot(labels, counts.tolist(), y_label="votes", caption=caption))
    return blocks


def _participants(found: Audit) -> list[Block]:
    people = found.aggregated.participants.values()
    typical = {worker: time for worker, time in found.votes.groupby("worker")["seconds"].median().items()}
    times = {worker: Cell("", 0.0) if time is pd.NA else Cell(f"{time:.1f}", time) for worker, time in typical.items()}
    excluded = [(person.worker, "; ".join(person.reasons), times[person.worker]) for person in people if person.reasons]
    flagged = [(worker, "; ".join(signs), times[worker]) for worker, signs in found.signs.items()]
    repeated = [(person.worker, str(len(person.later))) for person in people if person.later]
    blocks: list[Block] = [
        Table(["participant", "why", "median seconds"], excluded, "Excluded: their answers don't count."),
        Text("Signs of not looking prove nothing; they exclude only where aggregation is told to be strict.", "note"),
        Table(["participant", "sign", "median seconds"], flagged, "Flagged: worth a look."),
    ]
    if repeated:
        blocks.append(
            Table(["participant", "later questionnaires"], repeated, "Took part again: only the first counts.")
        )
    return blocks


def _contested(found: Audit, data_dir: Path | None) -> list[Block]:
    """The items whose votes are spread most, with their drawings."""
    split = [verdict for verdict in found.aggregated.verdicts if verdict.total > 1 and verdict.choice is None]
    split.sort(key=lambda verdict: (max(verdict.votes.values()) / verdict.total, -verdict.total, verdict.item))
    rows = [(verdict.item.name, Cell(str(verdict.total), verdict.total), _spelt(verdict)) for verdict in split]
    blocks: list[Block] = []
    if data_dir is not None:
        data = DataFolder(data_dir)
        shown = [verdict for verdict in split if data.view_folder(verdict.item).is_dir()][:MOST_CONTESTED]
        blocks += [
            Grid(_tiles(data, verdict), f"{verdict.item.name}: {_spelt(verdict)}", columns=9, max_side=256)
            for verdict in shown
        ]
    blocks.append(Fold(f"all {len(split)}", [Table(["item", "votes", "for"], rows)]))
    return blocks


def _tiles(data: DataFolder, verdict: Verdict) -> list[Tile]:
    shape = read_grey(data.own_render(verdict.item))
    tiles = [Tile(from_brightness(shape), "the shape")]
    for index, path in enumerate(data.drawing_paths(verdict.item)):
        first = verdict.twins[index]
        count = verdict.votes.get(first, 0)
        picture = from_brightness(read_grey(path))
        label = f"{count} vote{'' if count == 1 else 's'}" if first == index else f"the same as {first}"
        tiles.append(Tile(picture, f"{index}: {label}", highlight=count > 0))
    return tiles


def _spelt(verdict: Verdict) -> str:
    return ", ".join(f"{'none' if choice < 0 else choice}: {count}" for choice, count in verdict.votes.items())
