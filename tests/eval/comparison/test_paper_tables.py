"""The paper's tables: its figures hang together as it says, and ours stand in its rows."""

import pandas as pd
import pytest

from eval.comparison import tables
from eval.comparison.paper_tables import TABLES, PaperTable, consistent, paper_frame, paper_latex, paper_table
from eval.measures.evaluation import Settings
from ncmodel.report.html import Cell

COMPETING, NEAREST, NEW, ABLATION, APPENDIX = TABLES


def scores_of(values: dict[str, list[float]]) -> pd.DataFrame:
    """One view; precision and recall of each method against references 0, 1, ..."""
    scores = [
        {"method": row, "reference": str(n), "precision": x, "recall": x, "f1": x, "iou": x, "chamfer": 10 * (1 - x)}
        for row, found in values.items()
        for n, x in enumerate(found)
    ]
    return tables.scores_frame([{"shape": "cow", "view": "0", "scores": scores}])


def frame_of(values: dict[str, list[float]], table: PaperTable = ABLATION) -> pd.DataFrame:
    return paper_frame(tables.comparison_of(scores_of(values), Settings()), table)


@pytest.mark.parametrize("table", TABLES, ids=[table.name for table in TABLES])
def test_the_paper_s_f1_is_that_of_its_precision_and_recall(table: PaperTable) -> None:
    assert list(table.rows)[-1] == "NCs"
    found = [f1 for _, _, f1, _, _ in table.rows.values()]
    exact = [2 * precision * recall / (precision + recall) for *_, precision, recall in table.rows.values()]
    assert found == pytest.approx(exact, abs=0.11)  # all three are rounded


def test_rows_of_the_whole_paper_are_there() -> None:
    assert list(COMPETING.rows) == list(NEAREST.rows) == list(NEW.rows)
    assert [len(table.rows) for table in TABLES] == [9, 9, 9, 5, 6]
    assert ABLATION.rows["NCs"] == APPENDIX.rows["NCs"]


def test_ours_stand_in_the_paper_s_rows_and_units() -> None:
    frame = frame_of({"NC-geometry": [0.5], "NCs": [0.625], "draw": [0.9]}).set_index("method")
    assert list(frame.index) == list(ABLATION.rows)
    assert list(frame.loc["NCs", ["iou", "chamfer", "f1", "precision", "recall"]]) == [62.5, 3.75, 62.5, 62.5, 62.5]
    assert frame.loc["NCs", "paper_iou"] == 62.8
    assert frame.loc[["NC-image"]].isna().to_numpy().sum() == 5


def test_models_beside_each_other_have_rows_of_their_own() -> None:
    frame = frame_of({"NCs@a": [0.5], "NCs@b": [0.6]})
    assert frame["method"].tolist()[-2:] == ["NCs@a", "NCs@b"]
    assert frame["paper_f1"].tolist()[-2:] == [65.4, 65.4]


def test_the_most_consistent_reference_alone_counts_where_it_should() -> None:
    scores = scores_of({"NCs": [0.2, 0.8], "contours": [0.4, 0.6]})
    nearest = consistent(scores, [{"shape": "cow", "view": "0", "consistent": "1"}])
    frame = paper_frame(tables.comparison_of(nearest, Settings()), NEAREST).set_index("method")
    assert frame.loc["NCs", "f1"] == 80.0
    assert frame.loc["contours", "f1"] == 60.0


def test_the_layout_is_the_paper_s() -> None:
    frame = frame_of({"NC-geometry": [0.5], "NCs": [0.625]})
    lines = paper_latex(frame, ABLATION).splitlines()
    assert r"\begin{tabular}{|c|c|c|c||c|c||c|c|c||c|c|}" in lines
    assert lines[lines.index(r"\cline{1-11}") + 1] == (
        r"\emph{NCs} & \textbf{62.5} & \textbf{3.75} & \textbf{62.5} & 62.5 & 62.5 & "
        r"\textbf{62.8} & \textbf{9.54} & \textbf{65.4} & 65.5 & 65.4 \\"
    )
    assert r"\emph{NC-image} & -- & -- & -- & -- & -- & 60.0 & 9.97 & 62.9 & 65.0 & 61.0 \\" in lines


def test_a_page_has_the_paper_s_figures_in_small_print() -> None:
    table = paper_table(frame_of({"NC-geometry": [0.5], "NCs": [0.625]}), ABLATION)
    last = table.rows[-1]
    assert last[0] == "NCs"
    assert last[1] == Cell("62.5", 62.5, True, "paper 62.8")
    assert isinstance(table.rows[1][1], Cell)
    assert table.rows[1][1].text == "–"
