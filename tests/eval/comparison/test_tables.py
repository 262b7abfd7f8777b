"""Tables of a comparison: pure functions of scores, held against numbers worked out by hand."""

import numpy as np
import pandas as pd
import pytest

from eval.comparison import tables
from eval.comparison.candidates import BEST_OF_ALL, CHOSEN, FAVOURITE
from eval.measures.evaluation import Settings

SETTINGS = Settings()


def record(shape: str, view: str, f1: dict[str, float], references: int = 1) -> dict[str, object]:
    """A view on which each method has this precision and recall, and so this F1."""
    scores = [
        {"method": row, "reference": str(n), "precision": x, "recall": x, "f1": x, "iou": x, "chamfer": 10 * (1 - x)}
        for row, x in f1.items()
        for n in range(references)
    ]
    return {"shape": shape, "view": view, "scores": scores}


def rows(all_grid: float, ncs: float, best: float) -> dict[str, float]:
    return {"all-grid": all_grid, "NCs": ncs, BEST_OF_ALL: best}


def means(scores: pd.DataFrame) -> dict[str, dict[str, float]]:
    """Method -> column -> value."""
    frame = tables.methods_frame(tables.comparison_of(scores, SETTINGS))
    return {row.pop("method"): row for row in tables.json_rows(frame)}


@pytest.fixture
def scores() -> pd.DataFrame:
    """Three shapes; the model is ahead on two of them."""
    return tables.scores_frame(
        [
            record("cow", "0", rows(0.5, 0.6, 0.9), references=2),
            record("cow", "1", rows(0.5, 0.8, 0.9), references=2),
            record("fox", "0", rows(0.4, 0.6, 0.8), references=2),
            record("owl_a", "0", {**rows(0.7, 0.4, 0.8), CHOSEN: 0.75}, references=2),
        ]
    )


def test_means_are_over_views(scores: pd.DataFrame) -> None:
    found = means(scores)
    f1 = {method: row["f1"] for method, row in found.items()}
    assert f1 == pytest.approx({"all-grid": 0.525, "NCs": 0.6, BEST_OF_ALL: 0.85})
    assert found["NCs"]["chamfer"] == pytest.approx(4.0)
    assert all(row["f1_low"] <= row["f1"] <= row["f1_high"] for row in found.values())


def test_a_row_of_some_views_only_is_told_on_these(scores: pd.DataFrame) -> None:
    assert CHOSEN not in tables.comparison_of(scores, SETTINGS).evaluations
    agreed = tables.comparison_of(tables.agreed(scores), SETTINGS)
    assert agreed.mean(CHOSEN).f1 == pytest.approx(0.75)
    assert agreed.mean("NCs").f1 == pytest.approx(0.4)


def test_intervals_are_over_shapes_not_views() -> None:
    """Twenty views of one shape tell no more about other shapes than one does."""
    shapes = (("cow", 0.6), ("fox", 0.8))
    few = [record(shape, "0", rows(0.5, f1, 0.9)) for shape, f1 in shapes]
    many = [record(shape, str(view), rows(0.5, f1, 0.9)) for shape, f1 in shapes for view in range(20)]
    rows_of_model = [means(tables.scores_frame(records))["NCs"] for records in (few, many)]
    widths = [row["f1_high"] - row["f1_low"] for row in rows_of_model]
    assert widths[0] == pytest.approx(0.2)
    assert widths[1] == pytest.approx(widths[0])


def test_differences_are_paired(scores: pd.DataFrame) -> None:
    found = tables.differences_frame(tables.comparison_of(scores, SETTINGS), "all-grid")
    by_method = {row["method"]: row for row in tables.json_rows(found)}
    first, best = by_method["NCs"], by_method[BEST_OF_ALL]
    assert first["difference"] == pytest.approx(0.075)
    assert (first["wins"], first["shapes"], first["clear"]) == (2, 3, False)
    assert best["clear"]
    assert best["low"] > 0.0


