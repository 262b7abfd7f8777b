"""Processes that end with their parent, and what processes cost."""

import subprocess
import sys
import time

import numpy as np
import pytest

from ncmodel.errors import NeuralContoursError
from ncmodel.processes import measure_command, peak_memory, peak_memory_of_children

MEGABYTE = 1 << 20
WAIT = "import sys, time; from ncmodel.processes import end_with_parent; end_with_parent({}); time.sleep({})"


def test_a_process_ends_when_its_parent_is_gone() -> None:
    begin = time.monotonic()
    # No process has this number, like a parent that ended before its child looked.
    done = subprocess.run([sys.executable, "-c", WAIT.format(-1, 60)], check=False)
    assert done.returncode == 1
    assert time.monotonic() - begin < 60


def test_a_process_stays_while_its_parent_does() -> None:
    code = "import os, subprocess, sys; sys.exit(subprocess.call([sys.executable, '-c', sys.argv[1] % os.getpid()]))"
    assert subprocess.run([sys.executable, "-c", code, WAIT.format("%d", 1.2)], check=False).returncode == 0


def test_peak_memory_holds_what_was_let_go() -> None:
    before = peak_memory()
    np.ones(before + 64 * MEGABYTE, dtype=np.uint8)
    assert peak_memory() >= before + 64 * MEGABYTE


def test_a_command_is_accounted_for() -> None:
    code = f"import time; x = bytearray({64 * MEGABYTE}); begin = time.process_time()\n"
    code += "while time.process_time() < begin + 0.2: pass"
    cost = measure_command([sys.executable, "-c", code])
    assert cost.seconds >= 0.2
    assert cost.processor_seconds >= 0.2
    assert 64 * MEGABYTE <= cost.peak_bytes < 64 * MEGABYTE + 64 * MEGABYTE
    assert peak_memory_of_children() > MEGABYTE


def test_a_command_that_fails_says_what_it_said_last() -> None:
    with pytest.raises(NeuralContoursError, match="exited with 3: no luck"):
        measure_command([sys.executable, "-c", "import sys; sys.stderr.write('hm\\nno luck\\n'); sys.exit(3)"])
