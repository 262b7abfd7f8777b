"""What the commands share: JSON output, progress on stderr, parsing of lists and sizes."""

import json
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ncmodel.errors import ArgumentError
from ncmodel.progress import Advance

LOG_INTERVAL_SECONDS = 10.0
"""How often progress is written when stderr is a file and not a terminal."""


def emit(record: Any, as_json: bool, text: str = "") -> None:
    """Print the result of a command: one JSON object with `--json`, else a text for people."""
    if as_json:
        sys.stdout.write(json.dumps(record, indent=1, allow_nan=False) + "\n")
    elif text:
        sys.stdout.write(text + "\n")


def warn(note: str) -> None:
    """Say on stderr what a user should know before much time is spent."""
    sys.stderr.write(f"note: {note}\n")
    sys.stderr.flush()


@contextmanager
def option_names(**options: str) -> Iterator[None]:
    """Complaints about parameters whose options have other names: `option_names(stages="stage")`."""
    try:
        yield
    except ArgumentError as error:
        raise ArgumentError(options.get(error.parameter, error.parameter), error.found, error.expected) from error


@contextmanager
def progress(title: str, total: int) -> Iterator[Advance]:
    """Progress with rate and time left on stderr: a live bar on a terminal, plain lines in a log."""
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        with Progress(*columns, TextColumn("{task.fields[note]}"), console=Console(stderr=True)) as bar:
            task = bar.add_task(title, total=total, note="")
            yield lambda note="": bar.update(task, advance=1, note=note)
        return
    begin = last = time.monotonic()
    done = 0

    def advance(note: str = "") -> None:
        nonlocal done, last
        done += 1
        now = time.monotonic()
        if done < total and now - last < LOG_INTERVAL_SECONDS:
            return
        last = now
        rate = done / max(now - begin, 1e-9)
        left = f"{(total - done) / rate:.0f} s left" if done < total else f"{now - begin:.1f} s"
        sys.stderr.write(f"{title}: {done}/{total}, {rate:.2f}/s, {left}{'  ' + note if note else ''}\n")
        sys.stderr.flush()

    yield advance
