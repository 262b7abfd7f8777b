"""Whole `ncontours draw` processes: seconds and memory as a user meets them, start-up included."""

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from dataset_tools.simulation.shapes import bumpy_torus
from ncmodel.processes import measure_command
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
        NeuralContoursError: The command failed; with the last line of what it said.
    """
    cost = measure_command([sys.executable, "-m", "ncmodel.cli.main", *arguments])
    return ProcessRun(case, faces, cost.seconds, cost.processor_seconds, cost.peak_bytes / 2**20)


def write_ply(path: Path, mesh: Mesh) -> int:
    """Write a mesh as a binary PLY file; returns its number of faces."""
    import trimesh

    trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(path)
    return len(mesh.faces)
