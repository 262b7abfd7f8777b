"""Commands under limits: in a process of their own, which is ended when it takes too much."""

import functools
import math
import os
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Annotated, Any

import typer

from ncmodel.errors import ArgumentError, UsageError
from ncmodel.files import remove_leftovers
from ncmodel.limits import Limits
from ncmodel.processes import end_with_parent

Seconds = Annotated[float | None, typer.Option(help="Give up after so long; status 2. (default: never)")]
MemoryGb = Annotated[float | None, typer.Option(help="Give up where more memory is needed; status 2. (default: never)")]


def limited(command: Callable[..., None]) -> Callable[..., None]:
    """A command that is held to its options `seconds` and `memory_gb`, and leaves nothing beside its `output`.

    Without an `output` it writes over the file that it draws `again`.
    """

    @functools.wraps(command)
    def held(**options: Any) -> None:
        given = {name: options[name] for name in ("seconds", "memory_gb") if options.get(name) is not None}
        if not given:
            command(**options)
            return
        if not given.get("seconds", 1.0) > 0.0:
            raise ArgumentError("seconds", f"{given['seconds']:g}", "a positive number")
        if not given.get("memory_gb", 1.0) >= 1.0:
            # Libraries reserve most of that before any work is done.
            raise ArgumentError("memory_gb", f"{given['memory_gb']:g}", "at least 1")
        output: Path = options["output"] or options["again"]
        try:
            _held_to(Limits(**{"seconds": math.inf, "memory_gb": math.inf} | given), lambda: command(**options))
        finally:
            remove_leftovers(os.path.abspath(output if output.is_dir() else output.parent))

    return held


def _held_to(limits: Limits, work: Callable[[], None]) -> None:
    """Do work in a process of its own.

    Raises:
        UsageError: It took more than the limits, or died.
        Exception: What the work raised.
    """
    ours, theirs = Pipe(duplex=False)
    sys.stdout.flush()
    with tempfile.TemporaryFile() as complaints:
        parent, child = os.getpid(), os.fork()
        if child == 0:
            ours.close()
            _work(limits, work, theirs, complaints.fileno(), parent)
        theirs.close()
        status = None
        try:
            if not ours.poll(None if math.isinf(limits.seconds) else limits.seconds):
                raise UsageError(f"gave up: {limits.too_slow}")
            raised = ours.recv()
        except EOFError:
            status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            complaints.seek(0)
            reason = limits.cause_of_death(status, complaints.read().decode(errors="replace"))
            raise UsageError(f"gave up: {reason}") from None
        finally:
            if status is None:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
        complaints.seek(0)
        sys.stderr.write(complaints.read().decode(errors="replace"))
    if isinstance(raised, MemoryError):
        raise UsageError(f"gave up: {limits.too_large}")
    if raised is not None:
        raise raised


def _work(
    limits: Limits, work: Callable[[], None], answer: "Connection[Any, Any]", complaints: int, parent: int
) -> None:
    """Do work in the forked process, tell what it raised, and end."""
    os.dup2(complaints, 2)
    end_with_parent(parent)
    raised: BaseException | None = None
    try:
        limits.apply()
        work()
        sys.stdout.flush()
    except BaseException as error:
        raised = error
    sys.stderr.flush()
    try:
        answer.send(raised)
    except Exception:  # an error that can't be sent is a mistake of ours
        traceback.print_exception(raised)
        os._exit(1)
    os._exit(0)