def test_one_shape_alone_tells_nothing_apart() -> None:
    comparison = tables.comparison_of(tables.scores_frame([record("cow", "0", rows(0.2, 0.8, 0.9))]), SETTINGS)
    assert not tables.differences_frame(comparison, "all-grid")["clear"].any()


def test_a_sentence_says_which_methods_a_model_is_ahead_of() -> None:
    values = {"contours": 0.3, "all-rtsc": 0.62, "all-grid": 0.61, "NCs": 0.6, "draw": 0.9, BEST_OF_ALL: 0.95}
    records = [
        record(shape, "0", {row: f1 + (wobble if row == "NCs" else 0.0) for row, f1 in values.items()})
        for shape, wobble in (("cow", 0.1), ("fox", -0.1), ("owl", 0.05))
    ]
    found = tables.differences_frame(tables.comparison_of(tables.scores_frame(records), SETTINGS), "all-grid")
    expected = "NCs is ahead of contours; behind draw; not told from all-grid, all-rtsc."
    assert tables.verdict(found, "NCs") == expected


def test_models_are_set_against_every_method_but_no_oracle() -> None:
    favourite = f"{FAVOURITE}@a"
    values = {"all-rtsc": 0.5, "all-grid": 0.5, "NCs@a": 0.6, "NCs@b": 0.6, BEST_OF_ALL: 0.9, favourite: 0.7}
    comparison = tables.comparison_of(tables.scores_frame([record("cow", "0", values)]), SETTINGS)
    found = tables.differences_frame(comparison, "all-grid")
    pairs = set(zip(found["method"], found["against"], strict=True))
    assert len(pairs) == len(found)
    assert {(row, "all-grid") for row in values if row != "all-grid"} <= pairs
    assert {("NCs@a", "NCs@b"), ("NCs@b", "all-rtsc")} <= pairs
    assert not {against for _, against in pairs} & {BEST_OF_ALL, favourite}


def test_the_way_to_the_best_choice(scores: pd.DataFrame) -> None:
    comparison = tables.comparison_of(scores, SETTINGS)
    way = tables.way(comparison, "NCs", "all-grid")
    assert way.value == pytest.approx(0.075 / 0.325)
    assert way.interval is not None
    assert way.value is not None
    assert way.interval.low < way.value < way.interval.high
    assert tables.way(comparison, BEST_OF_ALL, "all-grid").value == 1.0
    assert tables.way(comparison, "NCs", BEST_OF_ALL).value is None


def test_views_are_sorted_by_how_badly_the_model_fails(scores: pd.DataFrame) -> None:
    found = tables.failures_frame(scores, "NCs", "all-grid")
    assert [(row["shape"], row["view"]) for row in found.to_dict("records")] == [
        ("owl_a", "0"),
        ("cow", "0"),
        ("fox", "0"),
        ("cow", "1"),
    ]
    assert found["shortfall"].tolist() == pytest.approx([0.4, 0.3, 0.2, 0.1])
    assert found["baseline"].tolist() == pytest.approx([0.7, 0.5, 0.4, 0.5])


def test_f1_of_a_view_is_that_of_mean_precision_and_recall() -> None:
    """Two references: P 1 and 0, R 0.5 and 0.5, so mean P 0.5, mean R 0.5."""
    view = record("cow", "0", rows(0.5, 0.5, 0.5), references=2)
    for score, precision in zip(view["scores"], (1.0, 0.0) * 3, strict=True):  # type: ignore[call-overload]
        score.update(precision=precision, recall=0.5, f1=0.0)
    np.testing.assert_allclose(tables.views_frame(tables.scores_frame([view])).to_numpy(), 0.5)


def test_the_table_for_a_paper_marks_the_best_and_escapes(scores: pd.DataFrame) -> None:
    text = tables.to_latex(tables.comparison_of(scores, SETTINGS), "95 % of it")
    assert r"\caption{95 \% of it}" in text
    assert r"NCs & 60.0 & 4.00 & 60.0 & 60.0 & 60.0 &" in text
    assert rf"{BEST_OF_ALL} & \textbf{{85.0}} & \textbf{{1.50}} & \textbf{{85.0}} & 85.0 & 85.0 &" in text
