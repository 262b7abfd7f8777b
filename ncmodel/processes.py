"""Processes: that end with the one that started them, and what they cost."""

import os
import resource
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ncmodel.errors import NeuralContoursError

CHECK_SECONDS = 0.5

_LAUNCHER = """
import os, sys, time
begin = time.perf_counter()
process = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ)
_, status, usage = os.wait4(process, 0)
print()
print(time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss)
sys.exit(os.waitstatus_to_exitcode(status))
"""
"""Runs a command and prints what it used. The peak memory that the kernel reports for a process counts that of the one
it was started from, so a command that is measured must not be a child of a large process."""


@dataclass(frozen=True)
class CommandCost:
    """What a command used, from its start to its exit.

    Attributes:
        seconds: On the clock.
        processor_seconds: All threads, system time included.
        peak_bytes: Largest resident memory.
    """

    seconds: float
    processor_seconds: float
    peak_bytes: int


def end_with_parent(parent: int) -> None:
    """End this process soon after its parent is gone: work that nobody waits for must not outlive a killed build.

    Args:
        parent: The parent's process id, as the parent itself knew it: it may be gone already.
    """

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(CHECK_SECONDS)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def peak_memory() -> int:
    """Bytes of this process's largest resident memory so far."""
    # Not `ru_maxrss`: it starts from what the parent had when this process was started from it.
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(status.split("VmHWM:")[1].split()[0]) * 1024


def peak_memory_of_children() -> int:
    """Bytes of the largest resident memory of any process that this one started and that has ended; 0 without one."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024


def measure_command(command: Sequence[str]) -> CommandCost:
    """Run a command, start-up included, and account for it.

    Args:
        command: The program's path and its arguments.

    Raises:
        NeuralContoursError: The command failed; with the last line of what it said.
    """
    launched = [sys.executable, "-S", "-c", _LAUNCHER, *command]
    done = subprocess.run(launched, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        last = done.stderr.strip().rpartition("\n")[2]
        raise NeuralContoursError(f"{' '.join(command)} exited with {done.returncode}: {last}")
    seconds, processor_seconds, kilobytes = done.stdout.splitlines()[-1].split()
    return CommandCost(float(seconds), float(processor_seconds), int(kilobytes) * 1024)
