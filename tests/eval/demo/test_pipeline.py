"""The whole pipeline on a tiny case, stopped and started again; what training may see; the page."""

import json
import re
from pathlib import Path

import pytest

from dataset_tools.collection.families import FAMILIES, held_out_families
from eval.comparison.methods import CLASSIC
from eval.demo.pipeline import (
    FULL,
    QUICK,
    Plan,
    bundled_meshes,
    claim_folder,
    held_out_shapes,
    pipeline_stages,
    split_for_training,
)
from eval.demo.report import SMOKE, summary_text, write_demo_report
from eval.demo.stages import run_stages
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, write_pairs
from ncmodel.errors import UsageError

TINY = Plan(
    training=6, test=1, size=128, effort="draft", tuning_views=2, epochs=1, bundled=("cow.obj", "bone.ply"), smoke=True
)
MODELS = {"NC-geometry@model", "NC-image@model", "NCs@model", "NC-geometry@default"}


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a tiny demo, run to its end."""
    out = tmp_path_factory.mktemp("demo") / "out"
    claim_folder(out, "tiny")
    stages = pipeline_stages(out, TINY, seed=0)
    measured = run_stages(stages, out)
    write_demo_report(out, TINY, [(stage, measured[stage.name]) for stage in stages])
    return out


def test_the_road_ends_in_a_judged_model(finished: Path) -> None:
    summary = json.loads((finished / "summary.json").read_text(encoding="utf-8"))
    assert summary["shapes"] == 9
    assert summary["views"] == 18
    assert summary["held_out"] == sorted(held_out_shapes(TINY))
    assert {*CLASSIC, *MODELS} < set(summary["methods"])
    assert all(0.0 <= measures["f1"] <= 1.0 for measures in summary["methods"].values())
    assert summary["methods"]["best of 256"]["f1"] >= summary["methods"]["best of 8"]["f1"]
    order = summary["pair_accuracy"]  # of three held-out shapes, none may have found a consensus
    assert order is None or 0.0 <= order["accuracy"] <= 1.0
    assert any(verdict.startswith("NC-geometry@default is ") for verdict in summary["verdicts"])


def test_a_smoke_test_says_what_it_cannot_show(finished: Path) -> None:
    summary = json.loads((finished / "summary.json").read_text(encoding="utf-8"))
    assert SMOKE in summary_text(summary)
    assert not any(verdict in summary_text(summary) for verdict in summary["verdicts"])
    told = summary_text({**summary, "smoke_test": False})
    assert SMOKE not in told
    assert all(verdict in told for verdict in summary["verdicts"])
    assert "simulated" in told


def test_started_again_it_does_nothing_twice(finished: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in finished.rglob("*") if path.is_file()}
    run_stages(pipeline_stages(finished, TINY, seed=0), finished)
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_the_page_stands_alone_and_says_simulated(finished: Path) -> None:
    page = (finished / "report.html").read_text(encoding="utf-8")
    assert not re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', page)
    assert "simulated" in page
    for stage in pipeline_stages(finished, TINY, seed=0):
        assert stage.title in page


def test_training_sees_nothing_of_held_out_shapes(finished: Path) -> None:
    seen = {json.loads(line)["shape"] for line in (finished / "training-pairs.jsonl").read_text("utf-8").splitlines()}
    assert seen
    assert not seen & set(held_out_shapes(TINY))


def test_the_training_split_watches_other_shapes(tmp_path: Path) -> None:
    shapes = [f"shape{i:02d}" for i in range(20)]
    write_pairs(tmp_path / "pairs.jsonl", [Pair(Item(shape, "0"), 1, 2, "train") for shape in shapes])
    split_for_training(tmp_path / "pairs.jsonl", ["shape03"], tmp_path / "training.jsonl")
    records = [json.loads(line) for line in (tmp_path / "training.jsonl").read_text(encoding="utf-8").splitlines()]
    splits = {name: {r["shape"] for r in records if r["split"] == name} for name in ("train", "validation")}
    assert len(splits["validation"]) == 2
    assert len(splits["train"]) == 17
    assert not splits["train"] & splits["validation"]


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work", encoding="utf-8")
    with pytest.raises(UsageError, match="didn't make"):
        claim_folder(tmp_path, "tiny")


def test_other_settings_need_another_folder(tmp_path: Path) -> None:
    claim_folder(tmp_path / "out", "quick = true")
    claim_folder(tmp_path / "out", "quick = true")
    with pytest.raises(UsageError, match="other settings"):
        claim_folder(tmp_path / "out", "quick = false")


def test_held_out_are_all_real_shapes_and_families_that_nothing_is_trained_on() -> None:
    held_out = held_out_shapes(FULL)
    assert {path.stem for path in bundled_meshes()} < set(held_out)
    made = {name.rpartition("_")[0] for name in held_out} & set(FAMILIES)
    assert made == set(held_out_families())
    (trained,) = (stage for stage in pipeline_stages(Path("out"), FULL, 0) if stage.name == "shapes")
    assert "--split training" in trained.command
    assert not FULL.smoke
    assert QUICK.smoke
