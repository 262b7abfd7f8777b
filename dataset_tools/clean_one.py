"""Cleaning in a process of its own: whatever a mesh does to the cleaner, it is the only one to suffer.

`python -m dataset_tools.clean_one` reads a task (JSON) from its input and leaves the files of the shape's folder in
another one. It limits its own memory and processor time; the caller limits the time on the clock.
"""

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from dataset_tools.clean import CleanSettings, clean_file
from dataset_tools.encode import ply
from dataset_tools.orphans import end_with_parent
from dataset_tools.similarity import invariants
from ncmodel.errors import NeuralContoursError

_GIGABYTE = 1 << 30


@dataclass(frozen=True)
class CleanTask:
    """One shape to clean.

    Attributes:
        source: The mesh file.
        name: The shape's name.
        up: The file's upward axis.
        min_faces: Shapes with fewer are skipped.
        settings: Tolerances and limits.
    """

    source: str
    name: str
    up: str
    min_faces: int
    settings: CleanSettings


def clean_apart(task: CleanTask) -> dict[str, bytes]:
    """Clean a shape in a child process.

    Returns:
        The files of the shape's folder: `clean.json`, whose "status" is "done", "failed" or "skipped" with a
        "reason", and where it is done the mesh.
    """
    with tempfile.TemporaryDirectory() as folder:
        try:
            child = subprocess.run(
                [sys.executable, "-m", "dataset_tools.clean_one", folder],
                input=json.dumps(asdict(task)).encode(),
                capture_output=True,
                timeout=task.settings.seconds,
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"},
                check=False,
            )
        except subprocess.TimeoutExpired:
            return failed(task, f"cleaning took more than {task.settings.seconds:g} s")
        files = {path.name: path.read_bytes() for path in sorted(Path(folder).iterdir())}
        if child.returncode == 0 and "clean.json" in files:
            return files
        return failed(task, _why(child.returncode, child.stderr, task.settings))


def failed(task: CleanTask, reason: str, status: str = "failed", **more: Any) -> dict[str, bytes]:
    """The files of a shape that wasn't made."""
    return {"clean.json": _record(task, status, reason, **more)}


def clean_here(task: CleanTask) -> Mapping[str, bytes]:
    """Clean a shape in this process; returns what `clean_apart` does."""
    try:
        mesh, report = clean_file(task.source, task.up, task.settings)
    except NeuralContoursError as error:
        return failed(task, str(error))
    except MemoryError:
        return failed(task, f"cleaning needs more than {task.settings.memory_gb:g} GB of memory")
    if report.resolution < task.min_faces:
        reason = f"low resolution: {report.resolution} faces, expected at least {task.min_faces}"
        return failed(task, reason, "skipped", **report.to_record())
    moments = [float(f"{moment:.6g}") for moment in invariants(mesh)]
    record = _record(task, "done", "", **report.to_record(), invariants=moments)
    return {"clean.json": record, "mesh.ply": ply(mesh)}


def _record(task: CleanTask, status: str, reason: str, **more: Any) -> bytes:
    head = {"status": status, "reason": reason, "source": Path(task.source).name, "up": task.up}
    settings = {name: getattr(task.settings, name) for name in ("weld", "snap", "remove_hidden", "support")}
    return (json.dumps({**head, **more, "settings": settings}, indent=1) + "\n").encode()


def _why(status: int, stderr: bytes, settings: CleanSettings) -> str:
    if status == -signal.SIGXCPU:
        return f"cleaning took more than {settings.seconds:g} s"
    last = (stderr.decode(errors="replace").strip().splitlines() or ["no message"])[-1]
    if "MemoryError" in last or "bad_alloc" in last:
        return f"cleaning needs more than {settings.memory_gb:g} GB of memory"
    how = f"signal {signal.Signals(-status).name}" if status < 0 else f"status {status}"
    return f"the cleaner died with {how} ({last})"


def _limit(settings: CleanSettings) -> None:
    memory = int(settings.memory_gb * _GIGABYTE)
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    # Native code that hangs keeps this process from noticing that its parent is gone; the kernel's clock doesn't ask.
    seconds = int(settings.seconds) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _main(folder: str) -> None:
    record = json.loads(sys.stdin.buffer.read())
    task = CleanTask(**{**record, "settings": CleanSettings(**record["settings"])})
    end_with_parent()
    _limit(task.settings)
    for name, data in clean_here(task).items():
        (Path(folder) / name).write_bytes(data)


if __name__ == "__main__":
    _main(sys.argv[1])
