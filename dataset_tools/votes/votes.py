"""Votes: one row for each question that a participant answered, whatever the answer was worth.

`Vote` is a row on its way into a vote file; whoever looks at many of them takes them as a DataFrame, `read_votes`.
"""

import csv
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from operator import attrgetter
from pathlib import Path

import numpy as np
import pandas as pd

from dataset_tools.questionnaires.identical_drawings import ALL_DIFFERENT, Twins, from_text, to_text
from dataset_tools.questionnaires.questionnaire import NONE, UNSEEN, Key, Question, Questionnaire
from dataset_tools.votes.answer_file import (
    AnswerFile,
    Identity,
    Ingested,
    append,
    read_rows,
    to_cell,
    to_seconds,
    to_whole,
)
from dataset_tools.votes.results_csv import Answered, Problem, unusable
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.errors import InputError
from ncmodel.files import atomic


@dataclass(frozen=True)
class Vote:
    """One answer to one question: a row of `votes.csv`.

    Attributes:
        worker: Who answered.
        assignment: Identifies the answered questionnaire.
        questionnaire: Which questionnaire.
        question: Its place there, from 1.
        shape: Shape asked about ("" where a key doesn't tell a sentinel's).
        view: View asked about.
        choice: Candidate index 0..7, or -1 for none of these. In a sentinel 0 is the artist's drawing.
        sentinel: Whether the question checks the participant.
        passed: For sentinels, whether the answer was right.
        seconds: Time spent, None if unknown.
        source: "mturk", "turkle", "site" or "simulated".
        position: Where the chosen answer stood, 1..8; 0 for none of these; None if unknown or not answered.
        submitted: When the questionnaire was sent, ISO 8601 in UTC; "" if unknown.
        twins: Which of the drawings are the same picture.
    """

    worker: str
    assignment: str
    questionnaire: str
    question: int
    shape: str
    view: str
    choice: int
    sentinel: bool
    passed: bool | None
    seconds: float | None
    source: str
    position: int | None = None
    submitted: str = ""
    twins: Twins = ALL_DIFFERENT


COLUMNS = tuple(one.name for one in fields(Vote))
DTYPES = {
    "worker": "string",
    "assignment": "string",
    "questionnaire": "string",
    "question": "int64",
    "shape": "string",
    "view": "string",
    "choice": "int64",
    "sentinel": "bool",
    "passed": "boolean",
    "seconds": "Float64",
    "source": "string",
    "position": "Int64",
    "submitted": "string",
    "twins": "string",
}
"""Column -> type in a DataFrame of votes; a `Vote`'s None is missing (`pandas.NA`), twins are as in the file."""

ITEM = ["shape", "view"]
"""The columns that say what was voted on."""

_OPTIONAL = ("position", "submitted", "twins")


def votes_of(answered: Answered, questionnaire: Questionnaire) -> Iterator[Vote | Problem]:
    """The votes in an answered questionnaire.

    A question whose pictures didn't come gives no vote, and one without an answer neither, except that a sentinel then
    counts as failed; one with an answer that it doesn't offer gives a problem besides.
    """
    for question in questionnaire.questions:
        sent = answered.answers.get(question.field, "")
        if sent == UNSEEN:
            continue
        choice = question.choice(sent)
        if sent and choice is None and not (question.sentinel and len(question.options) < DRAWINGS):
            offered = f"one of its {len(question.options)} values or {NONE}"
            yield Problem(answered.where, f"{question.field} is {sent[:40]!r}; expected {offered}")
        if choice is not None or question.sentinel:
            yield _vote(answered, questionnaire, question, sent, choice)


def _vote(answered: Answered, asked: Questionnaire, question: Question, sent: str, choice: int | None) -> Vote:
    seconds = answered.seconds.get(question.field)
    if seconds is None and answered.total_seconds is not None:
        seconds = round(answered.total_seconds / len(asked.questions), 2)
    return Vote(
        worker=answered.worker,
        assignment=answered.assignment,
        questionnaire=asked.identifier,
        question=question.number,
        shape=question.item.shape if question.item else "",
        view=question.item.view if question.item else "",
        choice=-1 if choice is None else choice,
        sentinel=question.sentinel,
        passed=choice == 0 if question.sentinel else None,
        seconds=seconds,
        source=answered.source,
        position=None if choice is None else question.position(sent),
        submitted=answered.submitted,
        twins=question.twins,
    )


def _identity(vote: Vote) -> Identity:
    return vote.worker, vote.assignment, vote.questionnaire


