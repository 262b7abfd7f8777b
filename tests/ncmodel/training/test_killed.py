"""The whole command, killed twice in the middle of a training, goes on both times and ends in the same bytes."""

import os
import signal
import subprocess
import sys
from pathlib import Path

from tests.helpers.training_data import make_data
from tests.helpers.waiting import wait_until

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = """
from ncmodel.cli.main import main
from ncmodel.nets.presets import PRESETS
from tests.helpers.micro_training import MICRO
PRESETS["tiny"] = MICRO
main()
"""
"""`ncontours` with networks that learn in moments."""

SETTINGS = """
[ranker]
batch = 2
epochs = 4
[translator]
batch = 1
epochs = 8
[finetune]
batch = 4
epochs = 1
"""
"""Many steps: a training shouldn't have ended before it is killed."""


def start(folder: Path, out: Path) -> subprocess.Popen[str]:
    """The command, which writes a state after every step."""
    words = ["train", str(folder), str(folder / "pairs.jsonl"), "-o", str(out)]
    words += ["--settings", str(folder / "mine.toml"), "--save-every", "1e-9"]
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *words],
        env={**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_a_killed_training_goes_on_and_ends_in_the_same_bytes(tmp_path: Path) -> None:
    make_data(tmp_path, shapes=3, views=1, held_out=1)
    (tmp_path / "mine.toml").write_text(SETTINGS)
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    # The one can't be caught; the other is what a machine sends that shuts down.
    for number, stage in ((signal.SIGKILL, "ranker"), (signal.SIGTERM, "translator")):
        with start(tmp_path, killed) as training:
            try:
                wait_until((tmp_path / f"killed.{stage}.state").exists, seconds=300)
            finally:
                training.send_signal(number)
                said = training.communicate()[0]
        assert training.returncode == -number, said
    assert not (tmp_path / "killed.finetune.state").exists()
    for out in (killed, whole):
        with start(tmp_path, out) as training:
            said = training.communicate()[0]
        assert training.returncode == 0, said
    names = {path.name.removeprefix("whole") for path in tmp_path.glob("whole*")}
    assert names == {path.name.removeprefix("killed") for path in tmp_path.glob("killed*")}
    assert {"", ".history.json", ".ranker.state", ".translator.state", ".finetune.state"} < names
    for name in names:
        assert (tmp_path / f"killed{name}").read_bytes() == (tmp_path / f"whole{name}").read_bytes(), name
