"""Calls in another process: results, errors, limits, and deaths that say why."""

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from dataset_tools.build.worker_process import CallFailed, WorkerProcess
from ncmodel.errors import InputError
from ncmodel.geometry.raycast import RayScene
from ncmodel.limits import Limits
from ncmodel.types import Mesh
from tests.helpers import analytic

LIMITS = Limits(seconds=60.0, memory_gb=8.0)


@pytest.fixture
def worker() -> Iterator[WorkerProcess]:
    process = WorkerProcess()
    yield process
    process.close()


def process_id(argument: object) -> int:
    return os.getpid()


def complain(argument: str) -> None:
    raise InputError(argument, "nothing", "something")


def chatter(text: str) -> str:
    print(text)  # noqa: T201 - whatever a library prints must not disturb the answers
    sys.stderr.write(text)
    return text


def die(number: int) -> None:
    sys.stderr.write("strange mesh\n")
    sys.stderr.flush()
    os.kill(os.getpid(), number)


def leave(status: int) -> None:
    os._exit(status)


def unpicklable(argument: object) -> object:
    return lambda: argument


def burn(seconds: float) -> None:
    while True:
        pass


def threads_after_work(argument: object) -> tuple[int, int]:
    vertices, faces = analytic.icosphere(5)
    RayScene(Mesh(vertices, faces)).first_hit(np.zeros((9, 3)), np.ones((9, 3)))
    np.ones((900, 900)) @ np.ones((900, 900))
    cv2.GaussianBlur(np.zeros((900, 900)), (0, 0), 5.0)
    return len(os.listdir("/proc/self/task")), len(os.sched_getaffinity(0))


def test_a_process_works_on_one_thread_and_may_use_any_core(worker: WorkerProcess) -> None:
    threads, cores = worker.call(threads_after_work, None, LIMITS)
    assert threads == 2, "one that works, one that watches the parent"
    assert cores == len(os.sched_getaffinity(0))


def test_calls_share_a_process_of_their_own(worker: WorkerProcess) -> None:
    first, second = (worker.call(process_id, None, LIMITS) for _ in range(2))
    assert first == second != os.getpid()


def test_errors_come_back_as_they_were(worker: WorkerProcess) -> None:
    with pytest.raises(InputError, match=r"some\.obj: nothing; expected something"):
        worker.call(complain, "some.obj", LIMITS)
    assert worker.call(chatter, "noise", LIMITS) == "noise"


@pytest.mark.parametrize(
    ("function", "argument", "reason"),
    [
        (die, signal.SIGSEGV, r"its process died with signal SIGSEGV \(strange mesh\)"),
        (leave, 3, r"its process died with status 3 \(no message\)"),
        (burn, 0, "it took more than 1 s"),
    ],
    ids=["crash", "exit", "endless"],
)
def test_a_failed_call_says_why_and_the_next_one_works(
    worker: WorkerProcess, function: object, argument: int, reason: str
) -> None:
    assert callable(function)
    with pytest.raises(CallFailed, match=reason):
        worker.call(function, argument, Limits(seconds=1.0, memory_gb=8.0))
    assert worker.call(chatter, "on", LIMITS) == "on"


def test_a_result_that_cannot_travel_fails_the_call(worker: WorkerProcess) -> None:
    with pytest.raises(CallFailed, match="its process died with status 1"):
        worker.call(unpicklable, 1, LIMITS)


def test_the_process_is_gone_after_closing(worker: WorkerProcess) -> None:
    process = worker.call(process_id, None, LIMITS)
    worker.close()
    assert not Path(f"/proc/{process}").exists()
    worker.end()
    with pytest.raises(CallFailed, match="the run was ended"):
        worker.call(process_id, None, LIMITS)
