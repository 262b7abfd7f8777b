"""What a participant is asked, and the key that says what every answer means.

The key (`key.json`) stays with the requester. Everything that a participant receives carries opaque names: the
identifier of a questionnaire, the value of an answer and the name of a picture come from `Tokens` and say nothing.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dataset_tools.questionnaires.identical_drawings import ALL_DIFFERENT, Twins, from_record, to_record
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.errors import ArgumentError, InputError, UsageError
from ncmodel.parsing import parse_json

NONE = "none"
"""The answer "none of these line drawings are good"."""

UNSEEN = "unseen"
"""What is sent instead of an answer where a question's pictures didn't come: no vote, and no failed sentinel."""

KEY_NAME = "key.json"
TASKS_NAME = "tasks.csv"
TEMPLATE_NAME = "template.html"
IMAGES_NAME = "images"


@dataclass(frozen=True)
class Scheme:
    """How questionnaires are put together; the defaults are the paper's (appendix 5).

    Attributes:
        real: Questions about items in each questionnaire.
        sentinels: Sentinel questions in each questionnaire.
        pool: Sentinels to draw from.
        votes: Answers that each item gets.
        seed: Of everything random; with the data set's contents it also keys the opaque names.
    """

    real: int = 30
    sentinels: int = 5
    pool: int = 15
    votes: int = 3
    seed: int = 0

    def __post_init__(self) -> None:
        for name, least in (("real", 1), ("sentinels", 0), ("votes", 1), ("seed", 0)):
            if getattr(self, name) < least:
                raise ArgumentError(name, str(getattr(self, name)), f"{least} or more")
        if self.pool < self.sentinels:
            raise ArgumentError("pool", str(self.pool), f"at least the sentinels of a questionnaire ({self.sentinels})")
        if self.real + self.sentinels > 999:
            raise UsageError(f"{self.real + self.sentinels} questions in a questionnaire, expected at most 999")


@dataclass(frozen=True)
class Question:
    """One question as shown: its drawings in order, and what each answer means.

    Attributes:
        field: Name of the answer's form field ("q01").
        item: The view that the question shows; None where a key doesn't tell (sentinels).
        sentinel: Whether it checks the participant instead of asking about the item.
        options: Answer value -> drawing 0..7, in the order shown. In a sentinel 0 is the artist's drawing of
            the shape, 1..7 are drawings of others.
        twins: Which of the item's drawings are the same picture.
    """

    field: str
    item: Item | None
    sentinel: bool
    options: Mapping[str, int]
    twins: Twins = ALL_DIFFERENT

    @property
    def number(self) -> int:
        """Its place in the questionnaire, from 1."""
        return int(self.field[1:])

    @property
    def correct(self) -> str:
        """The value of a sentinel's right answer."""
        return next(value for value, index in self.options.items() if index == 0)

    def position(self, value: str) -> int:
        """Where an answer stands on the page: 1..8, or 0 for "none of these"."""
        return 0 if value == NONE else list(self.options).index(value) + 1

    def choice(self, value: str) -> int | None:
        """The drawing 0..7 that an answer means: -1 for "none of these", None if it is no answer here."""
        return -1 if value == NONE else self.options.get(value)


@dataclass(frozen=True)
class Questionnaire:
    """The questions that one participant answers."""

    identifier: str
    questions: tuple[Question, ...]

    @property
    def items(self) -> Iterator[Item]:
        """The items asked about; sentinels aren't among them."""
        return (question.item for question in self.questions if not question.sentinel and question.item is not None)


@dataclass(frozen=True)
class Key:
    """All questionnaires of a batch and what their answers mean.

    Attributes:
        questionnaires: By identifier, in the order of `tasks.csv`.
        settings: How the batch was made: data folder, scheme, where the sentinels' drawings come from.
    """

    questionnaires: Mapping[str, Questionnaire]
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def items(self) -> list[Item]:
        """All items asked about, sorted."""
        return sorted({item for questionnaire in self.questionnaires.values() for item in questionnaire.items})

    def record(self) -> dict[str, Any]:
        """What `key.json` holds."""
        questionnaires = {
            identifier: {"questions": [_to_record(question) for question in questionnaire.questions]}
            for identifier, questionnaire in self.questionnaires.items()
        }
        return {**self.settings, "questionnaires": questionnaires}

    @staticmethod
    def load(batch_dir: str | Path) -> "Key":
        """Read the key of a batch folder.

        Raises:
            InputError: There is none, or it isn't one.
        """
        record = read_key(batch_dir)
        try:
            listed = record.pop("questionnaires")
            questionnaires = {name: _questionnaire(name, entry["questions"]) for name, entry in listed.items()}
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            found = f"not a key of 8-drawing questions ({type(error).__name__}: {error})"
            raise InputError(Path(batch_dir) / KEY_NAME, found, "a key that `ncontours crowd build` wrote") from error
        return Key(questionnaires, record)


