"""A trial of the rules: a simulated crowd with random clickers and adversaries, of whom it is known who should count.

Its items are made up, with distances drawn from a data folder's items, so that every item gets 3 votes however many
take part.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from dataset_tools.questionnaires.counterbalancing import DrawingOrder, QuestionOrder, assign_items
from dataset_tools.questionnaires.questionnaire import Key, Question, Questionnaire, Scheme, Tokens, field_name
from dataset_tools.simulation.adversaries import KINDS, behaviours, copy_answers
from dataset_tools.simulation.participants import (
    AnsweredQuestionnaire,
    Crowd,
    Participant,
    answer_questionnaire,
    attentive,
    make_crowd,
    random_clicker,
)
from dataset_tools.votes.consensus import Rules, aggregate
from dataset_tools.votes.reliability import Participant as Assessed
from dataset_tools.votes.reliability import assess
from dataset_tools.votes.results_csv import Answered
from dataset_tools.votes.votes import Vote, to_frame, votes_of
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.errors import ArgumentError
from ncmodel.types import Floats

HONEST = ("attentive", "second account", "sends twice")
"""Kinds whose first questionnaire is answered in earnest."""


@dataclass(frozen=True)
class KindResult:
    """What became of one kind of participant.

    Attributes:
        kind: Which.
        participants: How many.
        excluded: How many the paper's rule excludes.
        excluded_strict: How many are excluded where signs of not looking count, too.
    """

    kind: str
    participants: int
    excluded: int
    excluded_strict: int


@dataclass(frozen=True)
class RuleResult:
    """What a rule makes of the votes.

    Attributes:
        rule: Which.
        kept: Share of the items that it accepts.
        kept_of_full: The same among items with all the votes that were wanted, as all have after top-up rounds.
        right: Share of these whose accepted drawing is the one that the crowd as a whole prefers.
        pairs_right: Share of their ranking pairs in which the crowd prefers the better drawing to the other.
        votes: Votes that count.
        wrongly_excluded: Honest participants whose answers don't count.
        wrongly_kept: Others whose answers do.
    """

    rule: str
    kept: float
    kept_of_full: float
    right: float
    pairs_right: float
    votes: int
    wrongly_excluded: int
    wrongly_kept: int


@dataclass(frozen=True)
class Trial:
    """The outcome of a trial."""

    items: int
    participants: int
    kinds: Sequence[KindResult]
    rules: Sequence[RuleResult]


class SimulatedStudy:
    """Made-up items, and questionnaires about them.

    Args:
        known: (items, artists, 8) distances of real items to draw from.
        questionnaires: How many.
        rng: Source of everything random.
    """

    def __init__(self, known: Floats, questionnaires: int, rng: np.random.Generator) -> None:
        scheme = Scheme()
        count = questionnaires * scheme.real // scheme.votes
        self.items = [Item(f"made-up {number}", "0") for number in range(count)]
        self.artists = known.shape[1]
        self._distances = {item: known[rng.integers(len(known))][:, rng.permutation(DRAWINGS)] for item in self.items}
        tokens, places, positions = Tokens(0, b"trial"), QuestionOrder(rng), DrawingOrder(rng)
        blocks = assign_items(dict.fromkeys(self.items, scheme.votes), scheme.real, rng)
        made = (_questionnaire(tokens(i), block, scheme, tokens, places, positions) for i, block in enumerate(blocks))
        self.key = Key({questionnaire.identifier: questionnaire for questionnaire in made})

    def distances(self, item: Item) -> Floats:
        """(artists, 8) how far each drawing of an item is from each artist's."""
        found: Floats = self._distances[item]
        return found

    def rank(self, item: Item, index: int) -> int:
        """How many of an item's drawings the crowd as a whole likes as well as a drawing or better, without itself."""
        far = np.log(self._distances[item] + 1e-6).mean(axis=0)
        return int((far <= far[index]).sum()) - 1


def _questionnaire(
    name: str, block: Sequence[Item], scheme: Scheme, tokens: Tokens, places: QuestionOrder, positions: DrawingOrder
) -> Questionnaire:
    asked = [(item, False) for item in block] + [(Item(f"sentinel {i}", name), True) for i in range(scheme.sentinels)]
    questions = []
    for place, (item, sentinel) in enumerate(places.order(asked, asked), 1):
        options = {tokens(name, place, index): index for index in positions.order((item, sentinel))}
        questions.append(Question(field_name(place, len(asked)), item, sentinel, options))
    return Questionnaire(name, tuple(questions))


