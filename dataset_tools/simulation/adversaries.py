"""Simulated participants who don't play fair: ten ways not to look, for testing what finds them out."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from dataset_tools.questionnaires.questionnaire import NONE, Question
from dataset_tools.simulation.participants import AnsweredQuestionnaire, Behaviour, random_clicker
from dataset_tools.simulation.simulated_results import Response
from ncmodel.data.item import Item
from ncmodel.types import Floats

Distance = Callable[[Item], Floats]


def always_first(question: Question, number: int, rng: np.random.Generator) -> Response:
    """Takes the first drawing, whatever it is."""
    return Response(next(iter(question.options)), float(rng.uniform(0.6, 2.0)))


def always_none(question: Question, number: int, rng: np.random.Generator) -> Response:
    """Finds nothing good."""
    return Response(NONE, float(rng.uniform(0.6, 2.0)))


def straight_liner(question: Question, number: int, rng: np.random.Generator) -> Response:
    """Goes through the positions in turn."""
    return Response(list(question.options)[number % len(question.options)], float(rng.uniform(0.8, 2.5)))


def scripted(question: Question, number: int, rng: np.random.Generator) -> Response:
    """A program that takes the answer whose value sorts first, at human speed."""
    return Response(min(question.options), float(rng.uniform(4.0, 14.0)))


def hasty(honest: Behaviour) -> Behaviour:
    """Looks at half of the questions, in a second each."""

    def answer(question: Question, number: int, rng: np.random.Generator) -> Response:
        behaviour = honest if rng.random() < 0.5 else random_clicker
        return replace(behaviour(question, number, rng), seconds=float(rng.uniform(0.5, 1.4)))

    return answer


def sentinel_wise(question: Question, number: int, rng: np.random.Generator) -> Response:
    """Knows sentinels when seeing them, and clicks anywhere else."""
    if question.sentinel:
        return Response(question.correct, float(rng.uniform(2.0, 6.0)))
    return random_clicker(question, number, rng)


def contrarian(distances: Distance) -> Behaviour:
    """Passes sentinels and takes the worst drawing elsewhere."""

    def answer(question: Question, number: int, rng: np.random.Generator) -> Response:
        seconds = float(rng.uniform(4.0, 14.0))
        if question.sentinel or question.item is None:
            return Response(question.correct, seconds)
        worst = int(np.argmax(distances(question.item).mean(axis=0)))
        return Response(next(value for value, index in question.options.items() if index == worst), seconds)

    return answer


def quitter(honest: Behaviour) -> Behaviour:
    """Answers the first half and sends the rest empty."""

    def answer(question: Question, number: int, rng: np.random.Generator) -> Response:
        return honest(question, number, rng) if number < 17 else Response("", 0.0)

    return answer


def copy_answers(answered: AnsweredQuestionnaire, name: str) -> AnsweredQuestionnaire:
    """A second account of the same person sends the same answers again."""
    return replace(answered, participant=replace(answered.participant, name=name, kind="second account"))


KINDS: Sequence[str] = (
    "always first",
    "always none",
    "straight-liner",
    "scripted",
    "hasty",
    "sentinel-wise clicker",
    "contrarian",
    "quitter",
    "second account",
    "sends twice",
)
"""What an adversary can be. Who sends twice answers another questionnaire, as a random clicker."""


def behaviours(honest: Behaviour, distances: Distance) -> Mapping[str, Behaviour]:
    """How each kind of adversary answers a questionnaire; `honest` is what those do who look at first."""
    return {
        "always first": always_first,
        "always none": always_none,
        "straight-liner": straight_liner,
        "scripted": scripted,
        "hasty": hasty(honest),
        "sentinel-wise clicker": sentinel_wise,
        "contrarian": contrarian(distances),
        "quitter": quitter(honest),
        "second account": honest,
        "sends twice": honest,
    }
