"""Adding answered questionnaires to a file of answers, each once, whatever order they come in."""

import csv
import fcntl
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, TypeVar

from dataset_tools.questionnaires.questionnaire import UNSEEN
from dataset_tools.votes.results_csv import Answered, Problem
from dataset_tools.votes.tables import looks_mangled, open_table
from ncmodel.errors import InputError
from ncmodel.files import atomic

R = TypeVar("R")

Identity = tuple[str, str, str]
"""Worker, assignment and questionnaire: what makes an answering one and the same."""

_LIKE_FORMULAS = ("=", "+", "-", "@", "'")
"""How formulas begin, and the apostrophe that stands before a text that isn't one."""

MAX_PROBLEMS = 1000
"""Problems that are kept in words; a file of garbage has as many as rows."""


@dataclass
class Ingested:
    """What an ingestion did."""

    assignments: int = 0
    known_assignments: int = 0
    rejected: int = 0
    votes: int = 0
    unseen: int = 0
    sources: dict[str, int] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    more_problems: int = 0

    def complain(self, problem: Problem) -> None:
        """Note a problem; beyond the first thousand they are only counted."""
        if len(self.problems) < MAX_PROBLEMS:
            self.problems.append(problem)
        else:
            self.more_problems += 1


@dataclass(frozen=True)
class AnswerFile(Generic[R]):
    """A kind of file with one answer a row.

    Attributes:
        columns: Its header.
        read: Reads its records.
        to_row: A record as cells.
        identity: Which answering a record belongs to.
        digest: What was answered; the sum over an answering's records doesn't depend on their order.
    """

    columns: Sequence[str]
    read: Callable[[Path], Iterator[R]]
    to_row: Callable[[R], Sequence[str]]
    identity: Callable[[R], Identity]
    digest: Callable[[R], int]


Interpreter = Callable[[Answered], "Sequence[R | Problem] | Problem | None"]
"""The records in an answered questionnaire, and what is wrong with it; a problem alone where it isn't to be recorded at
all, and None if it isn't one of this batch's."""


def append(
    answered: Iterable[Answered | Problem], interpret: "Interpreter[R]", file: AnswerFile[R], out: Path
) -> Ingested:
    """Append answered questionnaires to a file; an answering that it holds already counts once.

    The file is replaced at the end, so it holds all that was read or what it held before.

    Raises:
        InputError: `out` exists and isn't such a file, or there were problems and nothing else.
    """
    done, known = Ingested(), dict[Identity, int]()
    with _alone_in(out.parent), atomic(out) as aside, aside.open("w", encoding="utf-8", newline="") as handle:
        writer = csv.writer(handle, lineterminator="\n")
        writer.writerow(file.columns)
        for record in file.read(out) if out.exists() else ():
            identity = file.identity(record)
            known[identity] = known.get(identity, 0) + file.digest(record)
            writer.writerow(file.to_row(record))
        for one in answered:
            writer.writerows(file.to_row(record) for record in _new(one, interpret, file, known, done))
        if done.problems and not done.assignments and not done.known_assignments:
            found, _, expected = done.problems[0].message.partition("; expected ")
            raise InputError(done.problems[0].where, found, expected or "answers to this batch's questionnaires")
    return done


@contextmanager
def _alone_in(folder: Path) -> Iterator[None]:
    """Wait until no other ingestion writes to a folder: two that replace one file would lose what one of them read."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise InputError(folder, f"can't be opened ({error.strerror})", "a folder that exists") from error
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _new(
    one: Answered | Problem,
    interpret: "Interpreter[R]",
    file: AnswerFile[R],
    known: dict[Identity, int],
    done: Ingested,
) -> list[R]:
    """The records that an answered questionnaire adds; what happened is added to `done`."""
    found = None if isinstance(one, Problem) else interpret(one)
    if isinstance(one, Problem):
        done.complain(one)
        return []
    if found is None:
        made = ", which a spreadsheet made of another," if looks_mangled(one.questionnaire) else ""
        message = f"questionnaire {one.questionnaire[:40]!r}{made} is unknown; expected one of this batch's"
        done.complain(Problem(one.where, message))
        return []
    if one.rejected:
        done.rejected += 1
        if (one.worker, one.assignment, one.questionnaire) in known:
            text = f"assignment {one.assignment[:40]!r} was read before it was rejected, and its answers stay"
            done.complain(Problem(one.where, text))
        return []
    if isinstance(found, Problem):
        done.complain(found)
        return []
    records = [record for record in found if not isinstance(record, Problem)]
    digest, identity = sum(map(file.digest, records)), (one.worker, one.assignment, one.questionnaire)
    if identity in known:
        done.known_assignments += 1
        if known[identity] != digest:
            text = f"assignment {one.assignment[:40]!r} was read before with other answers, which stay"
            done.complain(Problem(one.where, text))
        return []
    known[identity] = digest
    for problem in found:
        if isinstance(problem, Problem):
            done.complain(problem)
    done.assignments += 1
    done.votes += len(records)
    done.unseen += list(one.answers.values()).count(UNSEEN)
    done.sources[one.source] = done.sources.get(one.source, 0) + 1
    return records


def read_rows(
    path: Path, columns: Sequence[str], optional: Sequence[str], what: str
) -> Iterator[tuple[str, Mapping[str, str]]]:
    """The rows of a file of answers, streamed: (file and row for messages, column -> trimmed cell).

    Raises:
        InputError: It can't be read or lacks a column that isn't optional.
    """
    needed = [name for name in columns if name not in optional]
    try:
        with open_table(path, needed) as rows:
            present = next(rows, [])
            missing = [name for name in needed if name not in present]
            if missing:
                raise InputError(path, f"no column {missing[0]}", f"{what} with the columns {', '.join(columns)}")
            for number, cells in enumerate(filter(None, rows), 2):
                row = dict(zip(present, cells, strict=False))
                yield f"{path}, row {number}", {name: _from_cell(row.get(name, "")) for name in columns}
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", what) from error
    except (csv.Error, UnicodeDecodeError) as error:
        raise InputError(path, f"not CSV in UTF-8 or UTF-16 ({error})", what) from error


def to_cell(value: object) -> str:
    """A value as a cell: nothing for None, 0 or 1 for a truth value.

    Spreadsheets take text that begins like a formula for one, and participants choose their names: it gets an
    apostrophe in front, which spreadsheets hide and `read_rows` takes away.
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return f"{value:g}"
    return f"'{value}" if isinstance(value, str) and value.startswith(_LIKE_FORMULAS) else str(value)


def _from_cell(cell: str) -> str:
    text = cell.strip()
    return text[1:] if text.startswith("'") and text[1:].startswith(_LIKE_FORMULAS) else text


def to_whole(where: str, name: str, text: str, least: int, most: int) -> int:
    """A cell as a whole number.

    Raises:
        InputError: It isn't one, or out of range.
    """
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if not least <= value <= most:
        raise InputError(where, f"{name} is {text[:40]!r}", f"a whole number in {least}..{most}")
    return value


def to_seconds(where: str, text: str) -> float | None:
    """A cell as a time; None for an empty one.

    Raises:
        InputError: It isn't one.
    """
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value < math.inf:
        raise InputError(where, f"seconds is {text[:40]!r}", "a number >= 0, or nothing")
    return value
