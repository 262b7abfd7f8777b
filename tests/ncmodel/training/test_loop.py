"""One stage: it resumes exactly, keeps its best pass, ends early or in one line, and learns."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel.errors import UsageError
from ncmodel.nets.checkpoints import load_checkpoint, load_tensors
from ncmodel.nets.presets import Rates
from ncmodel.progress import Advance
from ncmodel.training.state import STATE_KIND
from ncmodel.training.train import TrainOptions, run_training
from tests.helpers.micro_training import MICRO, Interrupted, run
from tests.helpers.training_data import make_data

pytestmark = pytest.mark.usefixtures("one_thread")


@contextmanager
def stop_after(passes: int) -> Iterator[Advance]:
    """Progress that breaks off after some passes, as a kill would: after the state has been written."""
    left = passes

    def advance(note: str = "") -> None:
        nonlocal left
        left -= 1
        if left == 0:
            raise Interrupted

    yield advance


@pytest.mark.parametrize("stage", ["ranker", "translator", "finetune"])
def test_interrupted_and_resumed_equals_uninterrupted(data: Path, tmp_path: Path, stage: str) -> None:
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    before = ("ranker", "translator") if stage == "finetune" else ()
    for out in (whole, broken):
        if before:
            run(data, out, stages=before)
    run(data, whole, stages=(stage,))
    options = TrainOptions(stages=(stage,))
    with pytest.raises(Interrupted):
        run_training(data, data / "pairs.jsonl", broken, MICRO, options, lambda title, total: stop_after(1))
    run(data, broken, stages=(stage,))
    for suffix in ("", ".history.json", f".{stage}.state"):
        assert whole.with_name(f"whole{suffix}").read_bytes() == broken.with_name(f"broken{suffix}").read_bytes()


def test_more_epochs_go_on_where_fewer_ended(data: Path, tmp_path: Path) -> None:
    run(data, tmp_path / "whole", stages=("ranker",), epochs=4)
    for epochs in (1, 3, 4):
        report = run(data, tmp_path / "steps", stages=("ranker",), epochs=epochs)
        assert report.stages[0].epochs == epochs
    assert (tmp_path / "whole").read_bytes() == (tmp_path / "steps").read_bytes()


def test_a_time_budget_ends_training_early(data: Path, tmp_path: Path) -> None:
    report = run(data, tmp_path / "m.ckpt", epochs=10**6, seconds=0.2)
    assert all(1 <= stage.epochs < 10**5 for stage in report.stages)


def test_a_training_that_diverges_ends_in_one_line(data: Path, tmp_path: Path) -> None:
    preset = replace(MICRO, ranker=Rates(1e30, batch=16, epochs=3))
    with pytest.raises(UsageError, match=r"training of the ranker diverged in pass \d: the loss is (nan|inf)"):
        run_training(data, data / "pairs.jsonl", tmp_path / "m", preset, TrainOptions(stages=("ranker",)))


def test_without_held_out_items_the_last_pass_is_kept(tmp_path: Path) -> None:
    make_data(tmp_path / "data", shapes=2)
    report = run(tmp_path / "data", tmp_path / "m.ckpt")
    assert [(stage.best_epoch, stage.validation) for stage in report.stages] == [(3, {}), (3, {}), (2, {})]


def test_the_kept_weights_are_those_of_the_best_pass(data: Path, tmp_path: Path) -> None:
    run(data, tmp_path / "m.ckpt", stages=("translator",), epochs=4)
    tensors, header = load_tensors(tmp_path / "m.ckpt.translator.state", STATE_KIND)
    losses = [record["cross_entropy"] for record in header["history"]]
    assert header["best_epoch"] == int(np.argmin(losses)) + 1
    kept = load_checkpoint(tmp_path / "m.ckpt").translator
    assert kept is not None
    for name, value in kept.state_dict().items():
        assert torch.equal(tensors[f"best.translator.{name}"], value)
