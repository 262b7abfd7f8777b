"""A batch as the site serves it: pages filled from the template, answers that questions accept, pictures by name.

It knows the batch format and nothing of what is asked, so it serves any batch of this format.
"""

import csv
import html
import re
import sys
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from dataset_tools.questionnaire import IMAGES_NAME, NONE, TASKS_NAME, TEMPLATE_NAME, read_key
from dataset_tools.results import MAX_FIELD
from ncmodel.errors import InputError

PICTURES = "/images/"
"""Where the site serves pictures."""

_PLACEHOLDER = re.compile(r"\$\{(\w+)\}")
_INPUT = re.compile(r'name="?(q\d+)"? value="([^"]*)"')


@dataclass(frozen=True)
class Asked:
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
        try:
            self._template = (batch_dir / TEMPLATE_NAME).read_text(encoding="utf-8")
            self._rows = _read_tasks(batch_dir / TASKS_NAME)
            self.pictures = {path.name: path for path in (batch_dir / IMAGES_NAME).iterdir() if path.suffix == ".png"}
        except OSError as error:
            raise InputError(error.filename, f"can't be read ({error.strerror})", "a batch") from error
        record = read_key(batch_dir)["questionnaires"]
        self.questions = {name: _asked(entry["questions"]) for name, entry in record.items()}
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
        return question is not None and value in question.values

    def judge(self, questionnaire: str, answers: Mapping[str, str]) -> bool | None:
        """Whether answers pass all sentinels; None while some are missing."""
        asked = self.questions[questionnaire]
        if not asked.keys() <= answers.keys():
            return None
        return all(question.correct in (None, answers[field]) for field, question in asked.items())

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


def _asked(records: list[dict[str, object]]) -> dict[str, Asked]:
    questions = {}
    for record in records:
        options, words, correct = record.get("options", {}), record.get("words", [NONE]), record.get("correct")
        if not isinstance(options, dict) or not isinstance(words, list):
            raise TypeError(f"question {record.get('field')} has options {options!r}")
        right = None if correct is None else str(correct)
        questions[str(record["field"])] = Asked(frozenset([*options, *words]), right)
    return questions


def _read_tasks(path: Path) -> dict[str, dict[str, str]]:
    csv.field_size_limit(min(MAX_FIELD, sys.maxsize))
    with path.open(encoding="utf-8-sig", newline="") as file:
        read = csv.DictReader(file)
        rows = {row["questionnaire"]: {name: _local(cell) for name, cell in row.items()} for row in read}
    if not rows:
        raise InputError(path, "no questionnaire", "one a row")
    return rows


def _local(cell: str) -> str:
    """The address at which this site serves a picture, wherever the batch was meant to be served from."""
    if cell.endswith(".png"):
        return PICTURES + cell.rsplit("/", 1)[-1]
    return cell
