"""Damaged files read, in a process under limits; what is neither read nor refused as it should be is a fault."""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from dataset_tools.build.worker_process import CallFailed, WorkerProcess
from eval.fuzz.mutations import damaged
from eval.fuzz.samples import KINDS, samples_of
from ncmodel.errors import NeuralContoursError
from ncmodel.limits import Limits

LIMITS = Limits(seconds=120.0, memory_gb=8.0)
"""For a batch, whose files have a few kilobytes each; code is compiled for the first one."""
BATCH = 50
"""Inputs handed over at once."""


@dataclass(frozen=True)
class Batch:
    """Inputs of one kind.

    Attributes:
        kind: Of `KINDS`.
        seeds: One for each.
    """

    kind: str
    seeds: tuple[int, ...]


@dataclass(frozen=True)
class Fault:
    """An input that was neither read nor refused as it should be.

    Attributes:
        kind: Of `KINDS`.
        seed: That makes it again, with `damaged_file`.
        why: What went wrong.
    """

    kind: str
    seed: int
    why: str


@dataclass(frozen=True)
class Tally:
    """What became of inputs of one kind.

    Attributes:
        kind: Of `KINDS`.
        read: How many were read.
        refused: How many were refused in one line.
        faults: The others.
    """

    kind: str
    read: int
    refused: int
    faults: tuple[Fault, ...]


def damaged_file(kind: str, seed: int) -> bytes:
    """The damaged file of a kind that belongs to a seed."""
    return damaged(_samples(kind), np.random.default_rng([KINDS.index(kind), seed]))


def try_all(kind: str, seeds: Sequence[int], worker: WorkerProcess) -> Tally:
    """Read the damaged files of some seeds.

    Args:
        kind: Of `KINDS`.
        seeds: Which.
        worker: Reads them.
    """
    read, refused, faults = 0, 0, []
    for start in range(0, len(seeds), BATCH):
        for seed, found in _outcomes(Batch(kind, tuple(seeds[start : start + BATCH])), worker):
            read += found is None
            refused += found == ""
            if found:
                faults.append(Fault(kind, seed, found))
    return Tally(kind, read, refused, tuple(faults))


def _outcomes(batch: Batch, worker: WorkerProcess) -> Iterator[tuple[int, str | None]]:
    """Each seed with what `_outcome` says; what ends the process is found by itself."""
    try:
        yield from zip(batch.seeds, worker.call(outcomes, batch, LIMITS), strict=True)
    except CallFailed as failure:
        if len(batch.seeds) == 1:
            yield batch.seeds[0], str(failure)
            return
        for seed in batch.seeds:
            yield from _outcomes(Batch(batch.kind, (seed,)), worker)


def outcomes(batch: Batch) -> list[str | None]:
    """For each input None if it is read, "" if it is refused in one line, else what went wrong."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, batch.kind if "." in batch.kind[1:] else f"a{batch.kind}")
        return [_outcome(batch.kind, seed, path) for seed in batch.seeds]


def _outcome(kind: str, seed: int, path: Path) -> str | None:
    path.write_bytes(damaged_file(kind, seed))
    try:
        _reader(kind)(path)
    except NeuralContoursError as error:
        text = str(error)
        if "\n" in text or str(path) not in text:
            return f"no line that names the file: {text!r}"
        return ""
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None


@cache
def _samples(kind: str) -> list[bytes]:
    return samples_of(kind)


def _reader(kind: str) -> Callable[[Path], object]:
    """What reads files of a kind."""
    if kind == "votes.csv":
        from dataset_tools.votes.votes import read_votes

        return read_votes
    if kind == "results.csv":
        from dataset_tools.votes.results_csv import read_csv_results

        return lambda path: list(read_csv_results(path))
    if kind == "camera.json":
        from ncmodel.camera import Camera

        return Camera.load
    if kind == "pairs.jsonl":
        from ncmodel.data.pairs import read_pairs

        return read_pairs
    if kind == ".safetensors":
        from ncmodel.published.model import load_model

        return lambda path: load_model(path, None, "cpu")
    from ncmodel.mesh.load import load_mesh

    return load_mesh
