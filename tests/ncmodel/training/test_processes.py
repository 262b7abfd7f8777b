"""Several processes learn what one does, only the first writes, and one goes on where several stopped."""

import json
import multiprocessing
import os
import socket
import subprocess
import sys
import traceback
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ncmodel.nets.checkpoints import load_checkpoint
from ncmodel.nets.presets import Rates
from ncmodel.training.processes import ALONE, Team
from ncmodel.training.train import TrainOptions, TrainReport, run_training
from tests.helpers.micro_training import MICRO

pytestmark = [
    pytest.mark.usefixtures("one_thread"),
    # From Python 3.12 on, forking a process with threads warns; these children use none of them.
    pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning"),
]

ROOT = Path(__file__).resolve().parents[3]
SHORT = replace(MICRO, ranker=Rates(1e-3, 16, 2), translator=Rates(1e-3, 2, 2), finetune=Rates(1e-4, 16, 2))
TOLERANCE = 1e-5
"""Of the loss."""


def train(data: Path, out: Path, **options: Any) -> TrainReport:
    return run_training(data, data / "pairs.jsonl", out, SHORT, TrainOptions(**options))


def _one_of_two(rank: int, port: int, data: Path, out: Path, options: dict[str, Any]) -> None:
    """What torchrun does, without the seconds that a fresh interpreter takes."""
    os.environ |= {"RANK": str(rank), "LOCAL_RANK": str(rank), "WORLD_SIZE": "2"}
    os.environ |= {"MASTER_ADDR": "127.0.0.1", "MASTER_PORT": str(port)}
    try:
        train(data, out, **options)
    except BaseException:
        traceback.print_exc()
        os._exit(1)
    os._exit(0)


def train_in_two(data: Path, out: Path, **options: Any) -> None:
    context = multiprocessing.get_context("fork")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    processes = [context.Process(target=_one_of_two, args=(rank, port, data, out, options)) for rank in range(2)]
    for process in processes:
        process.start()
    for process in processes:
        process.join(timeout=300)
    assert [process.exitcode for process in processes] == [0, 0]


def losses(out: Path) -> dict[str, list[float]]:
    """Loss and measures of every pass, by stage."""
    history = json.loads(out.with_name(f"{out.name}.history.json").read_text())
    return {
        f"{stage} {key}": [record[key] for record in records]
        for stage, records in history.items()
        for key in records[0]
        if key != "accuracy"
    }


@pytest.mark.parametrize("batch_norm", ["frozen", "synchronised"])
def test_two_processes_have_the_loss_of_one(data: Path, tmp_path: Path, batch_norm: str) -> None:
    train(data, tmp_path / "one", batch_norm=batch_norm)
    train_in_two(data, tmp_path / "two", batch_norm=batch_norm)
    one, two = losses(tmp_path / "one"), losses(tmp_path / "two")
    assert one.keys() == two.keys()
    for key, values in one.items():
        np.testing.assert_allclose(two[key], values, rtol=TOLERANCE, atol=TOLERANCE, err_msg=key)
    assert {path.name for path in tmp_path.glob("two*")} == {
        path.name.replace("one", "two") for path in tmp_path.glob("one*")
    }
    # The same tensors as one process's: batch norms that were synchronised are plain ones on disk.
    assert load_checkpoint(tmp_path / "two").preset == SHORT


def test_each_number_of_processes_goes_on_where_another_stopped(data: Path, tmp_path: Path) -> None:
    options = {"stages": ("ranker",), "batch_norm": "frozen"}
    train(data, tmp_path / "one", epochs=3, **options)
    train(data, tmp_path / "turns", epochs=1, **options)
    train_in_two(data, tmp_path / "turns", epochs=2, save_every=1e-9, **options)
    train(data, tmp_path / "turns", epochs=3, **options)
    for key, values in losses(tmp_path / "one").items():
        np.testing.assert_allclose(losses(tmp_path / "turns")[key], values, rtol=TOLERANCE, err_msg=key)


def test_a_process_alone_has_everything() -> None:
    assert ALONE.leads
    assert ALONE.firsts("x") == "x"
    assert ALONE.gather([1, 2]) == [1, 2]
    assert not Team(rank=1, size=2).leads


@pytest.mark.slow
def test_torchrun_trains_by_the_command_line(data: Path, tmp_path: Path) -> None:
    """The real launcher, the real command, the tiny preset's own networks for one pass."""
    out = tmp_path / "m.safetensors"
    words = ["train", str(data), str(data / "pairs.jsonl"), "-o", str(out), "--stage", "translator", "--epochs", "1"]
    launcher = [sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    command = [*launcher, "-m", "ncmodel.cli.main", *words]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("translator: kept pass") == 1
    assert list(load_checkpoint(out).networks) == ["translator"]
