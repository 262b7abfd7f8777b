"""Writing a collection of shapes into a folder, by several processes, going on where it was stopped."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from dataset_tools.build.runners import Runner
from dataset_tools.collection.families import make_shape
from ncmodel.errors import InputError
from ncmodel.files import write_bytes
from ncmodel.limits import Limits
from ncmodel.progress import Advance
from ncmodel.readers.ply import ply_bytes

LIMITS = Limits(seconds=300.0, memory_gb=8.0)
"""Of one shape."""


@dataclass(frozen=True)
class Written:
    """What became of a collection.

    Attributes:
        made: Shapes written now.
        kept: Shapes that were there before.
        failed: Name -> reason.
    """

    made: int
    kept: int
    failed: dict[str, str]


@dataclass(frozen=True)
class _Task:
    name: str
    path: Path


def write_collection(folder: Path, names: Sequence[str], runner: Runner, advance: Advance) -> Written:
    """Make shapes and write each as FOLDER/NAME.ply, whole or not at all; those that are there stay.

    Args:
        folder: Made where it is missing.
        names: FAMILY_NUMBER each.
        runner: Makes them.
        advance: Called after each that is made.

    Raises:
        InputError: The folder is a file, or can't be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(folder, f"can't be made ({error.strerror})", "a folder") from error
    tasks = [_Task(name, folder / f"{name}.ply") for name in names]
    missing = [task for task in tasks if not task.path.is_file()]
    for _ in range(len(tasks) - len(missing)):
        advance("")
    failed = {}
    for outcome in runner.run(_write, missing, LIMITS):
        if outcome.result is None:
            failed[outcome.task.name] = outcome.reason
        advance(outcome.task.name)
    return Written(len(missing) - len(failed), len(tasks) - len(missing), failed)


def _write(task: _Task) -> int:
    mesh = make_shape(task.name)
    write_bytes(task.path, ply_bytes(mesh))
    return len(mesh.faces)
