"""What the commands of the crowd say when they are done."""

import sys
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from ncmodel.cli.common import emit
from ncmodel.errors import BatchError

if TYPE_CHECKING:
    from dataset_tools.questionnaires.batch import BatchReport
    from dataset_tools.study.design import StudyKey
    from dataset_tools.votes.answer_file import Ingested

MAX_SHOWN_PROBLEMS = 20


def write_notes(notes: Iterable[str]) -> None:
    """Tell the requester on stderr what they should know."""
    for note in notes:
        sys.stderr.write(f"note: {note}\n")


def emit_batch(report: "BatchReport", batch_dir: Path, as_json: bool) -> None:
    """Tell what a batch holds."""
    write_notes(report.notes)
    text = (
        f"{report.questionnaires} questionnaires of {report.real} items and {report.sentinels} sentinels, "
        f"{report.items} items, in {batch_dir}"
    )
    emit(asdict(report), as_json, text)


def emit_study_batch(key: "StudyKey", notes: list[str], short: int, batch_dir: Path, as_json: bool) -> None:
    """Tell what a study's batch holds; `short` is how many of the comparisons lack answers."""
    write_notes(notes)
    record = {"questionnaires": len(key.questionnaires), "comparisons": len(key.comparisons), "short": short}
    text = "{questionnaires} questionnaires, {comparisons} comparisons ({short} of them short of answers), in "
    emit({**record, "notes": notes}, as_json, text.format(**record) + str(batch_dir))


def emit_simulated(done: Mapping[str, object], output: Path, as_json: bool) -> None:
    """Tell how many simulated participants answered."""
    emit(done, as_json, f"{done['simulated_participants']} simulated participants in {output}")


def emit_ingested(done: "Ingested", output: Path, as_json: bool) -> None:
    """Tell what an ingestion did; its problems make the exit status 1."""
    record = {**asdict(done), "problems": [str(problem) for problem in done.problems]}
    left_out = f", {done.rejected} rejected ones left out" if done.rejected else ""
    if done.unseen:
        left_out += f", {done.unseen} questions without a vote because their pictures didn't come"
    text = f"{done.assignments} questionnaires with {done.votes} votes added to {output}{left_out}"
    emit(record, as_json, text)
    for problem in done.problems[:MAX_SHOWN_PROBLEMS]:
        sys.stderr.write(f"{problem}\n")
    if done.problems:
        count = len(done.problems) + done.more_problems
        raise BatchError(f"{count} problem{'s' if count > 1 else ''} in the results; all the rest was read")
