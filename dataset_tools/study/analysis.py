"""Answers of the perceptual study: read, checked for consistency, counted."""

import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from dataset_tools.questionnaires.questionnaire import UNSEEN
from dataset_tools.study.design import Preference, StudyKey
from dataset_tools.study.stimuli import Comparison
from dataset_tools.votes.answer_file import (
    AnswerFile,
    Identity,
    Ingested,
    append,
    read_rows,
    to_cell,
    to_seconds,
    to_whole,
)
from dataset_tools.votes.results_csv import Answered, Problem, unusable
from ncmodel.errors import InputError


@dataclass(frozen=True)
class PairAnswer:
    """One answer to one question: a row of the study's answer file.

    Attributes:
        worker: Who answered.
        assignment: Identifies the answered questionnaire.
        questionnaire: Which questionnaire.
        question: Its place there, from 1.
        case: What was drawn.
        rival: Whose drawing stood beside ours.
        flipped: Whether it was the second asking.
        answer: What was preferred.
        seconds: Time spent, None if unknown.
        source: Where the answer came from.
        submitted: When, ISO 8601 in UTC; "" if unknown.
    """

    worker: str
    assignment: str
    questionnaire: str
    question: int
    case: str
    rival: str
    flipped: bool
    answer: Preference
    seconds: float | None
    source: str
    submitted: str = ""

    @property
    def comparison(self) -> Comparison:
        """What was compared."""
        return Comparison(self.case, self.rival)


COLUMNS = tuple(one.name for one in fields(PairAnswer))


def ingest_study(answered: Iterable[Answered | Problem], key: StudyKey, out: Path) -> Ingested:
    """Append answered questionnaires to an answer file, as `answer_file.append` does.

    Raises:
        InputError: `out` exists and isn't an answer file, or there were problems and nothing else.
    """

    def interpret(one: Answered) -> list[PairAnswer | Problem] | Problem | None:
        if one.questionnaire not in key.questionnaires:
            return None
        offered = {question.field: question.answers for question in key.questionnaires[one.questionnaire]}
        return unusable(one, offered) or list(_answers(one, key))

    return append(answered, interpret, AnswerFile(COLUMNS, read_answers, _to_row, _identity, _digest), out)


def _answers(one: Answered, key: StudyKey) -> Iterator[PairAnswer | Problem]:
    for number, question in enumerate(key.questionnaires[one.questionnaire], 1):
        sent = one.answers.get(question.field, "")
        meaning = question.answers.get(sent)
        if meaning is None:
            if sent not in ("", UNSEEN):
                yield Problem(one.where, f"{question.field} is {sent[:40]!r}; expected one of its answers")
            continue
        case, rival = question.comparison.case, question.comparison.rival
        yield PairAnswer(
            one.worker, one.assignment, one.questionnaire, number, case, rival, question.flipped, meaning,
            one.seconds.get(question.field), one.source, one.submitted,
        )  # fmt: skip


def read_answers(path: Path) -> Iterator[PairAnswer]:
    """The answers in an answer file, streamed.

    Raises:
        InputError: It can't be read, lacks a column, or has a row that makes no sense.
    """
    for where, row in read_rows(path, COLUMNS, ("submitted",), "the answers of a study"):
        if row["answer"] not in set(Preference) or row["flipped"] not in ("0", "1") or not row["worker"]:
            found = f"worker {row['worker']!r}, flipped {row['flipped']!r}, answer {row['answer']!r}"
            raise InputError(where, found, f"a worker, 0 or 1, and one of {', '.join(Preference)}")
        yield PairAnswer(
            worker=row["worker"],
            assignment=row["assignment"],
            questionnaire=row["questionnaire"],
            question=to_whole(where, "question", row["question"], 1, 9999),
            case=row["case"],
            rival=row["rival"],
            flipped=row["flipped"] == "1",
            answer=Preference(row["answer"]),
            seconds=to_seconds(where, row["seconds"]),
            source=row["source"],
            submitted=row["submitted"],
        )


