"""From the records of views to tables: pure functions of them, as data frames."""

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np
import pandas as pd

from eval.comparison.candidates import BEST_OF_8, BEST_OF_ALL, CHOSEN, FAVOURITE
from eval.comparison.methods import LEARNED
from eval.measures.bootstrap import percentile_interval
from eval.measures.comparison import Comparison
from eval.measures.evaluation import Evaluation, Score, Settings
from eval.measures.metrics import MEASURES, Measures, f1_score
from ncmodel.data.item import Item
from ncmodel.report.intervals import Interval

SCORES = {
    "shape": "string",
    "view": "string",
    "method": "string",
    "reference": "string",
    **dict.fromkeys(MEASURES, "float64"),
}
"""Columns of the table of all scores."""


@dataclass(frozen=True)
class Way:
    """How far a method gets from the baseline to the best of the 256 candidates, in F1.

    Attributes:
        value: 0 at the baseline, 1 at the best of 256.
        interval: Over resampled shapes; None where the two are one.
    """

    value: float | None
    interval: Interval | None


def scores_frame(records: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """A row for each view, method and reference, with the columns `SCORES`."""
    rows = [{"shape": r["shape"], "view": r["view"], **score} for r in records for score in r["scores"]]
    return pd.DataFrame(rows, columns=list(SCORES)).astype(SCORES)


def comparison_of(scores: pd.DataFrame, settings: Settings, seed: int = 0) -> Comparison:
    """The methods that drew all views, beside each other; intervals are over shapes.

    Args:
        scores: As `scores_frame` gives them.
        settings: How drawings were compared.
        seed: Of the resampling.
    """
    evaluations: dict[str, Evaluation] = {}
    shapes: dict[str, str] = {}
    views = scores.groupby(["shape", "view"], sort=False).ngroups
    for method, mine in scores.groupby("method", sort=False):
        if mine.groupby(["shape", "view"], sort=False).ngroups < views:
            continue
        found = []
        for row in mine.to_dict("records"):
            name = Item(row["shape"], row["view"]).name
            shapes[name] = row["shape"]
            found.append(Score(name, row["reference"], Measures(*(row[measure] for measure in MEASURES))))
        evaluations[str(method)] = Evaluation(tuple(found), settings)
    return Comparison(evaluations, shapes.__getitem__, seed)


def agreed(scores: pd.DataFrame) -> pd.DataFrame:
    """The scores of views whose voters agreed on a drawing."""
    chosen = scores.loc[scores["method"] == CHOSEN, ["shape", "view"]].drop_duplicates()
    return scores.merge(chosen, on=["shape", "view"], how="inner")


def learned_rows(methods: Sequence[str]) -> list[str]:
    """The rows of models among all rows."""
    return [row for row in methods if row.partition("@")[0] in LEARNED]


def is_oracle(row: str) -> bool:
    """Whether a row is no method but what could have been chosen."""
    return row in (BEST_OF_8, BEST_OF_ALL, CHOSEN) or row.partition("@")[0] == FAVOURITE


def methods_frame(comparison: Comparison) -> pd.DataFrame:
    """A row a method: each measure, and the ends of its interval as MEASURE_low and MEASURE_high."""
    rows = []
    for method in comparison.evaluations:
        row: dict[str, Any] = {"method": method}
        for measure in MEASURES:
            row[measure] = getattr(comparison.mean(method), measure)
            row[f"{measure}_low"], row[f"{measure}_high"] = astuple(comparison.interval(method, measure))
        rows.append(row)
    return pd.DataFrame(rows)


def differences_frame(comparison: Comparison, baseline: str) -> pd.DataFrame:
    """Paired differences in F1: of every row from the baseline's, and of models' rows from all other methods'.

    Columns: method, against, difference, low, high, clear (the interval leaves out 0; never with one shape alone, which
    has none), wins, shapes.
    """
    rows = list(comparison.evaluations)
    wanted = [(row, baseline) for row in rows if row != baseline]
    wanted += [(row, other) for row in learned_rows(rows) for other in rows if other != row and not is_oracle(other)]
    found = []
    for first, second in dict.fromkeys(wanted):
        difference = comparison.difference(first, second)
        low, high = astuple(difference.interval)
        found.append(
            {
                "method": first,
                "against": second,
                "difference": difference.value,
                "low": low,
                "high": high,
                "clear": difference.clear and difference.shapes > 1,
                "wins": difference.wins,
                "shapes": difference.shapes,
            }
        )
    return pd.DataFrame(found)


def verdict(differences: pd.DataFrame, row: str) -> str:
    """A sentence: which methods a row is ahead of in F1, which are ahead of it, and which can't be told from it."""
    mine = [found for found in json_rows(differences) if found["method"] == row and not is_oracle(found["against"])]
    kinds = {
        "ahead of": [found["against"] for found in mine if found["clear"] and found["difference"] > 0],
        "behind": [found["against"] for found in mine if found["clear"] and found["difference"] < 0],
        "not told from": [found["against"] for found in mine if not found["clear"]],
    }
    return f"{row} is " + "; ".join(f"{kind} {', '.join(rows)}" for kind, rows in kinds.items() if rows) + "."


def way(comparison: Comparison, row: str, baseline: str) -> Way:
    """How far a row gets from the baseline to the best of 256."""
    f1 = {name: comparison.mean(name).f1 for name in (row, baseline, BEST_OF_ALL)}
    samples = {name: comparison.samples[name]["f1"] for name in f1}
    room = samples[BEST_OF_ALL] - samples[baseline]
    if f1[BEST_OF_ALL] == f1[baseline] or not room.all():
        return Way(None, None)
    value = (f1[row] - f1[baseline]) / (f1[BEST_OF_ALL] - f1[baseline])
    return Way(value, percentile_interval((samples[row] - samples[baseline]) / room))


def views_frame(scores: pd.DataFrame) -> pd.DataFrame:
    """F1 of each method (columns) on each view (rows, by shape and view), from mean precision and recall."""
    means = scores.groupby(["shape", "view", "method"], sort=False)[["precision", "recall"]].mean()
    f1 = [f1_score(*pair) for pair in means.itertuples(index=False)]
    return pd.Series(f1, index=means.index, dtype="float64").unstack("method")


def failures_frame(scores: pd.DataFrame, row: str, baseline: str) -> pd.DataFrame:
    """Views by how far a model's F1 lies below the best of 256, the worst first.

    Columns: shape, view, f1, best, baseline, shortfall.
    """
    f1 = views_frame(scores)
    found = pd.DataFrame({"f1": f1[row], "best": f1[BEST_OF_ALL], "baseline": f1[baseline]})
    found["shortfall"] = found["best"] - found["f1"]
    found = found.reset_index().sort_values(["shortfall", "shape", "view"], ascending=[False, True, True])
    return found.reset_index(drop=True)


def to_latex(comparison: Comparison, caption: str) -> str:
    """The table of methods for a paper: percentages, Chamfer in pixels, intervals of F1; the best of each is bold."""
    from eval.measures.comparison import COLUMNS, JUDGED_BY, shown

    best = {measure: comparison.best(measure) if measure in JUDGED_BY else frozenset() for measure in COLUMNS}
    lines = [
        r"\begin{table}",
        rf"\caption{{{_tex(caption)}}}",
        rf"\begin{{tabular}}{{l{'r' * len(COLUMNS)}r}}",
        r"\hline",
        " & ".join(["Method", *COLUMNS.values(), r"F1, 95\,\%"]) + r" \\",
        r"\hline",
    ]
    for method in comparison.evaluations:
        cells = [shown(measure, getattr(comparison.mean(method), measure)) for measure in COLUMNS]
        cells = [
            rf"\textbf{{{cell}}}" if method in best[measure] else cell
            for cell, measure in zip(cells, COLUMNS, strict=True)
        ]
        low, high = (shown("f1", end) for end in astuple(comparison.interval(method, "f1")))
        lines.append(" & ".join([_tex(method), *cells, f"{low}--{high}"]) + r" \\")
    return "\n".join([*lines, r"\hline", r"\end{tabular}", r"\end{table}"]) + "\n"


def _tex(text: str) -> str:
    return "".join(f"\\{letter}" if letter in "&%$#_{}" else letter for letter in text)


def json_rows(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows as JSON-ready values."""
    return [
        {str(key): value.item() if isinstance(value, np.generic) else value for key, value in row.items()}
        for row in frame.to_dict("records")
    ]
