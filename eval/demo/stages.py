"""A pipeline of stages: each in its own process, measured, recorded, and not run again once its outputs are there."""

import importlib
import json
import multiprocessing
import os
import shutil
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from ncmodel.errors import BatchError, InputError, NeuralContoursError
from ncmodel.files import write_text
from ncmodel.parsing import parse_json
from ncmodel.processes import end_with_parent, peak_memory, peak_memory_of_children


@dataclass(frozen=True)
class Stage:
    """One step of the pipeline.

    Attributes:
        name: Its key in the record.
        title: What it does, for people.
        run: A module-level function; runs in a process of its own.
        arguments: What it is called with; part of the stage's identity.
        outputs: The files or folders that are there when it is done.
        command: The public command that does the same, if there is one.
        resumes: Whether it goes on from outputs that an interrupted run left; else they are removed first.
    """

    name: str
    title: str
    run: Callable[..., None]
    arguments: tuple[Any, ...]
    outputs: tuple[Path, ...]
    command: str = ""
    resumes: bool = True


@dataclass(frozen=True)
class StageRun:
    """What a stage took.

    Attributes:
        seconds: Wall clock, the start of its process included.
        peak_bytes: Resident memory of the largest of its processes.
        note: What it had to say besides: items that failed, for one.
    """

    seconds: float
    peak_bytes: int
    note: str = ""


def command_stage(name: str, title: str, argv: Sequence[str], outputs: tuple[Path, ...], resumes: bool = True) -> Stage:
    """A stage that is one of the public commands."""
    return Stage(name, title, run_command, (tuple(argv),), outputs, "ncontours " + " ".join(argv), resumes)


def run_command(argv: tuple[str, ...]) -> None:
    """Run a public command; what it prints goes to stderr, where progress goes.

    Raises:
        NeuralContoursError: The command complained.
    """
    # By name: the application imports the commands, one of which imports this module.
    status = importlib.import_module("ncmodel.cli.main").run(list(argv))
    if status:
        failure = BatchError if status == 1 else NeuralContoursError
        raise failure(f"{argv[0]} ended with status {status}")


def run_stages(stages: Sequence[Stage], folder: Path) -> dict[str, StageRun]:
    """Run the stages that aren't done yet, in order.

    A stage is done when it is recorded in `folder`/stages.json with the same arguments and its outputs are there. Once
    one has to run, all after it run again (they may resume from what they find).

    Returns:
        What every stage took, when it ran.

    Raises:
        NeuralContoursError: A stage complained; those before it are recorded.
    """
    record_path = folder / "stages.json"
    record = _read_record(record_path)
    measured: dict[str, StageRun] = {}
    stale = False
    for number, stage in enumerate(stages, start=1):
        known = record.get(stage.name)
        # Whatever the folder is called this time, the stage is the same.
        identity = json.dumps([str(argument).replace(str(folder), "") for argument in stage.arguments])
        if not stale and known and known["identity"] == identity and all(path.exists() for path in stage.outputs):
            measured[stage.name] = StageRun(**known["measured"])
            _say(f"[{number}/{len(stages)}] {stage.title}: done before")
            continue
        stale = True
        _say(f"[{number}/{len(stages)}] {stage.title}{': ' + stage.command if stage.command else ''}")
        if not stage.resumes:
            _remove(stage.outputs)
        measured[stage.name] = measure(stage.run, *stage.arguments)
        _say(f"    {measured[stage.name].seconds:.1f} s {measured[stage.name].note}".rstrip())
        record[stage.name] = {"identity": identity, "measured": asdict(measured[stage.name])}
        write_text(record_path, json.dumps(record, indent=1) + "\n")
    return measured


def measure(function: Callable[..., None], *arguments: Any) -> StageRun:
    """Call a module-level function in a fresh process and measure it.

    Raises:
        NeuralContoursError: It was raised in there, or the process died.
    """
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    begin = time.perf_counter()
    process = context.Process(target=_in_child, args=(sender, function, arguments))
    process.start()
    sender.close()
    try:
        error, note, peak = receiver.recv()
    except EOFError:
        process.join()
        name = function.__name__
        raise NeuralContoursError(f"{name} ended with status {process.exitcode} before it was done") from None
    except BaseException:
        process.terminate()
        raise
    process.join()
    if error is not None:
        raise error
    return StageRun(time.perf_counter() - begin, peak, note)


def _in_child(sender: Connection, function: Callable[..., None], arguments: tuple[Any, ...]) -> None:
    # Stages that are killed must not leave one behind that writes to the same files as the next run.
    parent = multiprocessing.parent_process()
    assert parent is not None
    assert parent.pid is not None
    end_with_parent(parent.pid)
    # Another stage's output may be a JSON object on our stdout; what stages print is progress.
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    error, note = None, ""
    try:
        function(*arguments)
    except BatchError as failed:
        note = str(failed)
    except NeuralContoursError as complaint:
        # Rebuilt, since errors with several arguments don't travel between processes.
        error = NeuralContoursError(str(complaint))
    except Exception as unexpected:
        traceback.print_exc()
        error = NeuralContoursError(f"{function.__name__}: {unexpected!r}")
    sender.send((error, note, max(peak_memory(), peak_memory_of_children())))


def _remove(paths: Sequence[Path]) -> None:
    for path in paths:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def _read_record(path: Path) -> dict[str, Any]:
    if not path.exists():
        return {}
    expected = "the record that an earlier run wrote"
    try:
        record = parse_json(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputError(path, f"not JSON ({error})", expected) from error
    if not isinstance(record, dict):
        raise InputError(path, f"a {type(record).__name__}", expected)
    return record


def _say(line: str) -> None:
    sys.stderr.write(line + "\n")
    sys.stderr.flush()
