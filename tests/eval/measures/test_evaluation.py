"""Drawings against references in memory: pairs, silhouettes, several references, methods beside each other."""

from typing import Any

import numpy as np
import pytest

from eval.measures.comparison import compare, comparison_table, comparison_text, difference_table, shape_of
from eval.measures.evaluation import Settings, Target, evaluate
from eval.measures.metrics import MEASURES, Measures, f1_score
from eval.measures.report import EXTRA, HIT, MISS, REMOVED, overlay
from ncmodel.errors import UsageError
from ncmodel.report.html import Cell
from ncmodel.types import Image

SIZE = (60, 80)
CLOSE = Settings(tolerance_pixels=2.0)


def strokes(*rows: int, size: tuple[int, int] = SIZE) -> Image:
    """Horizontal lines, as long as the picture is wide."""
    ink = np.zeros(size, np.float32)
    for row in rows:
        ink[row] = 1.0
    return ink


def test_a_drawing_meets_each_of_its_references() -> None:
    found = evaluate({"a_0": strokes(10)}, {"a_0": [strokes(11), strokes(30)], "unused": [strokes(1)]}, CLOSE)
    assert [(score.name, score.reference) for score in found.scores] == [("a_0", "0"), ("a_0", "1")]
    assert [score.measures for score in found.scores] == [Measures(1, 1, 1, 1, 1), Measures(0, 0, 0, 0, 20)]
    assert found.mean == Measures(0.5, 0.5, 0.5, 0.5, 10.5)


def test_scores_and_comparisons_are_tables() -> None:
    references = {"a_0": [strokes(11), strokes(30)], "b_0": [strokes(20)]}
    drawings = {"a_0": strokes(10), "b_0": strokes(40)}
    scores = evaluate(drawings, references, CLOSE).to_frame()
    assert scores.dtypes.astype(str).to_dict() == {
        "name": "string", "reference": "string", **dict.fromkeys(MEASURES, "float64"),
    }  # fmt: skip
    assert scores["name"].tolist() == ["a_0", "a_0", "b_0"]
    assert scores.groupby("name")["precision"].mean().to_dict() == {"a_0": 0.5, "b_0": 0.0}
    found = compare({"ours": drawings, "others": {"a_0": strokes(30), "b_0": strokes(20)}}, references, CLOSE)
    table = found.to_frame().set_index(["method", "measure"])
    assert set(table.index) == {(method, measure) for method in ("ours", "others") for measure in MEASURES}
    assert table.dtypes.astype(str).to_dict() == dict.fromkeys(("mean", "low", "high"), "float64")
    row: Any = table.loc[("others", "chamfer")]
    assert (row["mean"], row["low"], row["high"]) == (
        found.mean("others").chamfer, found.interval("others", "chamfer").low, found.interval("others", "chamfer").high,
    )  # fmt: skip


def test_every_pair_counts_once_in_the_mean() -> None:
    drawings = {"a_0": strokes(10), "b_0": strokes(10)}
    references = {"a_0": [strokes(10)] * 3, "b_0": [strokes(40)]}
    assert evaluate(drawings, references, CLOSE).mean.precision == 0.75


def test_the_most_consistent_reference_can_stand_alone() -> None:
    how = Settings(tolerance_pixels=2.0, most_consistent=True)
    found = evaluate({"a": strokes(20)}, {"a": [strokes(50), strokes(20), strokes(18)]}, how)
    assert [score.reference for score in found.scores] == ["1"]


def test_silhouettes_are_taken_away_from_both() -> None:
    mask = np.zeros(SIZE, bool)
    mask[10:50, :] = True
    drawing, reference = strokes(10, 30), strokes(9, 49, 33)
    assert evaluate({"a": drawing}, {"a": [reference]}, CLOSE).mean.precision == 0.5
    found = evaluate({"a": drawing}, {"a": [reference]}, CLOSE, {"a": mask})
    assert found.mean == Measures(0, 0, 0, 0, 3)


def test_a_drawing_of_the_silhouette_alone_is_an_empty_one() -> None:
    mask = np.zeros(SIZE, bool)
    mask[10:50, :] = True
    found = evaluate({"a": strokes(10)}, {"a": [strokes(10)]}, CLOSE, {"a": mask})
    assert found.mean == Measures(1, 1, 1, 1, 0)


def test_faint_lines_are_dropped_by_the_threshold() -> None:
    drawing = strokes(10) + 0.4 * strokes(40)
    assert evaluate({"a": drawing}, {"a": [strokes(10)]}, CLOSE).mean.precision == 1.0
    assert evaluate({"a": drawing}, {"a": [strokes(10)]}, Settings(2.0, 0.3)).mean.precision == 0.5


def test_what_does_not_fit_is_said() -> None:
    with pytest.raises(UsageError, match="a: 0 is 80 x 60 pixels, 1 is 70 x 60 pixels; expected the same size"):
        evaluate({"a": strokes(1)}, {"a": [strokes(1), strokes(1, size=(60, 70))]})
    with pytest.raises(UsageError, match="a: 0 is 80 x 60 pixels, its silhouette is 80 x 61 pixels"):
        evaluate({"a": strokes(1)}, {"a": [strokes(1)]}, silhouettes={"a": np.zeros((61, 80), bool)})
    with pytest.raises(UsageError, match="a: the drawing is 30 x 20 pixels, 0 is 80 x 60 pixels"):
        evaluate({"a": strokes(1, size=(20, 30))}, {"a": [strokes(1)]})
    with pytest.raises(UsageError, match="b: no reference"):
        evaluate({"b": strokes(1)}, {"a": [strokes(1)]})
    with pytest.raises(UsageError, match="a: no silhouette"):
        evaluate({"a": strokes(1)}, {"a": [strokes(1)]}, silhouettes={"b": np.zeros(SIZE, bool)})
    for tolerance, threshold in ((-1.0, 0.5), (float("inf"), 0.5), (1.0, 0.0)):
        with pytest.raises(UsageError, match="expected"):
            Settings(tolerance, threshold)
    with pytest.raises(ValueError, match="at least one"):
        evaluate({}, {})