def _digest(vote: Vote) -> int:
    return zlib.crc32(f"{vote.question} {vote.choice} {vote.passed}".encode())


def ingest(answered: Iterable[Answered | Problem], key: Key, out: Path) -> Ingested:
    """Append answered questionnaires to a vote file, as `answer_file.append` does.

    Raises:
        InputError: `out` exists and isn't a vote file, or there were problems and nothing else.
    """

    def interpret(one: Answered) -> list[Vote | Problem] | Problem | None:
        questionnaire = key.questionnaires.get(one.questionnaire)
        if questionnaire is None:
            return None
        offered = {question.field: question.options for question in questionnaire.questions}
        return unusable(one, offered) or list(votes_of(one, questionnaire))

    file = AnswerFile(COLUMNS, _read_rows, _to_row, _identity, _digest)
    return append(answered, interpret, file, out)


def read_votes(path: str | Path) -> pd.DataFrame:
    """The votes in a vote file: the columns of the file, of the types `DTYPES`, in its order.

    Raises:
        InputError: It can't be read, lacks a column, or has a row that makes no sense.
    """
    return to_frame(_read_rows(Path(path)))


def to_frame(votes: Iterable[Vote]) -> pd.DataFrame:
    """Votes as a DataFrame, as `read_votes` gives it."""
    frame = pd.DataFrame(map(attrgetter(*COLUMNS), votes), columns=list(COLUMNS))
    return frame.assign(twins=frame["twins"].map(to_text)).astype(DTYPES)


def drawings_of(votes: pd.DataFrame) -> pd.Series:
    """What each choice stands for: of drawings that are the same picture the first; -1 for none of these."""
    kinds, texts = pd.factorize(votes["twins"])
    stands_for = np.array([(*from_text(text), -1) for text in texts]).reshape(-1, DRAWINGS + 1)
    return pd.Series(stands_for[kinds, votes["choice"]], votes.index, name="drawing")


def items_of(votes: pd.DataFrame) -> list[Item]:
    """The items that votes are on, sorted, each once."""
    return [Item(*names) for names in sorted(set(zip(votes["shape"], votes["view"], strict=True)))]


def write_votes(path: Path, votes: pd.DataFrame) -> None:
    """Write a vote file from a DataFrame as `read_votes` gives it."""
    values = votes[list(COLUMNS)].astype(object)
    with atomic(path) as aside, aside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(map(to_cell, row) for row in values.where(votes.notna(), None).itertuples(index=False))


def _read_rows(path: Path) -> Iterator[Vote]:
    """The votes in a vote file, streamed."""
    for where, row in read_rows(path, COLUMNS, _OPTIONAL, "a vote file"):
        yield _from_row(where, row)


def _to_row(vote: Vote) -> Sequence[str]:
    cells = {name: to_cell(getattr(vote, name)) for name in COLUMNS}
    return list({**cells, "twins": to_text(vote.twins)}.values())


def _from_row(where: str, cells: Mapping[str, str]) -> Vote:
    """A vote from a row of strings.

    Raises:
        InputError: A value makes no sense.
    """
    sentinel = cells["sentinel"] == "1"
    for name in ("worker", "assignment") if sentinel else ("worker", "assignment", "shape", "view"):
        if not cells[name]:
            raise InputError(where, f"{name} is empty", "a value")
    for name in ("sentinel", "passed"):
        if cells[name] not in ("0", "1", "") or ((name == "sentinel" or sentinel) and not cells[name]):
            raise InputError(where, f"{name} is {cells[name]!r}", "0 or 1")
    return Vote(
        worker=cells["worker"],
        assignment=cells["assignment"],
        questionnaire=cells["questionnaire"],
        question=to_whole(where, "question", cells["question"], 1, 9999),
        shape=cells["shape"],
        view=cells["view"],
        choice=to_whole(where, "choice", cells["choice"], -1, DRAWINGS - 1),
        sentinel=sentinel,
        passed=cells["passed"] == "1" if sentinel else None,
        seconds=to_seconds(where, cells["seconds"]),
        source=cells["source"],
        position=to_whole(where, "position", cells["position"], 0, DRAWINGS) if cells["position"] else None,
        submitted=cells["submitted"],
        twins=_twins(where, cells["twins"]),
    )


def _twins(where: str, text: str) -> Twins:
    try:
        return from_text(text)
    except ValueError as error:
        raise InputError(where, f"twins is {text[:40]!r}", "4=0 5=1 where drawings repeat earlier ones") from error
