"""A whole comparison on a small folder: its rows, its files, that it goes on where it was stopped, what it refuses."""

import json
import shutil
from pathlib import Path

import pytest

from eval.comparison.candidates import BEST_OF_8, BEST_OF_ALL, CHOSEN, FAVOURITE
from eval.comparison.methods import CLASSIC
from eval.comparison.report import Outcome
from eval.measures.metrics import MEASURES
from ncmodel.cli.main import main
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from tests.helpers.commands import complaint, printed
from tests.helpers.comparisons import HELD_OUT, TRAINED_ON, compare, make_folder

ALL = "contours,boundaries,suggestive,ridges,valleys,apparent"
VIEWS = [f"{HELD_OUT}_{view}" for view in (0, 1)]

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data folder, pairs and a model."""
    return make_folder(tmp_path_factory.mktemp("bench"))


@pytest.fixture(scope="module")
def outcome(root: Path) -> Outcome:
    """A comparison under `root`/report, written."""
    found = compare(root, root / "report")
    found.write()
    return found


def test_all_rows_are_measured_on_the_held_out_views(root: Path, outcome: Outcome) -> None:
    record = json.loads((root / "report" / "compare.json").read_text(encoding="utf-8"))
    learned = ["NC-geometry", "NC-image", "NCs"]
    assert list(record["methods"]) == [*CLASSIC, *learned, BEST_OF_8, BEST_OF_ALL, FAVOURITE]
    for measures in record["methods"].values():
        assert set(measures) == {*MEASURES, "interval"}
        assert 0.0 <= measures["precision"] <= 1.0
        low, high = (measures["interval"]["f1"][end] for end in ("low", "high"))
        assert low - 1e-9 <= measures["f1"] <= high + 1e-9
    assert set(outcome.scores["shape"]) == {HELD_OUT}
    assert (record["views"], record["shapes"], record["references"]) == (2, 1, "simulated")
    against = {(row["method"], row["against"]) for row in record["differences"]}
    assert {("draw", "all-grid"), ("NCs", "all-rtsc"), ("NC-geometry", "AR-grid")} <= against
    # What voters chose is known of one of the two views, so it is no row of the table of all.
    assert CHOSEN in set(outcome.scores["method"])


def test_nothing_is_better_than_the_best_of_what_it_is_among(outcome: Outcome) -> None:
    for record in outcome.records:
        f1 = record["candidates"]["f1"]
        assert len(f1) == 256
        assert record["candidates"]["best"] == f1.index(max(f1))
        assert set(record["rankers"]) == {"", "picture"}
        for said in record["rankers"].values():
            assert len(said["scores"]) == 8
            assert f1[said["favourite"]] <= max(f1)


@pytest.mark.parametrize(
    ("row", "options"),
    [
        ("draw", []),
        ("SC-rtsc", ["--lines", "contours,boundaries,suggestive", "--thresholds", "suggestive=0.01"]),
        ("all-rtsc", ["--lines", ALL, "--thresholds", "suggestive=0.01,ridges=0.1,valleys=0.1,apparent=0.1"]),
        ("NCs", ["--model", "{root}/model.safetensors", "--preset", "draft"]),
    ],
)
def test_drawings_are_the_files_that_draw_writes(
    root: Path, outcome: Outcome, tmp_path: Path, row: str, options: list[str]
) -> None:
    data, item = DataFolder(root / "data"), Item(HELD_OUT, "1")
    out = tmp_path / "drawing.png"
    words = ["draw", data.mesh_path(HELD_OUT), "--camera", data.camera_path(item), "-o", out, *options]
    assert main([str(word).format(root=root) for word in words]) == 0
    assert (root / "report" / "drawings" / row / f"{item.name}.png").read_bytes() == out.read_bytes()


def test_tuned_rows_are_drawn_with_thresholds_in_the_report(root: Path, outcome: Outcome, tmp_path: Path) -> None:
    data, item = DataFolder(root / "data"), Item(HELD_OUT, "0")
    tuned = json.loads((root / "report" / "compare.json").read_text(encoding="utf-8"))["tuned"]
    assert tuned["views"] == 2
    thresholds = ",".join(f"{family}={value}" for family, value in tuned["plans"]["all-grid"]["thresholds"].items())
    lines = ",".join(tuned["plans"]["all-grid"]["families"])
    out = tmp_path / "drawing.png"
    words = ["draw", data.mesh_path(HELD_OUT), "--camera", data.camera_path(item), "-o", out]
    assert main([*map(str, words), "--lines", lines, "--thresholds", thresholds]) == 0
    assert (root / "report" / "drawings" / "all-grid" / f"{item.name}.png").read_bytes() == out.read_bytes()


def test_started_again_it_measures_nothing_twice_and_writes_the_same(root: Path, outcome: Outcome) -> None:
    report = root / "report"
    views = {path: path.stat().st_mtime_ns for folder in ("views", "drawings") for path in (report / folder).rglob("*")}
    before = {path: path.read_bytes() for path in report.rglob("*") if path.is_file()}
    compare(root, report).write()
    assert {path: path.stat().st_mtime_ns for path in views} == views
    assert {path: path.read_bytes() for path in before} == before


def test_a_view_that_was_lost_is_measured_again_to_the_same_bytes(root: Path, outcome: Outcome, tmp_path: Path) -> None:
    shutil.copytree(root / "report", tmp_path / "report")
    lost = tmp_path / "report" / "views" / f"{VIEWS[1]}.json"
    expected = lost.read_bytes()
    lost.unlink()
    compare(root, tmp_path / "report")
    assert lost.read_bytes() == expected


def test_other_settings_measure_views_again(root: Path, outcome: Outcome, tmp_path: Path) -> None:
    shutil.copytree(root / "report", tmp_path / "report")
    wider = compare(root, tmp_path / "report", whole=True)
    assert wider.comparison.mean("contours").recall > outcome.comparison.mean("contours").recall


def test_a_folder_of_drawings_is_a_reference(root: Path, outcome: Outcome, tmp_path: Path) -> None:
    """The simulated artists' drawings, handed in as people's: the same measures."""
    folder = tmp_path / "references" / VIEWS[0]
    shutil.copytree(root / "report" / "references" / VIEWS[0], folder)
    found = compare(root, tmp_path / "report", references=str(tmp_path / "references"))
    assert [record["view"] for record in found.records] == ["0"]
    assert sorted(set(found.scores["reference"])) == [f"{VIEWS[0]}/{number}.png" for number in range(5)]
    expected = outcome.scores[outcome.scores["view"] == "0"]
    for method in ("all-rtsc", "NCs", BEST_OF_ALL):
        mine, theirs = (frame.loc[frame["method"] == method, list(MEASURES)] for frame in (found.scores, expected))
        assert mine.to_numpy() == pytest.approx(theirs.to_numpy())


def test_models_beside_each_other_are_told_apart(root: Path, outcome: Outcome, tmp_path: Path) -> None:
    other = tmp_path / "second.safetensors"
    shutil.copy(root / "model.safetensors", other)
    models = [root / "model.safetensors", other, root / "pictures.safetensors"]
    found = compare(root, tmp_path / "report", models=models)
    same = found.comparison.difference("NCs@second", "NCs@model")
    assert (same.value, same.interval.low, same.interval.high) == (0.0, 0.0, 0.0)
    assert set(found.rankers) == {"model", "model picture", "second", "second picture", "pictures"}


def test_without_a_model_the_classic_methods_are_compared(root: Path, outcome: Outcome, tmp_path: Path) -> None:
    found = compare(root, tmp_path / "report", models=[])
    assert list(found.comparison.evaluations) == [*CLASSIC, BEST_OF_8, BEST_OF_ALL]
    found.write()
    assert (tmp_path / "report" / "report.html").is_file()


def test_the_command_prints_what_it_writes(
    root: Path, outcome: Outcome, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["compare", root / "data", root / "pairs.jsonl", "-o", tmp_path / "report", "--workers", 0]
    chosen = ["--tuning-views", 1, "--views", "all", "--shapes", HELD_OUT, "--baseline", "draw"]
    record = printed(capsys, *words, *chosen)
    assert record == json.loads((tmp_path / "report" / "compare.json").read_text(encoding="utf-8"))
    assert (record["shapes"], record["views"]) == (1, 2)
    assert record["tuned"]["views"] == 1
    assert record["differences"][0]["against"] == "draw"


def test_what_can_not_be_compared_is_one_line(root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data, pairs, model = root / "data", root / "pairs.jsonl", root / "model.safetensors"
    words = [data, pairs, "-o", tmp_path / "report", "--workers", 0]
    lines = pairs.read_text(encoding="utf-8").splitlines(keepends=True)
    only = {split: tmp_path / f"{split}.jsonl" for split in ("train", "validation")}
    for split, path in only.items():
        path.write_text("".join(line for line in lines if f'"{split}"' in line), encoding="utf-8")
    for references in ("elsewhere", "small", "black"):
        (tmp_path / references).mkdir()
    picture = root / "data" / "views" / f"{TRAINED_ON}_0" / "depth.png"
    shutil.copy(data / "views" / f"{TRAINED_ON}_0" / "drawings" / "0.png", tmp_path / "elsewhere" / "moon_0.png")
    shutil.copy(data / "views" / f"{TRAINED_ON}_0" / "renders" / "0.png", tmp_path / "small" / f"{VIEWS[0]}.png")
    shutil.copy(picture, tmp_path / "black" / f"{VIEWS[0]}.png")

    def refused(*changed: object) -> str:
        return complaint(capsys, "compare", *(changed or words))

    assert "none: no folder 'views' in it; expected a data folder" in refused(tmp_path / "none", *words[1:])
    assert "none.jsonl: can't be read" in refused(data, tmp_path / "none.jsonl", *words[2:])
    assert "validation.jsonl: 7 pairs, none to tune baselines on" in refused(data, only["validation"], *words[2:])
    assert "--baseline: found 'best', expected one of contours, SC-rtsc" in refused(*words, "--baseline", "best")
    assert "--views: found 'test', expected one of held-out" in refused(*words, "--views", "test")
    assert "--shapes: found moon, expected shapes of" in refused(*words, "--shapes", f"{HELD_OUT},moon")
    assert "--preset: found 'fast', expected one of" in refused(*words, "--preset", "fast")
    assert "--device: found 'abacus', which torch can't use" in refused(*words, "--device", "abacus")
    assert "no-model: no such file" in refused(*words, "--model", tmp_path / "no-model")
    assert "--model: found two of the name" in refused(*words, "--model", model, "--model", model)
    assert "nobody: doesn't exist" in refused(*words, "--references", tmp_path / "nobody")
    unnamed = refused(*words, "--references", tmp_path / "elsewhere")
    assert "no reference for any view, but for moon_0; expected names as odd_bumpy_0.png" in unnamed
    small = refused(*words, "--references", tmp_path / "small")
    assert f"{VIEWS[0]}.png: 32 x 24 pixels; expected 64 x 48" in small
    assert not (tmp_path / "report").exists()
