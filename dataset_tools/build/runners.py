"""Running one function on many tasks: in this process, in processes of this machine, or on a Dask cluster.

All three yield results as they come, in any order. The last two run every task in a process of its own, under limits:
one that goes over them, or kills its process, fails with a reason, the others go on. One whose process somebody else
killed has not failed, and is worth another try.
"""

import logging
import os
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor, as_completed
from contextlib import closing, contextmanager
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import Any, Generic, Protocol, TypeVar

from dataset_tools.build.worker_process import CallFailed, CallKilled, Limits, WorkerProcess
from ncmodel.errors import ArgumentError

T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Outcome(Generic[T, R]):
    """What became of one task.

    Attributes:
        task: The task.
        result: What the function returned; None when it was lost.
        reason: Why there is no result.
        killed: There is none because somebody else ended the process.
    """

    task: T
    result: R | None
    reason: str = ""
    killed: bool = False


class Runner(Protocol):
    """Runs a function on tasks."""

    def run(self, function: Callable[[T], R], tasks: Sequence[T], limits: Limits) -> Iterator[Outcome[T, R]]:
        """Yield the outcomes as they come. Errors that the function raises are raised here and stop the run."""
        ...


class HereRunner:
    """One task after the other in this process, without limits."""

    def run(self, function: Callable[[T], R], tasks: Sequence[T], limits: Limits) -> Iterator[Outcome[T, R]]:
        """See `Runner.run`."""
        for task in tasks:
            yield Outcome(task, function(task))


class PoolRunner:
    """Worker processes on this machine, one thread each; they stay for the next run, until `close`.

    Args:
        workers: Number of processes.
    """

    def __init__(self, workers: int) -> None:
        if workers < 1:
            raise ArgumentError("workers", str(workers), "at least 1")
        self.workers = workers
        self._processes: list[WorkerProcess] = []

    def run(self, function: Callable[[T], R], tasks: Sequence[T], limits: Limits) -> Iterator[Outcome[T, R]]:
        """See `Runner.run`."""
        self._processes += [WorkerProcess() for _ in range(min(self.workers, len(tasks)) - len(self._processes))]
        idle: SimpleQueue[WorkerProcess] = SimpleQueue()
        for process in self._processes:
            idle.put(process)

        def attempt(task: T) -> Outcome[T, R]:
            process = idle.get()
            try:
                return _outcome(process, function, task, limits)
            finally:
                idle.put(process)

        threads = ThreadPoolExecutor(self.workers)  # they only wait for the processes
        try:
            for future in as_completed([threads.submit(attempt, task) for task in tasks]):
                yield future.result()
        except BaseException:
            threads.shutdown(wait=False, cancel_futures=True)
            for process in self._processes:
                process.end()
            threads.shutdown(wait=True)
            self.close()
            raise
        threads.shutdown()

    def close(self) -> None:
        """End the processes."""
        for process in self._processes:
            process.close()
        self._processes = []


class DaskRunner:
    """A Dask cluster. Its workers need this project installed and the data folder under the same path.

    Args:
        address: The scheduler's, as "tcp://HOST:PORT".
        patience: Seconds to wait for it.

    Raises:
        UsageError: No scheduler answers there.
    """

    def __init__(self, address: str, patience: float = 10.0) -> None:
        import distributed

        self._address = address
        # A scheduler that is lost is an error of ours; its traceback beside that helps nobody.
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
        try:
            _await_listener(address, patience)
            self.client = distributed.Client(address, timeout=patience, set_as_default=False)
        except (OSError, ValueError) as error:
            found = f"{address}, where no Dask scheduler answers ({error})"
            raise ArgumentError("scheduler", found, "tcp://HOST:PORT of one that runs") from error

    def run(self, function: Callable[[T], R], tasks: Sequence[T], limits: Limits) -> Iterator[Outcome[T, R]]:
        """See `Runner.run`.

        Raises:
            UsageError: The scheduler is gone.
        """
        import distributed
        from distributed.comm.core import CommClosedError

        futures: dict[Any, T] = {}
        try:
            for task in tasks:
                futures[self.client.submit(_run_in_worker, function, task, limits, pure=False)] = task
            for future in distributed.as_completed(list(futures), loop=self.client.loop):
                task = futures.pop(future)
                try:
                    yield future.result()
                except distributed.KilledWorker as error:
                    yield Outcome(task, None, f"its worker died ({error})", killed=True)
                future.release()
        except (CancelledError, CommClosedError) as error:  # nobody else takes back what was asked for
            futures.clear()
            expected = "one that stays; the same command goes on where this one stopped"
            raise ArgumentError("scheduler", f"{self._address}, which is gone ({error})", expected) from error
        finally:
            self.client.cancel(list(futures))

    def close(self) -> None:
        """Leave the cluster."""
        self.client.close()


def _await_listener(address: str, patience: float) -> None:
    """Return once something listens at an address.

    A client that finds nobody there leaves a trap behind: its `__del__` takes a lock that the start of the next client
    holds, and if it is collected just then, both wait for ever (`LoopRunner` of distributed 2026.8). So none is made.

    Raises:
        OSError: Nobody answers.
        ValueError: It is no address.
    """
    from distributed.comm.addressing import get_address_host_port

    deadline = time.monotonic() + patience
    while True:
        try:
            socket.create_connection(get_address_host_port(address, strict=True), patience).close()
            return
        except OSError:
            if time.monotonic() > deadline:
                raise
        time.sleep(0.1)


@contextmanager
def runner_for(workers: int, scheduler: str | None = None) -> Iterator[Runner]:
    """The runner that fits the options.

    Args:
        workers: Processes on this machine; 0 works in this process, without limits.
        scheduler: Address of a Dask scheduler; replaces the workers.

    Raises:
        UsageError: No scheduler answers, or `workers` is negative.
    """
    if scheduler is None and workers == 0:
        yield HereRunner()
        return
    with closing(PoolRunner(workers) if scheduler is None else DaskRunner(scheduler)) as runner:
        yield runner


_idle_in_worker: SimpleQueue[WorkerProcess] = SimpleQueue()
"""Of a Dask worker: one for each of its threads. They end with it."""


def _run_in_worker(function: Callable[[T], R], task: T, limits: Limits) -> Outcome[T, R]:
    """Run a task outside the Dask worker that was given it."""
    try:
        process = _idle_in_worker.get_nowait()
    except Empty:
        process = WorkerProcess()
    try:
        return _outcome(process, function, task, limits)
    finally:
        _idle_in_worker.put(process)


def _outcome(process: WorkerProcess, function: Callable[[T], R], task: T, limits: Limits) -> Outcome[T, R]:
    try:
        return Outcome(task, process.call(function, task, limits))
    except CallFailed as error:
        return Outcome(task, None, str(error), isinstance(error, CallKilled))


def core_count() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))
