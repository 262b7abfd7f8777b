"""Running tasks in processes: results, errors, and tasks that kill their worker."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from dataset_tools.build.runners import DaskRunner, HereRunner, PoolRunner, Runner, runner_for
from dataset_tools.build.worker_process import Limits
from ncmodel.errors import ArgumentError, InputError
from tests.helpers.loopback import dask_cluster
from tests.helpers.waiting import wait_until

LIMITS = Limits(seconds=60.0, memory_gb=8.0)


def square(number: int) -> int:
    return number * number


def fail_at_three(number: int) -> int:
    if number == 3:
        raise InputError("three", "3", "another number")
    return number


def die_at_three(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def process_id(number: int) -> int:
    time.sleep(0.2)
    return os.getpid()


@pytest.fixture
def pool() -> Iterator[PoolRunner]:
    with closing(PoolRunner(2)) as runner:
        yield runner


@pytest.fixture(params=["here", "pool"])
def runner(request: pytest.FixtureRequest, pool: PoolRunner) -> Runner:
    return HereRunner() if request.param == "here" else pool


def test_every_task_gets_its_result(runner: Runner) -> None:
    outcomes = {outcome.task: outcome.result for outcome in runner.run(square, range(9), LIMITS)}
    assert outcomes == {number: number * number for number in range(9)}


def test_nothing_to_do_is_fine(runner: Runner) -> None:
    assert list(runner.run(square, [], LIMITS)) == []


def test_an_error_stops_the_run(runner: Runner) -> None:
    with pytest.raises(InputError, match="three: 3; expected another number"):
        list(runner.run(fail_at_three, range(9), LIMITS))


def test_a_task_that_kills_its_worker_fails_alone(pool: PoolRunner) -> None:
    outcomes = {outcome.task: outcome for outcome in pool.run(die_at_three, range(9), LIMITS)}
    assert sorted(outcomes) == list(range(9))
    assert (outcomes[3].result, outcomes[3].killed) == (None, True)
    assert outcomes[3].reason == "its process died with signal SIGKILL (no message)"
    assert [outcomes[n].result for n in range(9) if n != 3] == [n for n in range(9) if n != 3]


def too_long_at_three(number: int) -> int:
    if number == 3:
        time.sleep(100)
    return number


def too_large_at_three(number: int) -> int:
    return len(bytearray(1 << 40)) if number == 3 else number


@pytest.mark.parametrize(
    ("function", "reason"),
    [(too_long_at_three, "it took more than 2 s"), (too_large_at_three, "it needs more than 8 GB of memory")],
)
def test_a_task_over_its_limits_fails_alone(pool: PoolRunner, function: Callable[[int], int], reason: str) -> None:
    limits = Limits(seconds=2.0, memory_gb=8.0)
    outcomes = {outcome.task: outcome for outcome in pool.run(function, range(6), limits)}
    assert (outcomes[3].result, outcomes[3].reason) == (None, reason)
    assert [outcomes[n].result for n in range(6) if n != 3] == [n for n in range(6) if n != 3]


def test_a_run_that_is_given_up_leaves_no_process(pool: PoolRunner) -> None:
    outcomes = pool.run(process_id, range(50), LIMITS)
    worker = next(outcomes).result
    outcomes.close()  # type: ignore[attr-defined]
    assert not Path(f"/proc/{worker}").exists()


def test_the_workers_are_processes(pool: PoolRunner) -> None:
    used = {outcome.result for outcome in pool.run(process_id, range(6), LIMITS)}
    assert len(used) == 2
    assert os.getpid() not in used
    again = {outcome.result for outcome in pool.run(process_id, range(6), LIMITS)}
    assert again == used, "start-up is paid once"


def test_workers_end_when_their_parent_is_killed(tmp_path: Path) -> None:
    code = (
        "import sys\nfrom tests.dataset_tools.build.test_runners import LIMITS, note_and_wait\n"
        "from dataset_tools.build.runners import PoolRunner\n"
        "if __name__ == '__main__': list(PoolRunner(1).run(note_and_wait, [sys.argv[1]], LIMITS))\n"
    )
    (tmp_path / "parent.py").write_text(code)
    note = tmp_path / "worker"
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    parent = subprocess.Popen([sys.executable, tmp_path / "parent.py", note], env=environment)
    wait_until(lambda: note.exists() and note.read_text() != "", 60)
    parent.kill()
    parent.wait()
    wait_until(lambda: not Path(f"/proc/{note.read_text()}").exists(), 20)


def note_and_wait(path: str) -> None:
    Path(path).write_text(str(os.getpid()))
    time.sleep(120)


def test_a_scheduler_that_is_gone_is_one_line(tmp_path: Path) -> None:
    """In the middle of a run, and before another one."""
    with dask_cluster(tmp_path, workers=1) as address, runner_for(1, address) as runner:
        assert isinstance(runner, DaskRunner)
        process = runner.client.run_on_scheduler(os.getpid)
        for function, tasks in ((kill_at_three, [(number, process) for number in range(6)]), (square, range(3))):
            with pytest.raises(ArgumentError, match=f"scheduler: found {address}, which is gone"):
                list(runner.run(function, tasks, LIMITS))  # type: ignore[arg-type]


def kill_at_three(task: tuple[int, int]) -> int:
    """Kill a process in the third task."""
    number, process = task
    if number == 3:
        os.kill(process, signal.SIGKILL)
        time.sleep(30)
    return number
