"""Work in a process of its own, under limits: what hangs, crashes or explodes there takes nothing else along.

A `WorkerProcess` starts one process and hands it calls, one after the other, so that start-up (imports, compiled code)
is paid once. The process that goes over its time is killed; its memory is limited by the kernel. Either way the call
ends with a `CallFailed` that says why, and the next one gets a new process.
"""

import os
import resource
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from threading import Lock
from typing import IO, Any, TypeVar

from ncmodel.processes import end_with_parent

T = TypeVar("T")
R = TypeVar("R")

START_SECONDS = 300.0
"""How long a new process may take to be ready; a busy file system with cold caches takes most of a minute."""

_GIGABYTE = 1 << 30
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
_FROM_OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""Signals that people and systems send, the kernel where memory is short among them; a crash sends others."""

_OUT_OF_MEMORY = ("MemoryError", "bad_alloc", "allocate", "out of memory")
"""What Python, C++, compilers and the system say."""

_SERVE = "import sys; from dataset_tools.build.worker_process import serve; serve(int(sys.argv[1]), int(sys.argv[2]))"


@dataclass(frozen=True)
class Limits:
    """What one call may take.

    Attributes:
        seconds: On the clock.
        memory_gb: Address space of its process.
    """

    seconds: float
    memory_gb: float


class CallFailed(Exception):
    """A call came to nothing; the text is the reason."""


class CallKilled(CallFailed):
    """Somebody else ended the process, which says nothing against the call."""


class WorkerProcess:
    """A process that works off calls."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection[Any, Any]
        self._complaints: IO[bytes]
        self._lock = Lock()
        self._ended = False

    def call(self, function: Callable[[T], R], argument: T, limits: Limits) -> R:
        """What `function(argument)` returns or raises; both must be picklable, the function by its name.

        Raises:
            CallFailed: It took more than the limits, or its process died; `CallKilled` if somebody else ended that.
        """
        self._start()
        try:
            self._connection.send((function, argument, limits))
            self._receive(START_SECONDS)  # ready: modules are imported
            done, value = self._receive(limits.seconds)
        except TimeoutError as error:
            self.close()
            raise CallFailed(f"it took more than {error} s") from None
        except (EOFError, OSError):
            raise self._failure(limits) from None
        if isinstance(value, MemoryError):
            self.close()  # what is left of it may be in the way of the next call
            raise CallFailed(_too_large(limits))
        if not done:
            raise value
        result: R = value
        return result

    def end(self) -> None:
        """Kill the process, whatever it is doing, for good; threads that wait for it get `CallFailed` and clean up."""
        with self._lock:
            self._ended = True
            if self._process is not None:
                self._process.kill()

    def close(self) -> None:
        """End the process and let go of what belongs to it; the next call starts another one."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._connection.close()
            self._complaints.close()
            self._process = None

    def _start(self) -> None:
        if self._process is not None and self._process.poll() is None:
            return
        self.close()
        with self._lock:
            if self._ended:
                raise CallFailed("the run was ended")
            self._connection, theirs = Pipe()
            self._complaints = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the process
            self._process = subprocess.Popen(
                [sys.executable, "-c", _SERVE, str(theirs.fileno()), str(os.getpid())],
                env={**os.environ, **dict.fromkeys(_ONE_THREAD, "1"), "PYTHONPATH": os.pathsep.join(sys.path)},
                pass_fds=(theirs.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=self._complaints,
                stderr=self._complaints,
            )
            theirs.close()

    def _receive(self, seconds: float) -> Any:
        if not self._connection.poll(seconds):
            raise TimeoutError(f"{seconds:g}")
        return self._connection.recv()

    def _failure(self, limits: Limits) -> CallFailed:
        assert self._process is not None
        status = self._process.wait()
        self._complaints.seek(0)
        last = (self._complaints.read().decode(errors="replace").strip().splitlines() or ["no message"])[-1]
        self.close()
        if status == -signal.SIGXCPU:
            return CallFailed(f"it took more than {limits.seconds:g} s")
        if any(word in last for word in _OUT_OF_MEMORY):
            return CallFailed(_too_large(limits))
        how = f"signal {signal.Signals(-status).name}" if status < 0 else f"status {status}"
        kind = CallKilled if -status in _FROM_OUTSIDE else CallFailed
        return kind(f"its process died with {how} ({last})")


def _too_large(limits: Limits) -> str:
    return f"it needs more than {limits.memory_gb:g} GB of memory"


def serve(handle: int, parent: int) -> None:
    """Work off the calls that come through a connection, until its other end is closed.

    Args:
        handle: The connection's file descriptor.
        parent: Id of the process that holds the other end.
    """
    os.set_inheritable(handle, False)
    end_with_parent(parent)
    _use_one_thread()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    connection: Connection[Any, Any] = Connection(handle)
    with suppress(EOFError):
        while True:
            function, argument, limits = connection.recv()
            connection.send(None)
            connection.send(_attempt(function, argument, limits))


def _use_one_thread() -> None:
    """Keep libraries from starting threads of their own: there is a process a core."""
    import cv2
    import numpy as np

    from ncmodel.geometry.raycast import RayScene
    from ncmodel.types import Mesh

    cv2.setNumThreads(1)
    # The ray tracer has no such switch; it takes as many threads as it sees cores when it builds its first scene.
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(cores)})
    RayScene(Mesh(np.eye(3), np.array([[0, 1, 2]]))).first_hit(np.zeros((1, 3)), np.ones((1, 3)))
    os.sched_setaffinity(0, cores)


def _attempt(function: Callable[[T], R], argument: T, limits: Limits) -> tuple[bool, R | BaseException]:
    _limit(limits)
    try:
        return True, function(argument)
    except Exception as error:
        return False, error


def _limit(limits: Limits) -> None:
    memory, hard = int(limits.memory_gb * _GIGABYTE), resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (memory if hard < 0 else min(memory, hard), hard))
    # Native code that hangs keeps this process from noticing that its parent is gone; the kernel's clock doesn't ask.
    used, hard = resource.getrusage(resource.RUSAGE_SELF), resource.getrlimit(resource.RLIMIT_CPU)[1]
    seconds = int(used.ru_utime + used.ru_stime + limits.seconds) + 2
    resource.setrlimit(resource.RLIMIT_CPU, (seconds if hard < 0 else min(seconds, hard), hard))