def read_key(batch_dir: str | Path) -> dict[str, Any]:
    """The key of a batch folder as it is, whatever is asked there.

    Raises:
        InputError: There is none, or it isn't one.
    """
    path = Path(batch_dir) / KEY_NAME
    expected = "the key of a batch of questionnaires"
    try:
        record = parse_json(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", expected) from error
    except ValueError as error:
        raise InputError(path, f"not JSON ({error})", expected) from error
    listed = record.get("questionnaires") if isinstance(record, dict) else None
    entries = listed.values() if isinstance(listed, dict) else [None]
    if not all(isinstance(entry, dict) and isinstance(entry.get("questions"), list) for entry in entries):
        raise InputError(path, "no questionnaires", expected)
    return dict(record)


class Tokens:
    """Opaque names: a keyed hash of what they stand for.

    The same secret and parts give the same token; without the secret nothing can be read from it nor can another be
    guessed.
    """

    def __init__(self, seed: int, contents: bytes) -> None:
        self._secret = hashlib.blake2b(contents, key=str(seed).encode(), digest_size=32).digest()

    def __call__(self, *parts: object, size: int = 8) -> str:
        """`size` bytes as hexadecimal digits, of which the first is a letter.

        A spreadsheet takes `123456789012e456` and `0041..` for numbers and saves others in their place.
        """
        digits = self._hash(parts, size)
        return "abcdef"[int(digits[0], 16) % 6] + digits[1:]

    def number(self, *parts: object) -> int:
        """A number of 64 bits, to seed what is random."""
        return int(self._hash(parts, 8), 16)

    def _hash(self, parts: tuple[object, ...], size: int) -> str:
        text = json.dumps([str(part) for part in parts])
        return hashlib.blake2b(text.encode(), key=self._secret, digest_size=size).hexdigest()


def field_name(number: int, total: int) -> str:
    """The form field of question `number` (from 1): q01 .. q35, wider where there are over 99 questions."""
    return f"q{number:0{max(2, len(str(total)))}d}"


def _to_record(question: Question) -> dict[str, Any]:
    place = question.item.record if question.item else {}
    record: dict[str, Any] = {"field": question.field, **place, "sentinel": question.sentinel}
    if question.sentinel:
        record["correct"] = question.correct
    if question.twins != ALL_DIFFERENT:
        record["twins"] = to_record(question.twins)
    return {**record, "options": dict(question.options)}


def _questionnaire(identifier: str, records: list[dict[str, Any]]) -> Questionnaire:
    questions = tuple(_from_record(record) for record in records)
    if len({question.field for question in questions}) != len(questions):
        raise ValueError(f"questionnaire {identifier} has a field twice")
    return Questionnaire(identifier, questions)


def _from_record(record: dict[str, Any]) -> Question:
    sentinel = record["sentinel"]
    options = record["options"] if not sentinel else record.get("options", {record.get("correct"): 0})
    item = Item(str(record["shape"]), str(record["view"])) if "shape" in record or not sentinel else None
    known = all(isinstance(value, str) and type(index) is int for value, index in options.items())
    in_range = all(0 <= index < DRAWINGS for index in options.values()) if known else False
    if not isinstance(sentinel, bool) or not in_range or not record["field"][1:].isdigit():
        raise ValueError(f"question {record['field']} has options {options}, sentinel {sentinel}")
    if sentinel and record.get("correct", "") not in options:
        raise ValueError(f"the sentinel {record['field']} has no right answer")
    if sentinel and options[record["correct"]] != 0:
        options = {value: 0 if value == record["correct"] else max(index, 1) for value, index in options.items()}
    return Question(record["field"], item, sentinel, options, from_record(record.get("twins", {})))
