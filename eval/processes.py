"""Whole `ncontours draw` processes: seconds and memory as a user meets them, start-up included."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from eval.scaling import bumpy_torus
from ncmodel.errors import NeuralContoursError
from ncmodel.types import LineFamily, Mesh

CASES: Mapping[str, str] = {
    "contours": LineFamily.CONTOURS,
    "all families": ",".join(LineFamily),
}
"""What is drawn -> the command's `--lines`."""


@dataclass(frozen=True)
class ProcessRun:
    """One run of the command.

    Attributes:
        case: What was drawn, a key of `CASES`.
        faces: Of the mesh.
        seconds: From start to exit.
        processor_seconds: All threads, system time included.
        peak_megabytes: Largest resident memory.
    """

    case: str
    faces: int
    seconds: float
    processor_seconds: float
    peak_megabytes: float


def measure_processes(sizes: Sequence[int], advance: Callable[[str], None]) -> list[ProcessRun]:
    """Draw a mesh of every size in every case, twice; the faster run counts, when all caches are warm.

    Args:
        sizes: Face counts.
        advance: Called after each size.
    """
    found = []
    with TemporaryDirectory() as folder:
        for size in sizes:
            path = Path(folder) / f"torus{size}.ply"
            faces = write_ply(path, bumpy_torus(size))
            for case, lines in CASES.items():
                arguments = ["draw", str(path), "-o", str(Path(folder) / "drawing.svg"), "--lines", lines]
                runs = [run_command(arguments, case, faces) for _ in range(2)]
                found.append(min(runs, key=lambda run: run.seconds))
            advance(f"{faces:,} faces")
    return found


def run_command(arguments: Sequence[str], case: str, faces: int) -> ProcessRun:
    """Run `ncontours` with some arguments in a process of its own and account for it.

    Raises:
        NeuralContoursError: The command failed; with what it said.
    """
    begin = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "ncmodel.cli.main", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    complaint = process.stderr.read()
    process.stderr.close()
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - begin
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise NeuralContoursError(
            f"ncontours {' '.join(arguments)} exited with {process.returncode}: {complaint.strip()}"
        )
    return ProcessRun(case, faces, seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0)


def write_ply(path: Path, mesh: Mesh) -> int:
    """Write a mesh as a binary PLY file; returns its number of faces."""
    import trimesh

    trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(path)
    return len(mesh.faces)
