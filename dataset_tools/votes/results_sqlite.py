"""What a site's database holds, as answered questionnaires: for ingestion and for the download as CSV."""

import csv
import io
import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

from dataset_tools.votes.results_csv import SITE, Answered
from ncmodel.errors import InputError
from ncmodel.files import write_bytes

_FINISHED = """
SELECT id, worker, questionnaire, started, finished FROM participants WHERE state = 'finished' ORDER BY finished, id
"""
FORMAT = "neural-contours site 1"
"""What a site's database calls itself."""
LOCK_SECONDS = 30.0
"""How long somebody else's lock is waited for."""
SQLITE_MAGIC = b"SQLite format 3\x00"


def check_format(db: sqlite3.Connection, path: Path) -> None:
    """Raise if a database isn't a site's.

    Raises:
        InputError: It is something else, or of another version.
    """
    try:
        row = db.execute("SELECT value FROM meta WHERE name = 'format'").fetchone()
    except sqlite3.Error as error:
        raise unusable_database(path, error) from error
    if row is None or row[0] != FORMAT:
        raise InputError(path, f"format {row[0] if row else 'unknown'}", FORMAT)


def unusable_database(path: Path, error: sqlite3.Error | OSError) -> InputError:
    """What to say of a database that can't be used: it may be somebody's lock or permissions, and the file be sound."""
    code = getattr(error, "sqlite_errorcode", 0) & 0xFF  # the extended code's first part
    if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
        return InputError(path, f"in use ({error})", "a database that no other program has locked")
    if code in (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_PERM) or isinstance(error, OSError):
        return InputError(path, f"can't be opened ({error})", "a file, in a folder, that may be read and written")
    return InputError(path, f"no site's database ({error})", "what `ncontours crowd serve` writes")


def is_database(path: Path) -> bool:
    """Whether a file is an SQLite database, by its first bytes."""
    try:
        with path.open("rb") as file:
            return file.read(len(SQLITE_MAGIC)) == SQLITE_MAGIC
    except OSError:
        return False


def back_up(path: Path, output: Path) -> int:
    """Copy a site's database, whole and as it is at one moment, while the site runs, too.

    Args:
        path: The database.
        output: Where to; a new file is its owner's alone.

    Returns:
        Questionnaires in it that were sent.

    Raises:
        InputError: There is no site's database, or `output` is it.
    """
    if output.exists() and output.samefile(path):
        raise InputError(output, "the database itself", "another file to copy it to")
    try:
        with closing(_read_only(path)) as db, closing(sqlite3.connect(":memory:")) as copy:
            check_format(db, path)
            db.backup(copy)
            sent = copy.execute("SELECT count(*) FROM participants WHERE state = 'finished'").fetchone()[0]
            write_bytes(output, copy.serialize(), private=True)
            return int(sent)
    except sqlite3.Error as error:
        raise unusable_database(path, error) from error


def _read_only(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True, timeout=LOCK_SECONDS)


def read_site_results(path: Path) -> Iterator[Answered]:
    """The questionnaires that were sent, in the order they came; those begun and not sent aren't among them.

    Reads while the site runs, too.

    Raises:
        InputError: The file can't be read or isn't a site's database.
    """
    try:
        db = _read_only(path)
        try:
            check_format(db, path)
            db.execute("BEGIN")
            for name, worker, questionnaire, started, finished in db.execute(_FINISHED):
                rows = db.execute("SELECT field, value, seconds FROM answers WHERE participant = ?", (name,)).fetchall()
                yield Answered(
                    worker=worker,
                    assignment=name,
                    questionnaire=questionnaire,
                    answers={field: value for field, value, _ in rows},
                    seconds={field: seconds for field, _, seconds in rows if seconds > 0},
                    total_seconds=max(0.0, finished - started),
                    submitted=_iso(finished),
                    source="site",
                    where=f"{path}, participant {name}",
                )
        finally:
            db.close()
    except sqlite3.Error as error:
        raise unusable_database(path, error) from error


def results_csv(path: Path) -> Iterator[str]:
    """The same as lines of a results CSV, which `crowd ingest` reads as well."""
    answered = list(read_site_results(path))
    fields = sorted({field for one in answered for field in one.answers})
    header = [
        "RequesterAnnotation",
        "AssignmentId",
        "WorkerId",
        "SubmitTime",
        "WorkTimeInSeconds",
        "Input.questionnaire",
    ]
    yield _line([*header, *(f"Answer.{field}" for field in fields), "Answer.seconds"])
    for one in answered:
        submitted = datetime.fromisoformat(one.submitted).strftime("%a %b %d %H:%M:%S UTC %Y")
        cells = [SITE, one.assignment, one.worker, submitted, f"{one.total_seconds:.0f}", one.questionnaire]
        yield _line([*cells, *(one.answers.get(field, "") for field in fields), json.dumps(dict(one.seconds))])


def _line(cells: list[str]) -> str:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerow(cells)
    return buffer.getvalue()


def _iso(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
