"""The paper's tables 1 to 4 and the appendix's, laid out as there: our means, and the figures that the paper has."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from eval.measures.comparison import COLUMNS, JUDGED_BY, Comparison, shown
from eval.measures.metrics import LOWER_IS_BETTER
from ncmodel.report.html import Cell, Table

Figures = tuple[float, float, float, float, float]
"""IoU, CD, F1, P and R as the paper prints them: in per cent, CD in pixels; the order of `COLUMNS`."""

LAST = "NCs"
"""The row that the paper's tables end with, below a line."""

NOTE = (
    "The rows that the paper has, too. Its figures are of people's drawings of its own test shapes: they tell the order"
    " of methods there, and can't be subtracted from these."
)


@dataclass(frozen=True)
class PaperTable:
    """One table.

    Attributes:
        name: Of its files.
        caption: The paper's, shortened.
        rows: Our name of the row -> the paper's figures, in the paper's order.
        most_consistent: Whether drawings are held against the most consistent reference of each view alone.
    """

    name: str
    caption: str
    rows: Mapping[str, Figures]
    most_consistent: bool = False


TABLES = (
    PaperTable(
        "all-drawings",
        "Table 1: competing methods, all drawings",
        {
            "contours": (31.5, 31.70, 34.8, 83.0, 22.0),
            "AR-rtsc": (53.4, 12.56, 54.1, 52.5, 55.7),
            "RV-rtsc": (49.8, 12.96, 52.3, 44.5, 63.5),
            "SC-rtsc": (40.5, 13.96, 44.0, 43.9, 44.1),
            "all-rtsc": (48.2, 12.63, 52.5, 40.4, 75.1),
            "Decision Tree": (46.9, 12.17, 49.9, 38.6, 70.4),
            "Canny": (51.9, 12.59, 52.9, 50.4, 55.8),
            "pix2pixHD": (45.0, 15.73, 48.7, 69.6, 37.5),
            "NCs": (57.9, 10.72, 60.6, 60.8, 60.5),
        },
    ),
    PaperTable(
        "most-consistent",
        "Table 2: competing methods, the most consistent drawing of each view",
        {
            "contours": (43.5, 24.63, 49.6, 90.2, 34.3),
            "AR-rtsc": (59.9, 10.64, 63.3, 62.6, 64.0),
            "RV-rtsc": (52.6, 10.76, 55.3, 47.0, 67.3),
            "SC-rtsc": (46.6, 12.27, 50.6, 52.1, 49.1),
            "all-rtsc": (51.8, 10.74, 56.5, 43.8, 79.6),
            "Decision Tree": (49.7, 11.12, 53.0, 41.1, 74.6),
            "Canny": (58.0, 11.16, 61.3, 56.7, 66.7),
            "pix2pixHD": (50.5, 13.35, 54.2, 75.1, 42.4),
            "NCs": (65.2, 8.71, 67.6, 66.3, 69.0),
        },
        most_consistent=True,
    ),
    PaperTable(
        "new-dataset",
        "Table 3: competing methods, the paper's figures on its new test dataset",
        {
            "contours": (49.0, 19.11, 54.9, 92.2, 39.1),
            "AR-rtsc": (66.8, 9.19, 69.9, 69.2, 70.7),
            "RV-rtsc": (64.8, 9.36, 66.2, 62.8, 70.1),
            "SC-rtsc": (65.0, 9.88, 63.3, 61.5, 65.2),
            "all-rtsc": (64.4, 9.70, 68.6, 58.6, 82.7),
            "Decision Tree": (62.1, 8.93, 61.1, 50.9, 76.6),
            "Canny": (65.6, 8.57, 64.6, 59.8, 70.2),
            "pix2pixHD": (66.0, 9.62, 68.2, 76.9, 61.2),
            "NCs": (72.4, 7.25, 74.6, 74.5, 74.8),
        },
    ),
    PaperTable(
        "ablation",
        "Table 4: ablation study",
        {
            "NC-geometry": (60.3, 10.34, 64.5, 76.9, 55.6),
            "NC-image": (60.0, 9.97, 62.9, 65.0, 61.0),
            "NC-image-noms": (58.4, 10.85, 60.7, 59.1, 62.3),
            "NC-image-curv": (56.1, 10.72, 60.0, 61.0, 59.0),
            "NCs": (62.8, 9.54, 65.4, 65.5, 65.4),
        },
    ),
    PaperTable(
        "appendix",
        "The appendix's table: thresholds by exhaustive search and by regression",
        {
            "AR-grid": (56.6, 11.21, 59.1, 54.2, 64.9),
            "RV-grid": (56.0, 11.73, 58.3, 53.6, 63.9),
            "SC-grid": (51.0, 12.57, 53.2, 57.5, 49.5),
            "all-grid": (54.6, 11.61, 57.4, 47.9, 71.7),
            "Geometry-Regressor": (52.9, 11.05, 54.2, 48.2, 62.0),
            "NCs": (62.8, 9.54, 65.4, 65.5, 65.4),
        },
    ),
)


