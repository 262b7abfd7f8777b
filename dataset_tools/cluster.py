"""Running one function on many tasks: in this process, in a pool of processes, or on a Dask cluster.

All three yield results as they come, in any order, and survive a task that kills its process: that task fails with a
reason, the others go on.
"""

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from dataset_tools.orphans import end_with_parent
from ncmodel.errors import UsageError

T = TypeVar("T")
R = TypeVar("R")

AHEAD = 2
"""Tasks handed to each worker at a time: enough to keep it busy, few to lose when it dies."""

_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class Outcome(Generic[T, R]):
    """What became of one task.

    Attributes:
        task: The task.
        result: What the function returned; None when its process died.
        reason: Why there is no result.
    """

    task: T
    result: R | None
    reason: str = ""


class Runner(Protocol):
    """Runs a function on tasks."""

    def run(self, function: Callable[[T], R], tasks: Sequence[T]) -> Iterator[Outcome[T, R]]:
        """Yield the outcomes as they come. Errors that the function raises are raised here and stop the run."""
        ...


class HereRunner:
    """One task after the other in this process."""

    def run(self, function: Callable[[T], R], tasks: Sequence[T]) -> Iterator[Outcome[T, R]]:
        """See `Runner.run`."""
        for task in tasks:
            yield Outcome(task, function(task))


class PoolRunner:
    """A pool of worker processes on this machine, one thread each.

    Args:
        workers: Number of processes.
    """

    def __init__(self, workers: int) -> None:
        if workers < 1:
            raise UsageError(f"--workers: found {workers}, expected at least 1")
        self.workers = workers

    def run(self, function: Callable[[T], R], tasks: Sequence[T]) -> Iterator[Outcome[T, R]]:
        """See `Runner.run`."""
        waiting = list(reversed(tasks))
        while waiting:
            suspects: list[T] = []
            with self._pool(min(self.workers, len(waiting))) as pool:
                yield from self._drain(pool, function, waiting, suspects)
            # A worker that dies takes its pool along. Which task it was is found by running each alone.
            for task in suspects:
                with self._pool(1) as pool:
                    yield _alone(pool, function, task)

    def _drain(
        self, pool: ProcessPoolExecutor, function: Callable[[T], R], waiting: list[T], suspects: list[T]
    ) -> Iterator[Outcome[T, R]]:
        """Work off `waiting` until it is empty or the pool breaks; tasks it broke with go to `suspects`."""
        running: dict[Future[R], T] = {}
        while waiting or running:
            while waiting and not suspects and len(running) < AHEAD * self.workers:
                task = waiting.pop()
                try:
                    running[pool.submit(function, task)] = task
                except BrokenProcessPool:
                    suspects.append(task)
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                task = running.pop(future)
                try:
                    yield Outcome(task, future.result())
                except BrokenProcessPool:
                    suspects.append(task)

    @contextmanager
    def _pool(self, workers: int) -> Iterator[ProcessPoolExecutor]:
        # "spawn": threads of numerical libraries don't survive a fork. The workers inherit the environment.
        kept = {name: os.environ.get(name) for name in _ONE_THREAD}
        os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
        pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), initializer=_start_worker)
        try:
            yield pool
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
            for name, value in kept.items():
                os.environ.pop(name) if value is None else os.environ.update({name: value})


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

        try:
            self.client = distributed.Client(address, timeout=patience, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise UsageError(f"--scheduler: no Dask scheduler answers at {address} ({error})") from error

    def run(self, function: Callable[[T], R], tasks: Sequence[T]) -> Iterator[Outcome[T, R]]:
        """See `Runner.run`."""
        import distributed

        self.client.run(use_one_thread)
        futures: dict[Any, T] = {self.client.submit(function, task, pure=False): task for task in tasks}
        try:
            for future in distributed.as_completed(list(futures), loop=self.client.loop):
                task = futures.pop(future)
                try:
                    yield Outcome(task, future.result())
                except distributed.KilledWorker as error:
                    yield Outcome(task, None, f"its worker died ({error})")
                future.release()
        finally:
            self.client.cancel(list(futures))

    def close(self) -> None:
        """Leave the cluster."""
        self.client.close()


@contextmanager
def runner_for(workers: int, scheduler: str | None = None) -> Iterator[Runner]:
    """The runner that fits the options.

    Args:
        workers: Processes on this machine; 0 works in this process.
        scheduler: Address of a Dask scheduler; replaces the workers.

    Raises:
        UsageError: No scheduler answers, or `workers` is negative.
    """
    if scheduler is None:
        yield HereRunner() if workers == 0 else PoolRunner(workers)
        return
    runner = DaskRunner(scheduler)
    try:
        yield runner
    finally:
        runner.close()


def use_one_thread() -> None:
    """Keep the libraries of a worker from starting threads of their own: there is a worker a core."""
    import cv2

    cv2.setNumThreads(1)


def _start_worker() -> None:
    use_one_thread()
    end_with_parent()


def _alone(pool: ProcessPoolExecutor, function: Callable[[T], R], task: T) -> Outcome[T, R]:
    try:
        return Outcome(task, pool.submit(function, task).result())
    except BrokenProcessPool:
        return Outcome(task, None, "its process died (out of memory, or a crash in a library)")


def core_count() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))
