"""The whole pipeline on a tiny case, stopped and started again; what training may see; the page."""

import json
import re
from pathlib import Path

import pytest

from eval.demo.held_out import split_for_training
from eval.demo.pipeline import FULL, Plan, bundled_meshes, claim_folder, held_out_shapes, pipeline_stages
from eval.demo.report import METHODS, summary_text, write_demo_report
from eval.demo.stages import run_stages
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, write_pairs
from ncmodel.errors import UsageError

TINY = Plan(
    made=7,
    held_out=1,
    size=128,
    effort="draft",
    epochs=1,
    bundled=("cow.obj", "bone.ply"),
    real_held_out=("cow",),
)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a tiny demo, run to its end."""
    out = tmp_path_factory.mktemp("demo") / "out"
    claim_folder(out, "tiny")
    stages = pipeline_stages(out, TINY, seed=0)
    measured = run_stages(stages, out)
    write_demo_report(out, [(stage, measured[stage.name]) for stage in stages])
    return out


def test_the_road_ends_in_a_judged_model(finished: Path) -> None:
    summary = json.loads((finished / "summary.json").read_text(encoding="utf-8"))
    assert summary["shapes"] == 9
    assert summary["views"] == 18
    assert summary["held_out"] == sorted(held_out_shapes(TINY))
    assert tuple(summary["methods"]) == METHODS
    assert all(0.0 <= summary["methods"][method]["f1"] <= 1.0 for method in METHODS)
    # Apparent ridges come on top of the contours, so they find hardly less of what artists drew: crumbs of both go.
    assert summary["methods"]["AR-rtsc"]["recall"] > summary["methods"]["contours"]["recall"] - 0.02 > 0.0
    order = summary["pair_accuracy"]  # of two held-out shapes, none may have found a consensus
    assert order is None or 0.0 <= order["accuracy"] <= 1.0
    assert "simulated" in summary_text(summary)


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


def test_the_full_demo_holds_out_real_and_made_shapes() -> None:
    held_out = held_out_shapes(FULL)
    assert {"bunny", "cow"} < set(held_out)
    assert len(set(held_out)) >= 4
    assert FULL.made + len(bundled_meshes()) >= 16
