"""The site's database: who takes part, which questionnaire they have, and what they answered.

SQLite with a write-ahead log, one connection behind a lock, every change a transaction that is on disk before the call
returns: what was acknowledged survives a crash of the server or the machine.
"""

import hashlib
import json
import os
import secrets
import sqlite3
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from dataset_tools.votes.results_sqlite import FORMAT, LOCK_SECONDS, check_format, unusable_database
from ncmodel.errors import InputError

_SCHEMA = """
CREATE TABLE IF NOT EXISTS meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS participants (
  id TEXT PRIMARY KEY,             -- public, random: the assignment's name
  token TEXT NOT NULL UNIQUE,      -- SHA-256 of the session's secret
  worker TEXT NOT NULL,            -- who the recruiting platform says it is
  parameters TEXT NOT NULL,        -- JSON: all recruiting parameters
  questionnaire TEXT NOT NULL,
  state TEXT NOT NULL CHECK (state IN ('active', 'finished', 'abandoned')),
  started REAL NOT NULL, seen REAL NOT NULL, finished REAL,
  reliable INTEGER                 -- whether all sentinels were passed, once finished
) STRICT;
CREATE UNIQUE INDEX IF NOT EXISTS one_questionnaire_each ON participants (worker) WHERE state <> 'abandoned';
CREATE INDEX IF NOT EXISTS by_questionnaire ON participants (questionnaire, state);
CREATE TABLE IF NOT EXISTS answers (
  participant TEXT NOT NULL REFERENCES participants (id), field TEXT NOT NULL,
  value TEXT NOT NULL, seconds REAL NOT NULL, at REAL NOT NULL,
  PRIMARY KEY (participant, field)
) STRICT, WITHOUT ROWID;
"""
NOTE_AFTER = 0.1
"""A participant is noted as there once in this share of the time after which they count as gone."""


class State(StrEnum):
    """What became of a participant."""

    ACTIVE = "active"
    FINISHED = "finished"
    ABANDONED = "abandoned"


class Refusal(StrEnum):
    """Why somebody can't take part."""

    FULL = "full"
    ELSEWHERE = "elsewhere"
    DONE = "done"


@dataclass(frozen=True)
class Assignment:
    """A questionnaire that a participant was given, and how far they are."""

    id: str
    worker: str
    questionnaire: str
    state: State
    started: float
    seen: float
    finished: float | None
    reliable: bool | None


@dataclass(frozen=True)
class Policy:
    """Who gets which questionnaire.

    Attributes:
        places: Participants wanted for each questionnaire.
        abandoned_after: Seconds of silence after which a questionnaire returns to the pool.
        replace_unreliable: Offer the questionnaire of a participant who failed a sentinel to somebody else.
        taken_part: Workers who took part in an earlier round and can't again.
    """

    places: int = 1
    abandoned_after: float = 3600.0
    replace_unreliable: bool = False
    taken_part: frozenset[str] = frozenset()


