"""Simulated participants of the perceptual study, who try its loop and say everywhere that they are simulated.

They don't look at the drawings. Every drawing has a made-up appeal, from one distribution for all methods, so that
nothing they answer says which method is better.
"""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dataset_tools.simulation.simulated_results import Response, Submission, crowd_name, write_results
from dataset_tools.study.design import PairQuestion, Preference, StudyKey
from ncmodel.errors import ArgumentError

GOOD = -1.0
"""A drawing whose appeal (normal, mean 0, deviation 1) is below isn't found good."""

AS_GOOD = 0.3
"""Drawings whose appeals are nearer than this are found equally good."""


@dataclass(frozen=True)
class StudyCrowd:
    """What simulated participants of a study are like.

    Attributes:
        noise: Spread of the error with which an appeal is seen, anew each time.
        random_clickers: Share of participants who click at random.
        seconds: Typical seconds for a question.
    """

    noise: float = 0.15
    random_clickers: float = 0.15
    seconds: float = 6.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.random_clickers <= 1.0:
            raise ArgumentError("random_clickers", str(self.random_clickers), "a share in 0..1")
        if self.noise < 0:
            raise ArgumentError("noise", str(self.noise), "a number >= 0")


def simulate_study(
    batch_dir: Path, out: Path, crowd: StudyCrowd, participants: int | None = None, seed: int = 0
) -> dict[str, object]:
    """Let simulated participants answer a study, and write their results in Mechanical Turk's format.

    Args:
        batch_dir: The study's batch.
        out: Results file to write.
        crowd: What the participants are like.
        participants: How many, each questionnaire answered in turn; by default as many as it takes for each to be
            answered by somebody who is reliable.
        seed: Of everything random. Appeals depend on it alone, so that a later batch of the study finds the same.

    Raises:
        UsageError: There are no participants.
        InputError: The batch's key can't be read.
    """
    if participants is not None and participants < 1:
        raise ArgumentError("participants", str(participants), "1 or more")
    key = StudyKey.load(batch_dir)
    fields = sorted({question.field for questions in key.questionnaires.values() for question in questions})
    kinds = write_results(out, _answered(key, crowd, participants, seed), fields)
    return {"simulated_participants": kinds.total(), **kinds, "questionnaires": len(key.questionnaires)}


def _answered(key: StudyKey, crowd: StudyCrowd, participants: int | None, seed: int) -> Iterator[Submission]:
    """The questionnaires as they come back; one that isn't answered reliably is posted again."""
    appeal = _Appeal(seed)
    waiting, name = deque(key.questionnaires), crowd_name(seed, key.questionnaires)
    # Enough for all to be answered reliably, however many clickers there are.
    for number in range(participants or 10 + 20 * len(key.questionnaires)):
        if not waiting:
            return
        identifier, rng = waiting.popleft(), np.random.default_rng([seed, 1, number])
        questions = key.questionnaires[identifier]
        clicks = bool(rng.random() < crowd.random_clickers)
        responses = {one.field: _click(one, rng) if clicks else _look(one, appeal, crowd, rng) for one in questions}
        if participants or _inconsistent(questions, responses) > key.scheme.most_inconsistent:
            waiting.append(identifier)
        yield Submission(f"{name}-{number + 1:04d}", "random clicker" if clicks else "attentive", identifier, responses)


class _Appeal:
    """The made-up appeal of every drawing."""

    def __init__(self, seed: int) -> None:
        self._seed = seed

    def __call__(self, case: str, method: str) -> float:
        return float(np.random.default_rng([self._seed, 2, *f"{method}/{case}".encode()]).normal())


def _look(question: PairQuestion, appeal: _Appeal, crowd: StudyCrowd, rng: np.random.Generator) -> Response:
    case, rival = question.comparison.case, question.comparison.rival
    # A rival's name always has characters, so "" is nobody's.
    ours, theirs = (appeal(case, method) + crowd.noise * rng.normal() for method in ("", rival))
    if max(ours, theirs) < GOOD:
        meaning = Preference.NONE
    elif abs(ours - theirs) < AS_GOOD:
        meaning = Preference.BOTH
    else:
        meaning = Preference.OURS if ours > theirs else Preference.RIVAL
    value = next(value for value, one in question.answers.items() if one is meaning)
    return Response(value, crowd.seconds * float(np.exp(rng.normal(0, 0.5))))


def _click(question: PairQuestion, rng: np.random.Generator) -> Response:
    values = list(question.answers)
    return Response(values[rng.integers(len(values))], float(rng.uniform(0.5, 3.0)))


def _inconsistent(questions: Sequence[PairQuestion], responses: Mapping[str, Response]) -> int:
    """Comparisons that were answered differently the second time."""
    first, second = (
        {one.comparison: one.answers[responses[one.field].value] for one in questions if one.flipped is flipped}
        for flipped in (False, True)
    )
    return sum(second[comparison] is not meaning for comparison, meaning in first.items())
