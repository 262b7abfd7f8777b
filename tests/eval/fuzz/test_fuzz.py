"""The fuzz command: what it hands to readers, and that it tells what they do wrong."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from dataset_tools.build.worker_process import CallFailed, WorkerProcess
from eval.fuzz import trials
from eval.fuzz.samples import KINDS, samples_of
from eval.fuzz.trials import Fault, damaged_file, outcomes, try_all
from ncmodel.errors import InputError

EACH = 8
"""Inputs of each kind: a hundred of all. The study has thousands."""


@pytest.fixture(scope="module")
def worker() -> Iterator[WorkerProcess]:
    started = WorkerProcess()
    yield started
    started.close()


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files_are_read_or_refused_in_one_line(kind: str, worker: WorkerProcess) -> None:
    tally = try_all(kind, range(EACH), worker)
    assert tally.faults == ()
    assert tally.read + tally.refused == EACH


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_damaged_is_sound_before(kind: str, tmp_path: Path) -> None:
    path = tmp_path / (kind if "." in kind[1:] else f"a{kind}")
    for sample in samples_of(kind):
        path.write_bytes(sample)
        trials._reader(kind)(path)


def test_a_seed_makes_the_same_file_again() -> None:
    assert damaged_file(".ply", 3) == damaged_file(".ply", 3)
    assert len({damaged_file(".ply", seed) for seed in range(20)}) == 20


def test_wrong_refusals_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path) -> None:
        raise errors.pop()

    errors = [KeyError("v"), InputError("another", "a", "b"), InputError("a.obj", "x", "y")]
    monkeypatch.setattr(trials, "_reader", lambda kind: refuse)
    found = outcomes(trials.Batch(".obj", (1, 2, 3)))
    assert [bool(why) for why in found] == [True, True, True]
    assert found[2] == "KeyError: 'v'"


def test_what_ends_a_process_is_found_among_others() -> None:
    class Worker(WorkerProcess):
        def call(self, function, argument, limits):  # type: ignore[no-untyped-def]
            if 5 in argument.seeds:
                raise CallFailed("it took more than 30 s")
            return ["" for _ in argument.seeds]

    tally = try_all(".obj", range(10), Worker())
    assert tally.faults == (Fault(".obj", 5, "it took more than 30 s"),)
    assert tally.refused == 9
