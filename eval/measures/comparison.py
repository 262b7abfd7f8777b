"""Methods beside each other: means with confidence intervals, the best of each measure, and paired differences."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd

from eval.measures.bootstrap import percentile_interval, resampled_means
from eval.measures.evaluation import Evaluation, Score, Settings, targets
from eval.measures.metrics import LOWER_IS_BETTER, MEASURES, Measures
from ncmodel.data.item import Item
from ncmodel.errors import UsageError
from ncmodel.report.html import Cell, Table
from ncmodel.report.intervals import Interval
from ncmodel.report.text import text_table
from ncmodel.types import Floats, Image, Mask

COLUMNS = {"iou": "IoU", "chamfer": "CD", "f1": "F1", "precision": "P", "recall": "R"}
"""Measure -> heading, in the paper's order."""

JUDGED_BY = ("iou", "chamfer", "f1")
"""The measures whose best is marked: precision or recall alone is easily won by drawing little or much."""


@dataclass(frozen=True)
class Difference:
    """How much better or worse one method is than another on the same drawings.

    Attributes:
        value: Mean measure of the first minus that of the second.
        interval: Of the value, over resampled shapes.
        wins: Shapes on which the first is better.
        shapes: Shapes compared.
    """

    value: float
    interval: Interval
    wins: int
    shapes: int

    @property
    def clear(self) -> bool:
        """Whether the interval leaves out zero."""
        return 0.0 not in self.interval


def shape_of(name: str) -> str:
    """The shape a drawing shows: its name without the number of the view, SHAPE_VIEW."""
    try:
        item = Item.named(name)
    except ValueError:
        return name
    return item.shape if item.view.isdecimal() else name


@dataclass(frozen=True)
class Comparison:
    """Several methods on the same drawings.

    Attributes:
        evaluations: Method -> its scores; all over the same drawings and references in the same order.
        shape: Drawing's name -> the shape it shows, over which intervals resample.
        seed: Of the resampling.
    """

    evaluations: Mapping[str, Evaluation]
    shape: Callable[[str], str] = field(default=shape_of)
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.evaluations:
            raise ValueError("no methods to compare")
        pairs = {tuple((s.name, s.reference) for s in e.scores) for e in self.evaluations.values()}
        if len(pairs) > 1:
            raise ValueError("the methods were not evaluated on the same drawings and references")

    @cached_property
    def shapes(self) -> tuple[str, ...]:
        """The shape of each score, in order."""
        first = next(iter(self.evaluations.values()))
        return tuple(self.shape(score.name) for score in first.scores)

    @cached_property
    def samples(self) -> dict[str, dict[str, Floats]]:
        """Method -> measure -> its mean over each resampling of the shapes; the same shapes for every method."""
        return {
            method: with_f1(resampled_means(measures_array(evaluation.scores), self.shapes, self.seed))
            for method, evaluation in self.evaluations.items()
        }

    def mean(self, method: str) -> Measures:
        """A method's measures over all drawings."""
        return self.evaluations[method].mean

    def interval(self, method: str, measure: str) -> Interval:
        """95 % confidence interval of a method's mean, over resampled shapes."""
        return percentile_interval(self.samples[method][measure])

    def to_frame(self) -> pd.DataFrame:
        """A row a method and measure: `method`, `measure` (string), `mean`, `low`, `high` (float64).

        `low` and `high` are the ends of the mean's 95 % confidence interval.
        """
        rows = [
            (method, measure, getattr(self.mean(method), measure), *astuple(self.interval(method, measure)))
            for method in self.evaluations
            for measure in MEASURES
        ]
        types = {"method": "string", "measure": "string", "mean": "float64", "low": "float64", "high": "float64"}
        return pd.DataFrame(rows, columns=list(types)).astype(types)

    def best(self, measure: str) -> frozenset[str]:
        """The methods with the best mean."""
        means = {method: getattr(self.mean(method), measure) for method in self.evaluations}
        goal = min(means.values()) if measure in LOWER_IS_BETTER else max(means.values())
        return frozenset(method for method, value in means.items() if value == goal)

    def difference(self, first: str, second: str, measure: str = "f1") -> Difference:
        """`first` minus `second`, paired by drawing."""
        samples = self.samples[first][measure] - self.samples[second][measure]
        by_shape = [self._by_shape(method, measure) for method in (first, second)]
        ahead = by_shape[0] < by_shape[1] if measure in LOWER_IS_BETTER else by_shape[0] > by_shape[1]
        return Difference(
            value=getattr(self.mean(first), measure) - getattr(self.mean(second), measure),
            interval=percentile_interval(samples),
            wins=int(np.count_nonzero(ahead)),
            shapes=len(ahead),
        )

    def _by_shape(self, method: str, measure: str) -> Floats:
        values = measures_array(self.evaluations[method].scores)
        labels = np.array(self.shapes)
        means = np.stack([values[labels == shape].mean(axis=0) for shape in dict.fromkeys(self.shapes)])
        return with_f1(means)[measure]


