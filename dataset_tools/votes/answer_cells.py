"""What was answered in a row of a results file, whichever way its columns hold it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass

from ncmodel.parsing import parse_json

ANSWER = "Answer."
"""How the names of answers' columns begin."""

_BLOB = "Answer.taskAnswers"

_TRUE = {"true", "1", "x", "yes", "on", "checked", "wahr", "vrai", "verdadero", "verdadeiro", "vero", "waar",
         "prawda", "pravda", "sant", "sann", "sand", "tosi", "igaz", "doğru", "adevărat", "истина",
         "істина", "αληθές"}  # fmt: skip
_FALSE = {"false", "0", "no", "off", "unchecked", "falsch", "faux", "falso", "onwaar", "fałsz", "nepravda", "falskt",
          "usann", "falsk", "epätosi", "hamis", "yanlış", "fals", "ложь", "хибність", "ψευδές"}  # fmt: skip
"""What a button's column says: spreadsheets write truth values in the language of whoever saves the file."""


@dataclass(frozen=True)
class Answers:
    """What was answered.

    Attributes:
        values: Field that the row has columns for -> what was sent, "" for nothing.
        unclear: Field -> what the column of one of its buttons says that is neither true nor false.
    """

    values: Mapping[str, str]
    unclear: Mapping[str, str]


def answers_in(row: Mapping[str, str]) -> Answers:
    """The answers of a row.

    There are plain columns (`Answer.q01`), columns of one radio button each (`Answer.q01.VALUE`, true or false), and a
    blob of all, `Answer.taskAnswers`; what says something goes before what is empty.

    Raises:
        ValueError: The blob is no JSON of answers.
    """
    plain = {name[len(ANSWER) :]: cell.strip() for name, cell in row.items() if name.startswith(ANSWER)}
    blob = plain.pop(_BLOB[len(ANSWER) :], "")
    buttons: dict[str, dict[str, bool]] = {}
    unclear: dict[str, str] = {}
    for name, cell in plain.items():
        field, _, value = name.partition(".")
        if value:
            chosen = _truth(cell)
            buttons.setdefault(field, {})[value] = chosen is True
            if chosen is None:
                unclear[field] = cell
    radios = {field: _radio(chosen) for field, chosen in buttons.items()}
    found = dict.fromkeys((*plain, *radios), "")
    for answers in (_task_answers(blob) if blob else {}, radios, plain):
        found |= {name: text for name, text in answers.items() if text or name not in found}
    return Answers(found, unclear)


def _truth(cell: str) -> bool | None:
    """What a truth value says; None for another text."""
    word = cell.lower()
    if word in _TRUE:
        return True
    # Of a Turkish I in capitals the small letter depends on the language.
    return False if not word or word in _FALSE or word.replace("i", "ı") in _FALSE else None


def _task_answers(text: str) -> dict[str, str]:
    """Answers from a JSON list with one object; a radio group is an object of booleans.

    Raises:
        ValueError: It is something else.
    """
    try:
        listed = parse_json(text)
    except ValueError as error:
        raise ValueError(f"{_BLOB} is not JSON ({error})") from error
    record = listed[0] if isinstance(listed, list) and len(listed) == 1 else listed
    if not isinstance(record, dict):
        raise ValueError(f"{_BLOB} holds {type(record).__name__}; expected a list with one object")
    return {str(name): _radio(value) for name, value in record.items()}


def _radio(value: object) -> str:
    if isinstance(value, dict):
        # Several chosen values can't be an answer to one question; joined, they match none.
        return "|".join(str(name) for name, chosen in value.items() if chosen is True)
    return value if isinstance(value, str) else json.dumps(value)