def run_trial(known: Floats, crowd: Crowd, participants: int, adversaries: int, seed: int) -> Trial:
    """Let a crowd answer, and see whom and what the rules keep.

    Args:
        known: (items, artists, 8) distances of real items to draw from.
        crowd: What the participants are like.
        participants: Of whom the crowd's share click at random.
        adversaries: How many more of each kind.
        seed: Of everything random.

    Raises:
        UsageError: There are no participants.
    """
    if participants < 10:
        raise ArgumentError("participants", str(participants), "10 or more")
    if adversaries < 0:
        raise ArgumentError("adversaries", str(adversaries), "0 or more of each kind")
    rng = np.random.default_rng([seed, 11])
    study = SimulatedStudy(known, participants + adversaries * len(KINDS), rng)
    people = make_crowd(participants, crowd, study.distances, study.artists, rng)
    for number in range(adversaries * len(KINDS)):
        kind = KINDS[number % len(KINDS)]
        honest = attentive(crowd, study.distances, int(rng.integers(study.artists)))
        people.append(Participant(f"adversary-{number:04d}", kind, behaviours(honest, study.distances)[kind]))
    order = rng.permutation(len(people))
    votes = to_frame(_votes(study, [people[i] for i in order], rng))
    return _outcome(study, votes, {person.name: person.kind for person in people})


def _votes(study: SimulatedStudy, people: Sequence[Participant], rng: np.random.Generator) -> Iterator[Vote]:
    questionnaires = list(study.key.questionnaires.values())
    for number, person in enumerate(people):
        answered = answer_questionnaire(person, questionnaires[number % len(questionnaires)], rng)
        yield from _as_votes(answered, number)
        if person.kind == "second account":
            yield from _as_votes(copy_answers(answered, f"{person.name}-again"), number)
        if person.kind == "sends twice":
            other = questionnaires[(number + 1) % len(questionnaires)]
            clicked = answer_questionnaire(replace(person, behaviour=random_clicker), other, rng)
            yield from _as_votes(clicked, number + len(people))


def _as_votes(answered: AnsweredQuestionnaire, number: int) -> Iterator[Vote]:
    name, questionnaire = answered.participant.name, answered.questionnaire
    received = Answered(
        worker=name,
        assignment=f"{name}-{number}",
        questionnaire=questionnaire.identifier,
        answers={field: response.value for field, response in answered.responses.items()},
        seconds={field: response.seconds for field, response in answered.responses.items() if response.value},
        total_seconds=None,
        submitted=f"{number:06d}",
        source="simulated",
        where="trial",
    )
    return (vote for vote in votes_of(received, questionnaire) if isinstance(vote, Vote))


def _outcome(study: SimulatedStudy, votes: pd.DataFrame, kinds: Mapping[str, str]) -> Trial:
    def kind_of(worker: str) -> str:
        return kinds.get(worker, "copy by a second account")

    usual, strict = assess(votes), assess(votes, strict=True)
    total = Counter(kind_of(worker) for worker in usual)
    results = [
        KindResult(
            kind,
            total[kind],
            sum(not person.reliable for worker, person in usual.items() if kind_of(worker) == kind),
            sum(not person.reliable for worker, person in strict.items() if kind_of(worker) == kind),
        )
        for kind in ("attentive", "random clicker", *KINDS, "copy by a second account")
        if total[kind]
    ]
    everybody = {worker: replace(person, reasons=()) for worker, person in usual.items()}
    in_earnest = votes[votes["worker"].map(kind_of).isin(HONEST)]
    earnest = {worker: person for worker, person in everybody.items() if kind_of(worker) in HONEST}
    judged = [
        _judge("only those who look", study, in_earnest, Rules(unreliable_too=True), earnest, kind_of),
        _judge("all votes, majority", study, votes, Rules(unreliable_too=True), everybody, kind_of),
        _judge("the paper's rule", study, votes, Rules(), usual, kind_of),
        _judge("the paper's rule, strict", study, votes, Rules(strict=True), strict, kind_of),
        _judge("one coin, all votes", study, votes, Rules(method="one-coin", unreliable_too=True), everybody, kind_of),
        _judge("one coin after sentinels", study, votes, Rules(method="one-coin"), usual, kind_of),
    ]
    return Trial(len(study.items), len(usual), results, judged)


def _judge(
    name: str,
    study: SimulatedStudy,
    votes: pd.DataFrame,
    rules: Rules,
    people: Mapping[str, Assessed],
    kind_of: Callable[[str], str],
) -> RuleResult:
    found = aggregate(votes, rules)
    accepted = [verdict for verdict in found.verdicts if verdict.best is not None]
    ranks = [study.rank(verdict.item, verdict.best) for verdict in accepted if verdict.best is not None]
    full = [verdict for verdict in found.verdicts if verdict.total >= Scheme().votes]
    count = max(1, len(accepted))
    return RuleResult(
        rule=name,
        kept=len(accepted) / len(study.items),
        kept_of_full=sum(verdict.best is not None for verdict in full) / max(1, len(full)),
        right=ranks.count(0) / count,
        pairs_right=1 - sum(ranks) / ((DRAWINGS - 1) * count),
        votes=sum(verdict.total for verdict in found.verdicts),
        wrongly_excluded=sum(not person.reliable and kind_of(worker) in HONEST for worker, person in people.items()),
        wrongly_kept=sum(person.reliable and kind_of(worker) not in HONEST for worker, person in people.items()),
    )
