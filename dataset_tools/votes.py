"""Votes: one row for each question that a participant answered, whatever the answer was worth."""

import csv
import math
import sys
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

from dataset_tools.questionnaire import N_OPTIONS, NONE, Item, Key, Question, Questionnaire
from dataset_tools.results import MAX_FIELD, Answered, Problem
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

    @property
    def item(self) -> Item:
        """What was voted on."""
        return Item(self.shape, self.view)


MAX_PROBLEMS = 1000
"""Problems that are kept in words; a file of garbage has as many as rows."""

COLUMNS = tuple(one.name for one in fields(Vote))
_OPTIONAL = ("position", "submitted")


def votes_of(answered: Answered, questionnaire: Questionnaire) -> Iterator[Vote | Problem]:
    """The votes in an answered questionnaire.

    A question without an answer gives no vote, except that a sentinel counts as failed; one with an answer that it
    doesn't offer gives a problem besides.
    """
    for question in questionnaire.questions:
        sent = answered.answers.get(question.field, "")
        choice = question.choice(sent)
        if sent and choice is None and not (question.sentinel and len(question.options) < N_OPTIONS):
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
    )


@dataclass
class Ingested:
    """What an ingestion did."""

    assignments: int = 0
    known_assignments: int = 0
    votes: int = 0
    sources: dict[str, int] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    more_problems: int = 0

    def complain(self, problem: Problem) -> None:
        """Note a problem; beyond the first thousand they are only counted."""
        if len(self.problems) < MAX_PROBLEMS:
            self.problems.append(problem)
        else:
            self.more_problems += 1


Identity = tuple[str, str, str]


def ingest(answered: Iterable[Answered | Problem], key: Key, out: Path) -> Ingested:
    """Append answered questionnaires to a vote file; an assignment that it holds already counts once.

    The file is replaced at the end, so it holds all that was read or what it held before.

    Raises:
        InputError: `out` exists and isn't a vote file, or there were problems and nothing else.
    """
    done = Ingested()
    known: dict[Identity, int] = {}
    with atomic(out) as aside, aside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for vote in read_votes(out) if out.exists() else ():
            known[_identity(vote)] = known.get(_identity(vote), 0) + _digest(vote)
            writer.writerow(_to_row(vote))
        for one in answered:
            writer.writerows(_to_row(vote) for vote in _new_votes(one, key, known, done))
        if done.problems and not done.assignments and not done.known_assignments:
            first = done.problems[0]
            found = first.message.partition("; expected")[0]
            raise InputError(first.where, found, "answers to this batch's questionnaires")
    return done


def _new_votes(one: Answered | Problem, key: Key, known: dict[Identity, int], done: Ingested) -> list[Vote]:
    """The votes that an answered questionnaire adds; what happened is added to `done`."""
    questionnaire = None if isinstance(one, Problem) else key.questionnaires.get(one.questionnaire)
    if isinstance(one, Problem):
        done.complain(one)
        return []
    if questionnaire is None:
        expected = f"expected one of this batch's {len(key.questionnaires)}"
        done.complain(Problem(one.where, f"questionnaire {one.questionnaire[:40]!r} is unknown; {expected}"))
        return []
    found = list(votes_of(one, questionnaire))
    votes = [vote for vote in found if isinstance(vote, Vote)]
    digest = sum(map(_digest, votes))
    identity = (one.worker, one.assignment, one.questionnaire)
    if identity in known:
        done.known_assignments += 1
        if known[identity] != digest:
            text = f"assignment {one.assignment[:40]} was read before with other answers, which stay"
            done.complain(Problem(one.where, text))
        return []
    known[identity] = digest
    for problem in found:
        if isinstance(problem, Problem):
            done.complain(problem)
    done.assignments += 1
    done.votes += len(votes)
    done.sources[one.source] = done.sources.get(one.source, 0) + 1
    return votes


def _identity(vote: Vote) -> Identity:
    return vote.worker, vote.assignment, vote.questionnaire


def _digest(vote: Vote) -> int:
    """Of what was answered; the sum over an assignment's votes doesn't depend on their order."""
    return zlib.crc32(f"{vote.question} {vote.choice} {vote.passed}".encode())


def read_votes(path: Path) -> Iterator[Vote]:
    """The votes in a vote file, streamed.

    Raises:
        InputError: It can't be read, lacks a column, or has a row that makes no sense.
    """
    csv.field_size_limit(min(MAX_FIELD, sys.maxsize))
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file)
            missing = [name for name in COLUMNS if name not in (reader.fieldnames or []) and name not in _OPTIONAL]
            if missing:
                raise InputError(path, f"no column {missing[0]}", f"a vote file with the columns {', '.join(COLUMNS)}")
            for number, row in enumerate(reader, 2):
                yield _from_row(path, number, row)
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", "a vote file") from error
    except (csv.Error, UnicodeDecodeError) as error:
        raise InputError(path, f"not CSV in UTF-8 ({error})", "a vote file") from error


def write_votes(path: Path, votes: Iterable[Vote]) -> None:
    """Write a vote file."""
    with atomic(path) as aside, aside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(_to_row(vote) for vote in votes)


def _to_row(vote: Vote) -> Sequence[str]:
    return [_cell(getattr(vote, name)) for name in COLUMNS]


def _cell(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _from_row(path: Path, number: int, row: Mapping[str, str | None]) -> Vote:
    """A vote from a row of strings.

    Raises:
        InputError: A value makes no sense.
    """
    where = f"{path}, row {number}"
    cells = {name: (row.get(name) or "").strip() for name in COLUMNS}
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
        question=_whole(where, "question", cells["question"], 1, 9999),
        shape=cells["shape"],
        view=cells["view"],
        choice=_whole(where, "choice", cells["choice"], -1, N_OPTIONS - 1),
        sentinel=sentinel,
        passed=cells["passed"] == "1" if sentinel else None,
        seconds=_seconds(where, cells["seconds"]),
        source=cells["source"],
        position=_whole(where, "position", cells["position"], 0, N_OPTIONS) if cells["position"] else None,
        submitted=cells["submitted"],
    )


def _whole(where: str, name: str, text: str, least: int, most: int) -> int:
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if not least <= value <= most:
        raise InputError(where, f"{name} is {text[:40]!r}", f"a whole number in {least}..{most}")
    return value


def _seconds(where: str, text: str) -> float | None:
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value < math.inf:
        raise InputError(where, f"seconds is {text[:40]!r}", "a number >= 0, or nothing")
    return value
