"""Results files: what Mechanical Turk, Turkle and this project's simulation hand back, read row by row.

Nothing in them is trusted: a row that can't be read becomes a `Problem`, and the reading goes on.
"""

import csv
import math
import re
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

from dataset_tools.votes.answer_cells import ANSWER, answers_in
from dataset_tools.votes.tables import BYTE_ORDER_MARK, is_separator_row, looks_mangled, open_table
from ncmodel.errors import InputError
from ncmodel.parsing import parse_json

SIMULATED = "simulated participant"
"""What `RequesterAnnotation` says where nobody answered."""

SITE = "self-hosted site"
"""What it says in the download of this project's own site."""

MAX_NAME = 500
"""Characters in the name of a worker, an assignment or a questionnaire."""

MAX_SECONDS = 86400.0

REQUIRED_COLUMNS = ("AssignmentId", "Input.questionnaire")
WORKER_COLUMNS = ("WorkerId", "Turkle.Username")
_DECISIVE = (*REQUIRED_COLUMNS, *WORKER_COLUMNS, "AssignmentStatus", "Reject")
_NOT_UTF8 = "\ufffd"  # what bytes that aren't UTF-8 are read as
_SECONDS = "seconds"  # the page's own record of times, no answer
_REVIEW = {"Approve", "Reject", ""}
"""Columns at the end of the header that Mechanical Turk's rows don't reach: they are for the requester to fill in."""

# Hours from UTC of the zone names that Mechanical Turk and Turkle write; others are read as UTC.
_ZONES = {"UTC": 0, "GMT": 0, "EST": -5, "EDT": -4, "CST": -6, "CDT": -5, "MST": -7, "MDT": -6, "PST": -8, "PDT": -7,
          "AKST": -9, "AKDT": -8, "HST": -10, "WET": 0, "WEST": 1, "BST": 1, "CET": 1, "CEST": 2, "EET": 2, "EEST": 3,
          "MSK": 3, "JST": 9, "KST": 9}  # fmt: skip
_TIME = re.compile(
    r"[A-Z][a-z]{2} ([A-Z][a-z]{2}) +(\d{1,2}) (\d{2}:\d{2}:\d{2}) ([A-Za-z]+|[+-]\d{2}:?\d{0,2}) (\d{4})"
)


@dataclass(frozen=True)
class Answered:
    """A questionnaire that came back.

    Attributes:
        worker: Who answered.
        assignment: Identifies this answering.
        questionnaire: Which questionnaire.
        answers: Field -> what was sent; nothing is known to be valid.
        seconds: Field -> seconds spent, where the page told.
        total_seconds: For the whole questionnaire, where known.
        submitted: When, as ISO 8601 in UTC; "" where unknown.
        source: "mturk", "turkle", "site" or "simulated".
        where: File and row, for messages.
        rejected: Whether the requester rejected it.
        unclear: Field -> what is said of one of its radio buttons that is neither true nor false.
    """

    worker: str
    assignment: str
    questionnaire: str
    answers: Mapping[str, str]
    seconds: Mapping[str, float]
    total_seconds: float | None
    submitted: str
    source: str
    where: str
    rejected: bool = False
    unclear: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Problem:
    """Something in a file that couldn't be read, and where."""

    where: str
    message: str

    def __str__(self) -> str:
        return f"{self.where}: {self.message}"


def read_csv_results(path: Path) -> Iterator[Answered | Problem]:
    """The rows of a results CSV, streamed. The header is row 1, as in a spreadsheet.

    Raises:
        InputError: The file can't be read, or its header lacks what every results file has.
    """
    try:
        with open_table(path, REQUIRED_COLUMNS, errors="replace") as rows:
            begin, names = next(((n, cells) for n, cells in enumerate(rows, 1) if any(map(str.strip, cells))), (1, []))
            yield from _rows(path, _header(path, names), rows, begin)
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", "a results CSV") from error


def _header(path: Path, names: Sequence[str]) -> list[str]:
    header = [name.strip().lstrip(BYTE_ORDER_MARK) for name in names]
    missing = [name for name in REQUIRED_COLUMNS if name not in header]
    if missing or not any(name in header for name in WORKER_COLUMNS) or not any(n.startswith(ANSWER) for n in header):
        found = f"columns {', '.join(name[:40] for name in header[:6])}{' ...' if len(header) > 6 else ''}"
        if not header:
            found = "no header"
        elif not found.isprintable() or _NOT_UTF8 in found:
            found = "no text in UTF-8"
        raise InputError(
            path, found, "a results CSV with WorkerId, AssignmentId, Input.questionnaire and Answer columns"
        )
    return header


def _rows(path: Path, header: list[str], rows: Iterator[list[str]], number: int) -> Iterator[Answered | Problem]:
    """What the rows say that follow a header, which is row `number`."""
    while True:
        number += 1
        where = f"{path}, row {number}"
        try:
            cells = next(rows)
        except StopIteration:
            return
        except csv.Error as error:
            yield Problem(where, f"not CSV ({error})")
            continue
        if not any(cell.strip() for cell in cells) or is_separator_row(cells):
            continue
        if set(REQUIRED_COLUMNS) <= {cell.strip() for cell in cells}:
            header = _header(path, cells)  # of another file that was put behind the first one
            continue
        missing, more = header[len(cells) :], cells[len(header) :]
        if not _REVIEW.issuperset(missing) or any(cell.strip() for cell in more):
            yield Problem(where, f"{len(cells)} cells; expected {len(header)}, as in the header")
            continue
        try:
            yield _row(where, _by_name(header, [*cells, *("" for _ in missing)]))
        except ValueError as error:
            yield Problem(where, str(error))


