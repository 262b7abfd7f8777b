"""All stages: files, seeds, stages one by one, and what a later run leaves as it is."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel.errors import UsageError
from ncmodel.nets.checkpoints import load_checkpoint, load_tensors, save_tensors
from ncmodel.nets.presets import Rates
from ncmodel.training.state import STATE_KIND
from ncmodel.training.train import TrainOptions, run_training
from tests.helpers.micro_training import MICRO, run

pytestmark = pytest.mark.usefixtures("one_thread")


def test_all_stages_write_a_checkpoint_a_history_and_states(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "m.ckpt"
    report = run(data, out)
    assert [(stage.stage, stage.epochs) for stage in report.stages] == [
        ("ranker", 3),
        ("translator", 3),
        ("finetune", 2),
    ]
    assert report.pairs == {"train": 3 * 2 * 7, "validation": 2 * 7}
    loaded = load_checkpoint(out)
    assert loaded.preset == MICRO
    assert list(loaded.networks) == ["ranker", "translator"]
    assert set(loaded.training["stages"]) == {"ranker", "translator", "finetune"}
    history = json.loads((tmp_path / "m.ckpt.history.json").read_text())
    assert history == report.history
    assert [record["epoch"] for record in history["ranker"]] == [1, 2, 3]
    assert set(history["finetune"][0]) == {"epoch", "loss", "accuracy", "hinge", "cross_entropy"}
    assert not list(tmp_path.glob(".tmp*"))


def test_the_same_seed_gives_the_same_bytes_and_another_one_others(data: Path, tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        run(data, tmp_path / name, stages=("ranker",), seed=seed)
    a, b, c = ((tmp_path / name).read_bytes() for name in "abc")
    assert a == b != c


def test_a_finished_training_is_left_as_it_is(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "m.ckpt"
    first = run(data, out)
    files = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    again = run(data, out)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == files
    assert again.history == first.history
    # A stage on its own doesn't take back what was finetuned after it.
    run(data, out, stages=("ranker",))
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == files


def test_training_a_stage_further_voids_what_was_finetuned_on_it(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "m.ckpt"
    run(data, out)
    run(data, out, stages=("ranker",), epochs=4)
    assert set(load_checkpoint(out).training["stages"]) == {"ranker", "translator"}
    assert not out.with_name("m.ckpt.finetune.state").exists()


def test_stages_can_be_trained_one_by_one(data: Path, tmp_path: Path) -> None:
    run(data, tmp_path / "once", epochs=1)
    for stage in ("ranker", "translator", "finetune"):
        run(data, tmp_path / "steps", stages=(stage,), epochs=1)
    assert (tmp_path / "once").read_bytes() == (tmp_path / "steps").read_bytes()


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs cuda")
def test_a_gpu_learns_what_a_cpu_learns(data: Path, tmp_path: Path) -> None:
    on_cpu, on_gpu = (run(data, tmp_path / device, device=device) for device in ("cpu", "cuda"))
    for stage in ("ranker", "translator"):
        losses = [[record["loss"] for record in report.history[stage]] for report in (on_cpu, on_gpu)]
        np.testing.assert_allclose(losses[0], losses[1], rtol=0.05)
    assert next(iter(load_checkpoint(tmp_path / "cuda").networks["ranker"].parameters())).device.type == "cpu"


def test_finetuning_that_does_not_help_keeps_what_it_started_from(data: Path, tmp_path: Path) -> None:
    preset = replace(MICRO, finetune=Rates(0.3, batch=16, epochs=2))
    report = run_training(data, data / "pairs.jsonl", tmp_path / "m", preset, TrainOptions())
    ranker, translator, finetune = report.stages
    assert finetune.best_epoch == 0
    assert finetune.validation == pytest.approx({**ranker.validation, **translator.validation})
    assert min(r["hinge"] + r["cross_entropy"] for r in report.history["finetune"]) > sum(
        finetune.validation[name] for name in ("hinge", "cross_entropy")
    )


def test_pictures_that_changed_under_the_same_pairs_are_told(data: Path, tmp_path: Path) -> None:
    """Those of the pairs only; a state of before doesn't tell them and goes on."""
    copy, out = tmp_path / "data", tmp_path / "m"
    shutil.copytree(data, copy)
    run(copy, out, stages=("ranker",), epochs=1)
    folder = copy / "views" / "s000_0"
    (folder / "renders").mkdir(exist_ok=True)
    (folder / "renders" / "0.png").write_bytes(b"another")
    run(copy, out, stages=("ranker",), epochs=2)
    first, second = (folder / "drawings" / name for name in ("0.png", "1.png"))
    first.write_bytes(second.read_bytes())
    with pytest.raises(UsageError, match=r"an earlier training had pictures \w{8}, now \w{8}; expected the same"):
        run(copy, out, stages=("ranker",), epochs=3)
    tensors, header = load_tensors(tmp_path / "m.ranker.state", STATE_KIND)
    del header["settings"]["pictures"]
    save_tensors(tmp_path / "m.ranker.state", STATE_KIND, tensors, header)
    assert run(copy, out, stages=("ranker",), epochs=3).stages[0].epochs == 3