def compare(
    methods: Mapping[str, Mapping[str, Image]],
    references: Mapping[str, Sequence[Image]],
    settings: Settings | None = None,
    silhouettes: Mapping[str, Mask] | None = None,
    shape: Callable[[str], str] = shape_of,
    seed: int = 0,
) -> Comparison:
    """Measure several methods' drawings of the same views against the same references.

    Args:
        methods: Method -> drawing's name -> (H, W) ink; every method needs the same names.
        references: Name -> one or more (H, W) inks.
        settings: How drawings are compared.
        silhouettes: Name -> (H, W) the object's filled mask or drawn outline, removed from all drawings.
        shape: Drawing's name -> the shape it shows.
        seed: Of the resampling.

    Raises:
        UsageError: A method lacks a drawing that another has, a drawing has no reference, or sizes differ.
    """
    how = settings or Settings()
    names = list(next(iter(methods.values()), {}))
    for method, drawings in methods.items():
        if odd := sorted(set(names) ^ set(drawings)):
            raise UsageError(f"{method}: its drawings aren't those of the other methods ({odd[0]} is in one only)")
    scores: dict[str, list[Score]] = {method: [] for method in methods}
    for target in targets(names, references, how, silhouettes):
        for method, drawings in methods.items():
            scores[method] += target.scores(target.prepare(drawings[target.name]))
    return Comparison({method: Evaluation(tuple(found), how) for method, found in scores.items()}, shape, seed)


def measures_array(scores: Sequence[Score]) -> Floats:
    """(N, M) the measures of N scores, in the order of `MEASURES`."""
    return np.array([[getattr(score.measures, name) for name in MEASURES] for score in scores], dtype=np.float64)


def with_f1(means: Floats) -> dict[str, Floats]:
    """Measure -> (R,) means, F1 computed from precision and recall, from (R, M) means in the order of `MEASURES`."""
    columns = {name: means[:, number] for number, name in enumerate(MEASURES)}
    precision, recall = columns["precision"], columns["recall"]
    total = precision + recall
    return {**columns, "f1": np.divide(2.0 * precision * recall, total, out=np.zeros_like(total), where=total > 0.0)}


def shown(measure: str, value: float) -> str:
    """A value as the paper's tables print it: percentages with one digit, Chamfer in pixels with two."""
    return f"{value:.2f}" if measure in LOWER_IS_BETTER else f"{100.0 * value:.1f}"


def comparison_table(comparison: Comparison, caption: str = "") -> Table:
    """The paper's table: a row a method, the best value of each measure in bold, intervals beside the values."""
    best = _best(comparison)

    def cell(method: str, measure: str) -> Cell:
        value = getattr(comparison.mean(method), measure)
        return Cell(shown(measure, value), value, method in best[measure], _interval_note(comparison, method, measure))

    rows: list[list[Cell | str]] = [
        [method, *(cell(method, measure) for measure in COLUMNS)] for method in comparison.evaluations
    ]
    return Table(["Method", *COLUMNS.values()], rows, caption)


def comparison_text(comparison: Comparison) -> str:
    """The table as plain text, the best of each measure marked with a star."""
    best = _best(comparison)
    rows = [["Method", *COLUMNS.values()]]
    for method in comparison.evaluations:
        mean = comparison.mean(method)
        cells = [shown(m, getattr(mean, m)) + ("*" if method in best[m] else " ") for m in COLUMNS]
        rows.append([method, *cells])
    return text_table(rows)


def difference_table(comparison: Comparison, first: str, measure: str = "f1", caption: str = "") -> Table:
    """One method against each other one: the difference of a measure, its interval, and the shapes won."""
    rows: list[list[Cell | str]] = []
    for second in comparison.evaluations:
        if second != first:
            found = comparison.difference(first, second, measure)
            low, high = (_signed(measure, end) for end in (found.interval.low, found.interval.high))
            rows.append(
                [
                    second,
                    Cell(_signed(measure, found.value), found.value, found.clear, f"{low} to {high}"),
                    Cell(f"{found.wins} of {found.shapes}", found.wins / found.shapes),
                ]
            )
    return Table([f"{first} against", f"Difference in {COLUMNS[measure]}", "Shapes won"], rows, caption)


def _best(comparison: Comparison) -> dict[str, frozenset[str]]:
    if len(comparison.evaluations) == 1:
        return dict.fromkeys(COLUMNS, frozenset())
    return {measure: comparison.best(measure) if measure in JUDGED_BY else frozenset() for measure in COLUMNS}


def _interval_note(comparison: Comparison, method: str, measure: str) -> str:
    if len(set(comparison.shapes)) < 2:
        return ""  # nothing to resample
    interval = comparison.interval(method, measure)
    return f"{shown(measure, interval.low)} to {shown(measure, interval.high)}"


def _signed(measure: str, value: float) -> str:
    return ("+" if value > 0 else "") + shown(measure, value)
