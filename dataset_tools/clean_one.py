"""The folder of one cleaned shape: its mesh and the report, or the reason why there is no mesh."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dataset_tools.clean import CleanSettings, clean_file
from dataset_tools.encode import ply
from dataset_tools.similarity import invariants
from ncmodel.errors import InputError


@dataclass(frozen=True)
class CleanTask:
    """One shape to clean.

    Attributes:
        root: The data folder.
        source: The mesh file.
        sha256: Of its content, by which a file that was changed is told.
        name: The shape's name.
        up: The file's upward axis.
        min_faces: Shapes with fewer are skipped.
        settings: Tolerances.
    """

    root: str
    source: str
    sha256: str
    name: str
    up: str
    min_faces: int
    settings: CleanSettings


def cleaned(task: CleanTask) -> dict[str, bytes]:
    """Clean a shape.

    Returns:
        The files of the shape's folder: `clean.json`, whose "status" is "done", "failed" or "skipped" with a
        "reason", and where it is done the mesh.
    """
    try:
        mesh, report = clean_file(task.source, task.up, task.settings)
    except InputError as error:
        return failed(task, f"{error.found}; expected {error.expected}")  # wherever the file lies, the same words
    except OSError as error:
        return failed(task, f"can't be read ({error.strerror})")
    if report.resolution < task.min_faces:
        reason = f"low resolution: {report.resolution} faces, expected at least {task.min_faces}"
        return {"clean.json": _record(task, "skipped", reason, **report.to_record())}
    moments = [float(f"{moment:.6g}") for moment in invariants(mesh)]
    record = _record(task, "done", "", **report.to_record(), invariants=moments)
    return {"clean.json": record, "mesh.ply": ply(mesh)}


def failed(task: CleanTask, reason: str) -> dict[str, bytes]:
    """The files of a shape that can't be made."""
    return {"clean.json": _record(task, "failed", reason)}


def _record(task: CleanTask, status: str, reason: str, **more: Any) -> bytes:
    source = {"source": Path(task.source).name, "sha256": task.sha256, "up": task.up}
    settings = {name: getattr(task.settings, name) for name in ("weld", "snap", "remove_hidden", "support")}
    record = {"status": status, "reason": reason, **source, **more, "settings": settings}
    return (json.dumps(record, indent=1) + "\n").encode()
