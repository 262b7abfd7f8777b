"""Commands that are held to seconds and memory."""

import subprocess
import sys
from pathlib import Path

import pytest

from ncmodel.readers.ply import ply_bytes
from ncmodel.types import Mesh
from tests.helpers import analytic

SCRIPT = """
import math, sys
from ncmodel.cli.limited import _held_to
from ncmodel.cli.main import _complain
from ncmodel.errors import NeuralContoursError
from ncmodel.limits import Limits

def work():
    {work}

try:
    _held_to(Limits({seconds}, {memory_gb}), work)
except NeuralContoursError as error:
    sys.exit(_complain(error, 2))
"""


def held(work: str, seconds: float = 60.0, memory_gb: float = 4.0) -> "subprocess.CompletedProcess[str]":
    script = SCRIPT.format(work=work, seconds=seconds, memory_gb=memory_gb)
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize(
    ("work", "reason"),
    [
        ("import time; time.sleep(600)", "it took more than 1 s"),
        ("bytes(1 << 34)", "it needs more than 4 GB of memory"),
        (
            "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)",
            "its process died with signal SIGSEGV (no message)",
        ),
        ("import os; os.write(2, b'std::bad_alloc'); os.abort()", "it needs more than 4 GB of memory"),
    ],
)
def test_what_takes_too_much_is_one_line(work: str, reason: str) -> None:
    done = held(work, seconds=1.0 if "sleep" in work else 60.0)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"ncontours: gave up: {reason}\n")


def test_what_is_written_and_raised_comes_through() -> None:
    done = held("print('out'); sys.stderr.write('aside\\n'); raise NeuralContoursError('what a user can mend')")
    assert (done.returncode, done.stdout, done.stderr) == (2, "out\n", "aside\nncontours: what a user can mend\n")


def ncontours(*arguments: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "ncmodel.cli.main", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=300, check=False)


def test_a_drawing_that_takes_too_long_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "torus.ply").write_bytes(ply_bytes(Mesh(*analytic.torus(48, 24))))
    done = ncontours("draw", "torus.ply", "-o", "torus.svg", "--seconds", "0.01", folder=tmp_path)
    assert (done.returncode, done.stderr) == (2, "ncontours: gave up: it took more than 0.01 s\n")
    assert [path.name for path in tmp_path.iterdir()] == ["torus.ply"]


@pytest.mark.parametrize(
    ("option", "value", "expected"), [("--seconds", "0", "a positive number"), ("--memory-gb", "0.5", "at least 1")]
)
def test_limits_that_nothing_fits_in(option: str, value: str, expected: str, tmp_path: Path) -> None:
    done = ncontours("draw", "torus.ply", "-o", "torus.svg", option, value, folder=tmp_path)
    assert (done.returncode, done.stderr) == (2, f"ncontours: {option}: found {value}, expected {expected}\n")
