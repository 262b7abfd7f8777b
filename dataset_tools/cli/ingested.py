"""What the commands that read results say."""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from ncmodel.cli.common import emit
from ncmodel.errors import BatchError

if TYPE_CHECKING:
    from dataset_tools.votes.answer_file import Ingested

MAX_SHOWN_PROBLEMS = 20


def emit_ingested(done: "Ingested", output: Path, as_json: bool) -> None:
    """Tell what an ingestion did; its problems make the exit status 1."""
    record = {**asdict(done), "problems": [str(problem) for problem in done.problems]}
    emit(record, as_json, f"{done.assignments} questionnaires with {done.votes} votes added to {output}")
    for problem in done.problems[:MAX_SHOWN_PROBLEMS]:
        sys.stderr.write(f"{problem}\n")
    if done.problems:
        count = len(done.problems) + done.more_problems
        raise BatchError(f"{count} problem{'s' if count > 1 else ''} in the results; all the rest was read")
