"""The whole command, killed twice in the middle of a training, goes on both times and ends in the same bytes."""

import multiprocessing
import os
import signal
from multiprocessing.process import BaseProcess
from pathlib import Path

import pytest

from ncmodel.cli.main import main
from ncmodel.nets.presets import PRESETS
from tests.helpers.micro_training import MICRO
from tests.helpers.training_data import make_data
from tests.helpers.waiting import wait_until

pytestmark = [
    pytest.mark.usefixtures("one_thread"),
    # From Python 3.12 on, forking a process with threads warns; these children use none of them.
    pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning"),
]

SETTINGS = """
[ranker]
batch = 2
epochs = 2
[translator]
batch = 1
epochs = 5
[finetune]
batch = 4
epochs = 1
"""
"""Many steps: a training shouldn't have ended before it is killed."""


def _train(folder: Path, out: Path) -> None:
    words = ["train", folder, folder / "pairs.jsonl", "-o", out, "--settings", folder / "mine.toml"]
    os._exit(main([str(word) for word in (*words, "--save-every", "1e-9")]))


def start(folder: Path, out: Path) -> BaseProcess:
    """The command, with a state after every step, without the seconds that a fresh interpreter takes."""
    training = multiprocessing.get_context("fork").Process(target=_train, args=(folder, out))
    training.start()
    return training


def wait_for(state: Path, training: BaseProcess) -> None:
    """Return once the file is there, or the training has ended without it."""
    wait_until(lambda: state.exists() or not training.is_alive(), seconds=600)


def test_a_killed_training_goes_on_and_ends_in_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PRESETS, "tiny", MICRO)
    make_data(tmp_path, shapes=3, views=1, held_out=1)
    (tmp_path / "mine.toml").write_text(SETTINGS)
    killed, whole = (tmp_path / name / "m" for name in ("killed", "whole"))
    for out in (killed, whole):
        out.parent.mkdir()
    # The one can't be caught; the other is what a machine sends that shuts down.
    stops = (BaseProcess.kill, signal.SIGKILL, "ranker"), (BaseProcess.terminate, signal.SIGTERM, "translator")
    for stop, number, stage in stops:
        training = start(tmp_path, killed)
        try:
            wait_for(killed.with_name(f"m.{stage}.state"), training)
        finally:
            stop(training)
            training.join()
        assert training.exitcode == -number
    assert not killed.with_name("m.finetune.state").exists()
    for out in (killed, whole):
        training = start(tmp_path, out)
        training.join()
        assert training.exitcode == 0
    names = {path.name for path in whole.parent.iterdir()}
    assert names == {path.name for path in killed.parent.iterdir()}
    assert {"m", "m.history.json", "m.ranker.state", "m.translator.state", "m.finetune.state"} < names
    for name in sorted(names):
        assert killed.with_name(name).read_bytes() == whole.with_name(name).read_bytes(), name
