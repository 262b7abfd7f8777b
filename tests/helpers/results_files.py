"""A batch of two questionnaires, and results files of it."""

import csv
import io

from dataset_tools.questionnaires.questionnaire import NONE, Key, Question, Questionnaire
from ncmodel.data.item import Item

FIELDS = ("q01", "q02", "q03")


def make_key() -> Key:
    """Two questionnaires of two items and a sentinel."""
    questionnaires = {}
    for name in ("A", "B"):
        questions = [
            Question(
                field, Item(f"shape{place}", "0"), place == 1, {f"{name}{field}v{i}": (i + 3) % 8 for i in range(8)}
            )
            for place, field in enumerate(FIELDS)
        ]
        questionnaires[name] = Questionnaire(name, tuple(questions))
    return Key(questionnaires)


KEY = make_key()


def value(questionnaire: str, field: str, choice: int) -> str:
    question = next(q for q in KEY.questionnaires[questionnaire].questions if q.field == field)
    return NONE if choice < 0 else next(v for v, index in question.options.items() if index == choice)


def row(worker: str, questionnaire: str, choices: tuple[int, int, int], **more: str) -> dict[str, str]:
    answers = {f"Answer.{f}": value(questionnaire, f, c) for f, c in zip(FIELDS, choices, strict=True)}
    return {
        "AssignmentId": f"{worker}-{questionnaire}",
        "WorkerId": worker,
        "SubmitTime": "Fri Nov 01 12:08:17 PDT 2019",
        "WorkTimeInSeconds": "60",
        "Input.questionnaire": questionnaire,
        **answers,
        **more,
    }


ROWS = [row("w1", "A", (0, 0, 5)), row("w2", "A", (1, 0, -1)), row("w3", "B", (2, 4, 2)), row("w4", "B", (3, 0, 7))]


def to_csv(rows: list[dict[str, str]], columns: list[str] | None = None, line: str = "\n", bom: bool = False) -> bytes:
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, columns or list(rows[0]), lineterminator=line, extrasaction="ignore", restval="")
    writer.writeheader()
    writer.writerows(rows)
    return (b"\xef\xbb\xbf" if bom else b"") + buffer.getvalue().encode()
