"""Measured rows kept in a CSV file, mesh by mesh: a run that was stopped goes on where it was.

A mesh's rows count as long as the mesh and the code that draws and measures it are the same.
"""

import csv
import hashlib
import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, fields
from functools import cache
from pathlib import Path
from typing import Protocol, TypeVar

import eval.benchmark
import ncmodel
from eval.benchmark.each_view import ViewRow
from ncmodel.errors import NeuralContoursError, printable
from ncmodel.files import write_text
from ncmodel.scene.orientation import turn_outwards
from ncmodel.scene.seams import sew_seams
from ncmodel.scene.surface import Surface
from ncmodel.types import Mesh

Row = TypeVar("Row", bound=ViewRow)
KEY = "measured_on"
"""The column that tells mesh and code."""


class Measure(Protocol[Row]):
    """Measures surfaces from several views."""

    def __call__(self, surfaces: Iterable[Surface], advance: Callable[[str], None]) -> list[Row]:
        """One row a view; `advance` is called after each surface."""


def measure_kept(
    kind: type[Row], measure: Measure[Row], meshes: Sequence[Mesh], file: Path, advance: Callable[[str], None]
) -> tuple[list[Row], list[str]]:
    """Measure each mesh as `draw` takes it, unless the file holds its rows, and keep what was measured.

    Args:
        kind: Of the rows.
        measure: What makes them.
        meshes: One after the other.
        file: The CSV file; its folder exists. Rows of other meshes and of other code leave it.
        advance: Called after each mesh.

    Returns:
        All rows, and one line for each mesh that could not be measured.
    """
    old = _read(kind, file)
    rows: dict[str, list[Row]] = {}
    failures = []
    for mesh in meshes:
        key = _key(mesh)
        if key in old:
            rows[key] = old[key]
            advance(mesh.name)
            continue
        try:
            rows[key] = measure([turn_outwards(sew_seams(Surface(mesh)))], advance)
        except (NeuralContoursError, MemoryError) as error:
            failures.append(f"{printable(mesh.name)}: {str(error) or type(error).__name__}")
            advance(mesh.name)
        else:
            _write(kind, file, rows)
    _write(kind, file, rows)
    return [row for some in rows.values() for row in some], failures


def _key(mesh: Mesh) -> str:
    digest = hashlib.sha256(_code())
    for part in (mesh.name.encode(), mesh.vertices.tobytes(), mesh.faces.tobytes()):
        digest.update(part)
    return digest.hexdigest()[:16]


@cache
def _code() -> bytes:
    """Of the code that draws and measures."""
    digest = hashlib.sha256()
    for package in (ncmodel, eval.benchmark):
        for path in sorted(Path(str(package.__file__)).parent.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.digest()


def _read(kind: type[Row], file: Path) -> dict[str, list[Row]]:
    """Key -> rows of an earlier run; none of a file of other columns."""
    if not file.is_file():
        return {}
    head, *lines = list(csv.reader(io.StringIO(file.read_text(encoding="utf-8")))) or [[]]
    if head != [*(field.name for field in fields(kind)), KEY]:
        return {}
    rows: dict[str, list[Row]] = {}
    for shape, *values, key in lines:
        rows.setdefault(key, []).append(kind(shape, *map(float, values)))
    return rows


def _write(kind: type[Row], file: Path, rows: dict[str, list[Row]]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*(field.name for field in fields(kind)), KEY])
    for key, some in rows.items():
        for row in some:
            writer.writerow([*asdict(row).values(), key])
    write_text(file, text.getvalue())