class SiteStore:
    """The database of one site.

    Args:
        path: The database file; made if there is none.
        questionnaires: Identifiers of the batch's questionnaires, in the order in which they are handed out.
        policy: Who gets which.
        clock: Seconds since 1970.

    Raises:
        InputError: The file isn't such a database, or belongs to another batch.
    """

    def __init__(self, path: Path, questionnaires: Sequence[str], policy: Policy, clock: Callable[[], float]) -> None:
        self._order = {name: place for place, name in enumerate(questionnaires)}
        self._policy, self._clock = policy, clock
        self._lock = threading.Lock()
        try:
            self._db = _open(path)
            self._claim(path, hashlib.sha256(json.dumps(sorted(questionnaires)).encode()).hexdigest())
        except (sqlite3.Error, OSError) as error:
            raise unusable_database(path, error) from error

    def close(self) -> None:
        """Close the database; its file then holds everything, also while somebody else has it open."""
        with self._lock:
            self._db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            self._db.close()

    def begin(self, worker: str, parameters: Mapping[str, str]) -> str | Refusal:
        """Start somebody on a questionnaire.

        Args:
            worker: Who it is.
            parameters: All recruiting parameters.

        Returns:
            The session's secret; or why there is none: the worker has begun to answer (perhaps in another browser),
            is done, or all questionnaires are taken.
        """
        if worker in self._policy.taken_part:
            return Refusal.DONE
        secret, now = secrets.token_urlsafe(32), self._clock()
        name = f"p{secrets.token_hex(12)}"  # what begins with a letter is no number to a spreadsheet
        with self._change() as db:
            self._release(db, now)
            known = _assignment(db, "state <> 'abandoned' AND worker = ?", worker)
            if known is not None:
                return self._resume(db, known, secret)
            questionnaire = self._next_questionnaire(db)
            if questionnaire is None:
                return Refusal.FULL
            db.execute(
                "INSERT INTO participants (id, token, worker, parameters, questionnaire, state, started, seen) "
                "VALUES (?, ?, ?, ?, ?, 'active', ?, ?)",
                (name, _hash(secret), worker, json.dumps(dict(parameters)), questionnaire, now, now),
            )
        return secret

    def _resume(self, db: sqlite3.Connection, assignment: Assignment, secret: str) -> str | Refusal:
        """Somebody who has begun begins again: goes on with a new secret as long as there is no answer to protect."""
        if assignment.state is State.FINISHED:
            return Refusal.DONE
        if db.execute("SELECT 1 FROM answers WHERE participant = ?", (assignment.id,)).fetchone():
            return Refusal.ELSEWHERE
        db.execute(
            "UPDATE participants SET token = ?, seen = ? WHERE id = ?", (_hash(secret), self._clock(), assignment.id)
        )
        return secret

    def find(self, secret: str) -> Assignment | None:
        """Whose session this is; who was away too long gets the questionnaire back if it is still free."""
        now = self._clock()
        with self._lock:
            assignment = _assignment(self._db, "token = ?", _hash(secret))
        recent = assignment is not None and now - assignment.seen < NOTE_AFTER * self._policy.abandoned_after
        if assignment is None or assignment.state is State.FINISHED or (assignment.state is State.ACTIVE and recent):
            return assignment
        with self._change() as db:
            assignment = _assignment(db, "id = ?", assignment.id)
            if assignment is None or assignment.state is State.FINISHED:
                return assignment
            if assignment.state is State.ABANDONED and not self._may_return(db, assignment):
                return assignment
            db.execute("UPDATE participants SET state = 'active', seen = ? WHERE id = ?", (now, assignment.id))
            return _assignment(db, "id = ?", assignment.id)

    def save(self, participant: str, answers: Mapping[str, tuple[str, float]]) -> bool:
        """Keep answers: field -> (value, seconds); a later one replaces an earlier, but 0 seconds no known time.

        Returns:
            Whether they were kept: not after the questionnaire was sent or given to somebody else.
        """
        now = self._clock()
        with self._change() as db:
            assignment = _assignment(db, "id = ?", participant)
            if assignment is None or assignment.state is not State.ACTIVE:
                return False
            db.executemany(
                "INSERT INTO answers VALUES (?, ?, ?, ?, ?) ON CONFLICT DO UPDATE SET "
                "value = excluded.value, at = excluded.at, "
                "seconds = CASE WHEN excluded.seconds > 0 THEN excluded.seconds ELSE answers.seconds END",
                [(participant, field, value, seconds, now) for field, (value, seconds) in answers.items()],
            )
            db.execute("UPDATE participants SET seen = ? WHERE id = ?", (now, participant))
        return True

    def finish(self, participant: str, judge: Callable[[Mapping[str, str]], bool | None]) -> bool:
        """The questionnaire was sent: if its answers suffice, nothing changes it any more.

        Args:
            participant: Whose.
            judge: Answers -> whether they pass all sentinels; None while some are missing.

        Returns:
            Whether the answers suffice.
        """
        with self._change() as db:
            reliable = judge(_answers(db, participant))
            if reliable is not None:
                db.execute(
                    "UPDATE participants SET state = 'finished', finished = ?, reliable = ? "
                    "WHERE id = ? AND state = 'active'",
                    (self._clock(), int(reliable), participant),
                )
        return reliable is not None

    def answers(self, participant: str) -> dict[str, str]:
        """Field -> value of what a participant answered so far."""
        with self._lock:
            return _answers(self._db, participant)

    def count_answers(self, value: str) -> dict[str, int]:
        """Participant -> how many of their answers have a value; those without any are left out."""
        with self._lock:
            query = "SELECT participant, count(*) FROM answers WHERE value = ? GROUP BY 1"
            return dict(self._db.execute(query, (value,)))

    def assignments(self) -> list[Assignment]:
        """All assignments, in the order they started; those whose participants are away too long count as abandoned."""
        with self._change() as db:
            self._release(db, self._clock())
            return [_to_assignment(row) for row in db.execute(f"{_SELECT} ORDER BY started, id")]

    def _release(self, db: sqlite3.Connection, now: float) -> None:
        limit = now - self._policy.abandoned_after
        db.execute("UPDATE participants SET state = 'abandoned' WHERE state = 'active' AND seen < ?", (limit,))

    def _taken(self, db: sqlite3.Connection) -> dict[str, int]:
        """Questionnaire -> participants who have it or sent it."""
        unless = "AND reliable IS NOT 0" if self._policy.replace_unreliable else ""
        query = f"SELECT questionnaire, count(*) FROM participants WHERE state <> 'abandoned' {unless} GROUP BY 1"
        return dict(db.execute(query))

    def _next_questionnaire(self, db: sqlite3.Connection) -> str | None:
        """The questionnaire with the fewest participants, if it has a place left."""
        taken = self._taken(db)
        name = min(self._order, key=lambda name: (taken.get(name, 0), self._order[name]), default=None)
        return name if name is not None and taken.get(name, 0) < self._policy.places else None

    def _may_return(self, db: sqlite3.Connection, assignment: Assignment) -> bool:
        query = "SELECT 1 FROM participants WHERE worker = ? AND state <> 'abandoned'"
        began_anew = db.execute(query, (assignment.worker,)).fetchone()
        return not began_anew and self._taken(db).get(assignment.questionnaire, 0) < self._policy.places

    @contextmanager
    def _change(self) -> Iterator[sqlite3.Connection]:
        with self._lock:
            self._db.execute("BEGIN IMMEDIATE")
            try:
                yield self._db
            except BaseException:
                self._db.execute("ROLLBACK")
                raise
            self._db.execute("COMMIT")

    def _claim(self, path: Path, batch: str) -> None:
        """Note which batch the answers belong to, once and for all."""
        with self._change() as db:
            db.execute("INSERT OR IGNORE INTO meta VALUES ('batch', ?)", (batch,))
            (held,) = db.execute("SELECT value FROM meta WHERE name = 'batch'").fetchone()
        if held != batch:
            raise InputError(path, "answers to another batch", "the database of this batch, or a new file")


