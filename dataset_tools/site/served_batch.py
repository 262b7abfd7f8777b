"""A batch as the site serves it: pages filled from the template, answers that questions accept, pictures by name.

It knows the batch format and nothing of what is asked, so it serves any batch of this format.
"""

import csv
import html
import io
import re
import sys
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from dataset_tools.questionnaires.questionnaire import (
    IMAGES_NAME,
    KEY_NAME,
    NONE,
    TASKS_NAME,
    TEMPLATE_NAME,
    UNSEEN,
    read_key,
)
from dataset_tools.votes.tables import MAX_FIELD
from ncmodel.errors import InputError

PICTURES = "/images/"
"""Where the site serves pictures."""

_PLACEHOLDER = re.compile(r"\$\{(\w+)\}")
_INPUT = re.compile(r'name="?(q\d+)"? value="([^"]*)"')


@dataclass(frozen=True)
class AcceptedAnswers:
    """What the site knows of a question: which answers it takes, and for a sentinel which one is right."""

    values: frozenset[str]
    correct: str | None


class SiteBatch:
    """A batch of questionnaires, read once.

    Args:
        batch_dir: The batch folder.

    Raises:
        InputError: A file is missing, or the files don't belong together.
    """

    def __init__(self, batch_dir: Path) -> None:
        self._template = _read(batch_dir / TEMPLATE_NAME)
        self._rows = _read_tasks(batch_dir / TASKS_NAME)
        try:
            self.pictures = _pictures(batch_dir / IMAGES_NAME)
        except OSError as error:
            raise InputError(error.filename, f"can't be read ({error.strerror})", "the pictures of a batch") from error
        record = read_key(batch_dir)["questionnaires"]
        try:
            self.questions = {name: _accepted_answers(entry["questions"]) for name, entry in record.items()}
        except (KeyError, TypeError, AttributeError) as error:
            found = f"not the key of a batch ({type(error).__name__}: {error})"
            raise InputError(batch_dir / KEY_NAME, found, "a key that `ncontours crowd build` wrote") from error
        if set(self.questions) != set(self._rows):
            found = f"{len(self._rows)} questionnaires"
            raise InputError(batch_dir / TASKS_NAME, found, f"the key's {len(self.questions)}, the same ones")
        missing = set(_PLACEHOLDER.findall(self._template)) - set(next(iter(self._rows.values())))
        if missing:
            found = f"a placeholder {sorted(missing)[0]!r}"
            raise InputError(batch_dir / TEMPLATE_NAME, found, f"columns of {TASKS_NAME} only")

    @property
    def identifiers(self) -> list[str]:
        """The questionnaires, in the order of the task list."""
        return list(self._rows)

    def accepts(self, questionnaire: str, field: str, value: str) -> bool:
        """Whether a value is an answer to a question."""
        question = self.questions[questionnaire].get(field)
        return question is not None and (value == UNSEEN or value in question.values)

    def judge(self, questionnaire: str, answers: Mapping[str, str]) -> bool | None:
        """Whether answers pass all sentinels that were seen; None while some are missing."""
        asked = self.questions[questionnaire]
        if not asked.keys() <= answers.keys():
            return None
        return all(
            answers[field] == UNSEEN or question.correct in (None, answers[field]) for field, question in asked.items()
        )

    def fragment(self, questionnaire: str, answers: Mapping[str, str]) -> str:
        """A questionnaire as HTML, with the given answers chosen."""
        row = self._rows[questionnaire]
        filled = _PLACEHOLDER.sub(lambda match: html.escape(row[match[1]]), self._template)

        def chosen(match: re.Match[str]) -> str:
            return match[0] + (" checked" if answers.get(match[1]) == match[2] else "")

        return _INPUT.sub(chosen, filled)

    def hashes(self, kind: str) -> list[str]:
        """What a content security policy names the template's own scripts or styles by."""
        blocks = re.findall(rf"<{kind}>(.*?)</{kind}>", self._template, re.DOTALL)
        return [f"'sha256-{b64encode(sha256(block.encode()).digest()).decode()}'" for block in blocks]


def _pictures(folder: Path) -> dict[str, Path]:
    """Name -> picture. One that is a link to somewhere else could show anything, the key too, to everybody."""
    found = {path.name: path for path in folder.iterdir() if path.suffix == ".png"}
    for path in found.values():
        if path.is_symlink() and path.resolve().parent != folder.resolve():
            raise InputError(path, f"a link to {path.resolve()}", f"a picture in {folder}")
    return found


def _accepted_answers(records: list[dict[str, object]]) -> dict[str, AcceptedAnswers]:
    questions = {}
    for record in records:
        options, words, correct = record.get("options", {}), record.get("words", [NONE]), record.get("correct")
        if not isinstance(options, dict) or not isinstance(words, list):
            raise TypeError(f"question {record.get('field')} has options {options!r}")
        right = None if correct is None else str(correct)
        questions[str(record["field"])] = AcceptedAnswers(frozenset([*options, *words]), right)
    return questions


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", "a file of a batch") from error
    except UnicodeDecodeError as error:
        raise InputError(path, f"not UTF-8 ({error.reason})", "a file of a batch") from error


def _read_tasks(path: Path) -> dict[str, dict[str, str]]:
    """Questionnaire -> its row, pictures at the addresses of this site."""
    csv.field_size_limit(min(MAX_FIELD, sys.maxsize))
    expected = "a header with questionnaire, and a row for each with as many cells"
    rows: dict[str, dict[str, str]] = {}
    try:
        header, *lines = list(csv.reader(io.StringIO(_read(path), newline=""))) or [[]]
    except csv.Error as error:
        raise InputError(path, f"not CSV ({error})", expected) from error
    for number, cells in enumerate(lines, 2):
        row = dict(zip(header, map(_local, cells), strict=False))
        if len(cells) != len(header) or len(row) != len(header) or row.get("questionnaire", "") in ("", *rows):
            found = f"{len(cells)} cells, questionnaire {row.get('questionnaire', '')!r}"
            raise InputError(f"{path}, row {number}", found, expected)
        rows[row["questionnaire"]] = row
    if not rows:
        raise InputError(path, "no questionnaire", expected)
    return rows


def _local(cell: str) -> str:
    """The address at which this site serves a picture, wherever the batch was meant to be served from."""
    if cell.endswith(".png"):
        return PICTURES + cell.rsplit("/", 1)[-1]
    return cell