def _by_name(header: Sequence[str], cells: Sequence[str]) -> dict[str, str]:
    """Column -> cell; of columns that a file has twice, what one of them says.

    Raises:
        ValueError: They say different things.
    """
    row = dict(zip(header, cells, strict=False))
    if len(row) == len(header):
        return row
    for name, cell in zip(header, cells, strict=False):
        matters = name in _DECISIVE or name.startswith(ANSWER)
        if matters and cell and row[name] not in ("", cell):
            raise ValueError(f"{name} is there twice, {row[name][:40]!r} and {cell[:40]!r}; expected one of them")
        row[name] = row[name] or cell
    return row


def _row(where: str, row: Mapping[str, str]) -> Answered | Problem:
    """A row as what it says.

    Raises:
        ValueError: Its answers can't be read.
    """
    worker = next((row[name].strip() for name in WORKER_COLUMNS if row.get(name, "").strip()), "")
    assignment, questionnaire = (row[name].strip() for name in REQUIRED_COLUMNS)
    for name, value in (("WorkerId", worker), ("AssignmentId", assignment), ("Input.questionnaire", questionnaire)):
        if not value or _NOT_UTF8 in value:
            return Problem(where, f"{name} is {'empty' if not value else 'not UTF-8'}")
        if not value.isprintable() or len(value) > MAX_NAME:
            return Problem(where, f"{name} is {value[:40]!r}; expected at most {MAX_NAME} printable characters")
    answers = answers_in(row)
    return Answered(
        worker=worker,
        assignment=assignment,
        questionnaire=questionnaire,
        answers=answers.values,
        unclear=answers.unclear,
        seconds=parse_seconds(answers.values.get(_SECONDS, "")),
        total_seconds=_number(row.get("WorkTimeInSeconds", "")),
        submitted=parse_time(row.get("SubmitTime", "")),
        source=_source(row),
        where=where,
        rejected=row.get("AssignmentStatus", "").strip().lower() == "rejected" or bool(row.get("Reject", "").strip()),
    )


def _source(row: Mapping[str, str]) -> str:
    if row.get("RequesterAnnotation", "").strip() == SIMULATED:
        return "simulated"
    if row.get("RequesterAnnotation", "").strip() == SITE:
        return "site"
    return "turkle" if "Turkle.Username" in row else "mturk"


def unusable(answered: Answered, answers: Mapping[str, Container[str]]) -> Problem | None:
    """Why an answering can't be held to what it says; None if it can.

    Answers in other fields than those asked, those that a spreadsheet made numbers of, and buttons of which nobody
    knows whether they were chosen aren't the participant's: taken for wrong ones they would make the participant
    unreliable.

    Args:
        answered: What came back.
        answers: Field that was asked -> what can be answered there.
    """
    given = {name: text for name, text in answered.answers.items() if name != _SECONDS}
    if given and not any(name in answers for name in given):
        names = ", ".join(name[:40] for name in list(given)[:3])
        return Problem(answered.where, f"no answer fits: found answers to {names}; expected to {', '.join(answers)}")
    for name, offered in answers.items():
        text, unclear = given.get(name, ""), answered.unclear.get(name)
        if text not in offered and unclear is not None:
            found = f"a button of {name} is {unclear[:40]!r}"
            return Problem(answered.where, f"{found}; expected true or false")
        if text not in offered and looks_mangled(text):
            found = f"{name} is {text[:40]!r}, which a spreadsheet made of an answer"
            return Problem(answered.where, f"{found}; expected the file as it was downloaded")
    return None


def parse_seconds(text: str) -> dict[str, float]:
    """Seconds by field from the page's own record; what makes no sense is left out."""
    try:
        record = parse_json(text) if text else {}
    except ValueError:
        return {}
    return sensible_seconds(record) if isinstance(record, dict) else {}


def sensible_seconds(record: Mapping[str, object]) -> dict[str, float]:
    """The entries that are times a question can take."""
    numbers = {name: value for name, value in record.items() if isinstance(value, int | float)}
    return {name: float(value) for name, value in numbers.items() if 0 <= value <= MAX_SECONDS}


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and value >= 0 else None


def parse_time(text: str) -> str:
    """A time like `Fri Nov 01 12:08:17 PDT 2019` as `2019-11-01T19:08:17Z`; "" if it can't be read."""
    match = _TIME.fullmatch(text.strip())
    if match is None:
        return ""
    month, day, clock, zone, year = match.groups()
    try:
        moment = datetime.strptime(f"{year} {month} {day} {clock}", "%Y %b %d %H:%M:%S")
        moment = moment.replace(tzinfo=_zone(zone)).astimezone(UTC)
    except (ValueError, OverflowError):
        return ""
    return moment.strftime("%Y-%m-%dT%H:%M:%SZ")


def _zone(name: str) -> timezone:
    if name[0] in "+-":
        hours, minutes = int(name[1:3]), int(name[3:].strip(":") or 0)
        offset = timedelta(hours=hours, minutes=minutes)
        return timezone(-offset if name[0] == "-" else offset)
    return timezone(timedelta(hours=_ZONES.get(name.upper(), 0)))