def drawings_and_references() -> tuple[dict[str, dict[str, Image]], dict[str, list[Image]]]:
    """ "near" misses by 1 px, "far" by 6 px on most shapes, "half" finds one line of two."""
    names = [f"shape{shape}_{view}" for shape in range(5) for view in range(2)]
    references = {name: [strokes(10, 30)] for name in names}
    methods = {
        "near": {name: strokes(11, 31) for name in names},
        "far": {name: strokes(16, 36) if name[5] != "0" else strokes(11, 31) for name in names},
        "half": {name: strokes(10) for name in names},
    }
    return methods, references


def test_methods_beside_each_other() -> None:
    found = compare(*drawings_and_references(), CLOSE)
    assert found.mean("near") == Measures(1, 1, 1, 1, 1)
    assert found.mean("half").f1 == f1_score(1.0, 0.5)
    assert found.best("f1") == found.best("iou") == {"near"}
    assert found.best("precision") == {"near", "half"}
    assert found.best("chamfer") == {"near"}
    assert set(found.shapes) == {f"shape{n}" for n in range(5)}


def test_intervals_are_paired_and_hold_the_mean() -> None:
    found = compare(*drawings_and_references(), CLOSE)
    interval = found.interval("far", "f1")
    assert interval.low < found.mean("far").f1 < interval.high
    assert found.interval("near", "f1") == found.interval("near", "iou")
    ahead = found.difference("near", "far")
    assert (ahead.wins, ahead.shapes) == (4, 5)
    assert ahead.value == pytest.approx(0.8)
    assert ahead.clear
    assert not found.difference("near", "near").clear
    lower = found.difference("near", "far", "chamfer")
    assert lower.wins == 4
    assert lower.value == pytest.approx(-4.0)


def test_another_order_of_methods_changes_no_number() -> None:
    methods, references = drawings_and_references()
    there, back = compare(methods, references, CLOSE), compare(dict(reversed(methods.items())), references, CLOSE)
    assert there.difference("near", "far") == back.difference("near", "far")


def test_the_table_marks_the_best_in_the_order_of_the_paper() -> None:
    table = comparison_table(compare(*drawings_and_references(), CLOSE))
    assert list(table.columns) == ["Method", "IoU", "CD", "F1", "P", "R"]
    assert [[cell.text for cell in row if cell.best] for row in table.cells] == [["100.0", "1.00", "100.0"], [], []]
    cell = table.cells[0][1]
    assert isinstance(cell, Cell)
    assert cell.note == "100.0 to 100.0"


def test_one_shape_has_no_interval_to_show() -> None:
    table = comparison_table(
        compare({"a": {"x_0": strokes(1), "x_1": strokes(9)}}, {"x_0": [strokes(1)], "x_1": [strokes(1)]})
    )
    assert [cell.note for cell in table.cells[0]] == [""] * 6


def test_the_text_lines_up() -> None:
    lines = comparison_text(compare(*drawings_and_references(), CLOSE)).splitlines()
    assert len({len(line) for line in lines}) == 1
    assert lines[1].split() == ["near", "100.0*", "1.00*", "100.0*", "100.0", "100.0"]


def test_one_method_against_the_others() -> None:
    table = difference_table(compare(*drawings_and_references(), CLOSE), "near")
    assert [row[0].text for row in table.cells] == ["far", "half"]
    assert table.cells[0][1].text == "+80.0"
    assert table.cells[0][2].text == "4 of 5"


def test_methods_must_draw_the_same_views() -> None:
    methods, references = drawings_and_references()
    del methods["half"]["shape0_1"]
    with pytest.raises(UsageError, match=r"half: its drawings aren't those of the other methods \(shape0_1"):
        compare(methods, references)


@pytest.mark.parametrize(
    ("name", "shape"), [("bunny_0", "bunny"), ("a_b_12", "a_b"), ("cow", "cow"), ("x_1a", "x_1a"), ("_3", "_3")]
)
def test_the_shape_of_a_view(name: str, shape: str) -> None:
    assert shape_of(name) == shape


def test_an_overlay_tells_hits_extras_and_misses_apart() -> None:
    mask = np.zeros(SIZE, bool)
    mask[5:, :] = True
    target = Target.of("a", {"r": strokes(20, 40)}, CLOSE, mask)
    picture = overlay(target.prepare(strokes(20, 30)), target.references["r"], 2.0, target.removed)
    assert [tuple(picture[row, 40]) for row in (20, 30, 40, 5, 50)] == [HIT, EXTRA, MISS, REMOVED, (255, 255, 255)]


def test_an_overlay_of_empty_drawings() -> None:
    target = Target.of("a", {"r": strokes(20)}, CLOSE)
    assert tuple(overlay(target.prepare(strokes()), target.references["r"], 2.0)[20, 3]) == MISS
    empty = Target.of("a", {"r": strokes()}, CLOSE)
    assert tuple(overlay(empty.prepare(strokes(20)), empty.references["r"], 2.0)[20, 3]) == EXTRA