def consistent(scores: pd.DataFrame, records: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """The scores against the most consistent reference of each view: the one nearest to the others."""
    chosen = [(record["shape"], record["view"], record["consistent"]) for record in records]
    keys = ["shape", "view", "reference"]
    return scores.merge(pd.DataFrame(chosen, columns=keys).astype("string"), on=keys, how="inner")


def paper_frame(comparison: Comparison, table: PaperTable) -> pd.DataFrame:
    """A row for each of the paper's, and for each model that we have of it.

    Columns: method, then each measure as we have it (missing where we have no such row) and as paper_MEASURE, all in
    the paper's units.
    """
    rows = []
    for row, figures in table.rows.items():
        ours = [method for method in comparison.evaluations if method.partition("@")[0] == row]
        for method in ours or [row]:
            mean = comparison.mean(method) if ours else None
            found = {m: None if mean is None else _printed(m, getattr(mean, m)) for m in COLUMNS}
            paper = {f"paper_{measure}": figure for measure, figure in zip(COLUMNS, figures, strict=True)}
            rows.append({"method": method, **found, **paper})
    kinds = {"method": "string", **dict.fromkeys([*COLUMNS, *(f"paper_{m}" for m in COLUMNS)], "float64")}
    return pd.DataFrame(rows).astype(kinds)


def paper_table(frame: pd.DataFrame, table: PaperTable) -> Table:
    """The table for a page: ours, the paper's in small print."""
    best = _best(frame)
    rows: list[list[Cell | str]] = []
    for row in frame.to_dict("records"):
        cells = [
            Cell(_text(m, row[m]), _known(row[m]), row["method"] in best[m], f"paper {_text(m, row[f'paper_{m}'])}")
            for m in COLUMNS
        ]
        rows.append([row["method"], *cells])
    return Table(["Method", *COLUMNS.values()], rows, f"{table.caption}. In small print the paper's own figures.")


def paper_latex(frame: pd.DataFrame, table: PaperTable) -> str:
    """The table in the paper's layout, ours to the left and the paper's figures to the right."""
    best, paper_best = _best(frame), _best(frame, "paper_")
    heads = " & ".join(COLUMNS.values())
    lines = [
        r"\begin{table}",
        r"\begin{center}",
        r"\begin{tabular}{|c|c|c|c||c|c||c|c|c||c|c|}",
        r"\hline",
        r" & \multicolumn{5}{c||}{ours} & \multicolumn{5}{c|}{paper} \\",
        rf"Method & {heads} & {heads} \\",
        r"\hline\hline",
    ]
    for row in frame.to_dict("records"):
        if row["method"].partition("@")[0] == LAST:
            lines.append(r"\cline{1-11}")
        name = row["method"].replace("_", r"\_")
        mine = [_bold(_text(m, row[m]), row["method"] in best[m]) for m in COLUMNS]
        theirs = [_bold(_text(m, row[f"paper_{m}"]), row["method"] in paper_best[m]) for m in COLUMNS]
        lines.append(" & ".join([rf"\emph{{{name}}}", *mine, *theirs]) + r" \\")
    caption = rf"\caption{{{table.caption}. IoU, F1, P, R are in percentages, CD is pixel distance.}}"
    return "\n".join([*lines, r"\hline", r"\end{tabular}", r"\end{center}", caption, r"\end{table}"]) + "\n"


def _best(frame: pd.DataFrame, prefix: str = "") -> dict[str, set[str]]:
    """Measure -> the rows with its best value; none for those that aren't judged by."""
    best: dict[str, set[str]] = {measure: set() for measure in COLUMNS}
    for measure in JUDGED_BY:
        values = frame[prefix + measure]
        goal = values.min() if measure in LOWER_IS_BETTER else values.max()
        best[measure] = set(frame.loc[values == goal, "method"])
    return best


def _printed(measure: str, value: float) -> float:
    """A measure in the paper's units and digits."""
    return float(shown(measure, value))


def _text(measure: str, value: float) -> str:
    """A figure as the paper prints it; a dash for one that is missing."""
    if math.isnan(value):
        return "–"
    return f"{value:.2f}" if measure in LOWER_IS_BETTER else f"{value:.1f}"


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def _bold(text: str, best: bool) -> str:
    return rf"\textbf{{{text}}}" if best else text.replace("–", "--")