def _to_row(answer: PairAnswer) -> Sequence[str]:
    return [to_cell(getattr(answer, name)) for name in COLUMNS]


def _identity(answer: PairAnswer) -> Identity:
    return answer.worker, answer.assignment, answer.questionnaire


def _digest(answer: PairAnswer) -> int:
    return zlib.crc32(f"{answer.question} {answer.answer}".encode())


@dataclass(frozen=True)
class StudyResult:
    """What a study found.

    Attributes:
        inconsistent: Worker -> pairs of answers that differ or of which one is missing, in the first questionnaire.
        unreliable: Workers with too many of them.
        counts: Rival -> preference -> consistent answers that count.
        short: Comparisons with fewer consistent answers than wanted -> how many they lack.
        comparisons: All comparisons, those that nobody answered too.
        simulated: Whether nobody gave some of the answers.
    """

    inconsistent: Mapping[str, int]
    unreliable: frozenset[str]
    counts: Mapping[str, Mapping[Preference, int]]
    short: Mapping[Comparison, int]
    comparisons: Sequence[Comparison]
    simulated: bool


def evaluate_study(
    answers: Iterable[PairAnswer],
    wanted: int = 3,
    most_inconsistent: int = 7,
    asked: Iterable[Comparison] = (),
) -> StudyResult:
    """Find consistent answers and count them; the order of answers never matters.

    Of each worker the first questionnaire counts. An answer to a comparison is consistent if both askings got the
    same one. Each comparison counts its first `wanted` consistent answers of reliable workers, so that none weighs
    more.

    Args:
        answers: All answers.
        wanted: Consistent answers for each comparison.
        most_inconsistent: A worker with more inconsistent pairs is unreliable.
        asked: Comparisons of the study, so that one without any answer is known to lack all.
    """
    everything = list(answers)
    by_worker: dict[str, list[PairAnswer]] = {}
    for answer in everything:
        by_worker.setdefault(answer.worker, []).append(answer)
    first = {worker: _first(own) for worker, own in sorted(by_worker.items())}
    inconsistent = {worker: sum(answer is None for answer in _pairs(own).values()) for worker, own in first.items()}
    unreliable = frozenset(worker for worker, count in inconsistent.items() if count > most_inconsistent)
    compared = {*asked, *(answer.comparison for answer in everything)}
    given: dict[Comparison, list[tuple[str, str, Preference]]] = {comparison: [] for comparison in sorted(compared)}
    for worker, own in first.items():
        for comparison, preference in _pairs(own).items() if worker not in unreliable else ():
            if preference is not None:
                given[comparison].append((own[0].submitted or "~", worker, preference))
    counts: dict[str, Counter[Preference]] = {comparison.rival: Counter() for comparison in given}
    for comparison, entries in given.items():
        counts[comparison.rival].update(preference for _, _, preference in sorted(entries)[:wanted])
    short = {one: wanted - len(entries) for one, entries in given.items() if len(entries) < wanted}
    simulated = any(answer.source == "simulated" for answer in everything)
    return StudyResult(inconsistent, unreliable, counts, short, list(given), simulated)


def _first(own: Sequence[PairAnswer]) -> list[PairAnswer]:
    """The answers of a worker's first questionnaire."""
    first = min((answer.submitted or "~", answer.assignment, answer.questionnaire) for answer in own)
    return [answer for answer in own if (answer.submitted or "~", answer.assignment, answer.questionnaire) == first]


def _pairs(own: Sequence[PairAnswer]) -> dict[Comparison, Preference | None]:
    """Comparison -> the answer given both times; None where they differ or one is missing."""
    asked: dict[Comparison, dict[bool, Preference]] = {}
    for answer in own:
        asked.setdefault(answer.comparison, {})[answer.flipped] = answer.answer
    return {
        comparison: both[False] if len(both) == 2 and both[False] == both[True] else None
        for comparison, both in sorted(asked.items())
    }