_SELECT = "SELECT id, worker, questionnaire, state, started, seen, finished, reliable FROM participants"


def _answers(db: sqlite3.Connection, participant: str) -> dict[str, str]:
    return dict(db.execute("SELECT field, value FROM answers WHERE participant = ?", (participant,)))


def _assignment(db: sqlite3.Connection, condition: str, value: str) -> Assignment | None:
    row = db.execute(f"{_SELECT} WHERE {condition}", (value,)).fetchone()
    return None if row is None else _to_assignment(row)


def _to_assignment(row: Sequence[object]) -> Assignment:
    name, worker, questionnaire, state, started, seen, finished, reliable = row
    return Assignment(
        str(name),
        str(worker),
        str(questionnaire),
        State(str(state)),
        float(str(started)),
        float(str(seen)),
        None if finished is None else float(str(finished)),
        None if reliable is None else bool(reliable),
    )


def _hash(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()


def _open(path: Path) -> sqlite3.Connection:
    # Answers are nobody else's business; the files that SQLite adds get the same permissions.
    os.close(os.open(path, os.O_RDWR | os.O_CREAT, 0o600))
    db = sqlite3.connect(path, isolation_level=None, check_same_thread=False, timeout=LOCK_SECONDS)
    if path.stat().st_size:
        check_format(db, path)
    db.execute("PRAGMA journal_mode = WAL")
    db.execute("PRAGMA synchronous = FULL")
    db.execute("PRAGMA foreign_keys = ON")
    db.executescript(_SCHEMA)
    db.execute("INSERT OR IGNORE INTO meta VALUES ('format', ?)", (FORMAT,))
    return db
