"""Simulated participants, who answer questionnaires as people might, and say everywhere that they are simulated.

Each follows one of the crowd's latent artists: of eight drawings it prefers the one nearest to what its artist drew
of the view, but sees distances with noise, and answers "none of these" where all are far. A stated share clicks at
random.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from dataset_tools.questionnaires.questionnaire import NONE, Key, Question, Questionnaire
from dataset_tools.simulation.artists import ArtistDrawings
from dataset_tools.simulation.simulated_results import Response, Submission
from ncmodel.chamfer import Lines, chamfer_distance
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.errors import ArgumentError
from ncmodel.images import read_grey
from ncmodel.types import Floats, Image, Mask

INK = 0.3
"""What is darker than this is seen as a line."""

COMPARED_SIDE = 384
"""Drawings are compared at this size."""


@dataclass(frozen=True)
class Crowd:
    """What the simulated participants are like.

    Attributes:
        noise: Spread of the error with which a participant sees the logarithm of a drawing's distance.
        far: A drawing farther than this is no good, in shares of the picture's side.
        random_clickers: Share of participants who click at random.
        slip: Chance that an attentive participant hits a wrong answer.
        seconds: Typical seconds for a question.
    """

    noise: float = 0.2
    far: float = 0.01
    random_clickers: float = 0.15
    slip: float = 0.004
    seconds: float = 9.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.random_clickers <= 1.0:
            raise ArgumentError("random_clickers", str(self.random_clickers), "a share in 0..1")
        if self.noise < 0:
            raise ArgumentError("noise", str(self.noise), "a number >= 0")
        if self.far <= 0:
            raise ArgumentError("far", str(self.far), "a number > 0")


class Distances:
    """How far each of an item's drawings is from each artist's, computed when first asked for.

    Args:
        data: The data folder.
        drawings: The artists' drawings.
    """

    def __init__(self, data: DataFolder, drawings: ArtistDrawings) -> None:
        self._data, self._drawings = data, drawings
        self._known: dict[Item, Floats] = {}

    def __call__(self, item: Item) -> Floats:
        """(artists, 8) symmetric Chamfer distances, in shares of the picture's side."""
        if item not in self._known:
            drawings = [1.0 - read_grey(path) for path in self._data.drawing_paths(item)]
            self._known[item] = distances_between(self._drawings.inks(item), drawings)
        return self._known[item]


def distances_between(drawn: Iterable[Image], others: Iterable[Image]) -> Floats:
    """(drawn, others) symmetric Chamfer distances between drawings, in shares of the picture's shorter side."""
    rows, columns = ([Lines.of(_seen(ink)) for ink in inks] for inks in (drawn, others))
    return np.array([[chamfer_distance(a, b) for b in columns] for a in rows]) / COMPARED_SIDE


def _seen(ink: Image) -> Mask:
    """A drawing's lines at the size at which drawings are compared."""
    height, width = ink.shape
    scale = COMPARED_SIDE / min(height, width)
    small = cv2.resize(ink, (round(width * scale), round(height * scale)), interpolation=cv2.INTER_AREA)
    return np.asarray(small > INK)


Behaviour = Callable[[Question, int, np.random.Generator], Response]
"""Answers a question (with its number, from 0) of a questionnaire."""


def attentive(crowd: Crowd, distances: Callable[[Item], Floats], artist: int) -> Behaviour:
    """A participant who follows one artist and looks at every question."""

    def answer(question: Question, number: int, rng: np.random.Generator) -> Response:
        seconds = crowd.seconds * float(np.exp(rng.normal(0, 0.5)))
        values = list(question.options)
        if rng.random() < crowd.slip:
            return Response(values[rng.integers(len(values))], seconds)
        if question.sentinel or question.item is None:
            return Response(question.correct, seconds)
        distance = distances(question.item)[artist]
        seen = np.log(np.maximum(distance, 1e-6)) + crowd.noise * rng.gumbel(size=DRAWINGS)
        best = int(np.argmin(seen))
        if seen[best] > np.log(crowd.far):
            return Response(NONE, seconds)
        return Response(next(value for value, index in question.options.items() if index == best), seconds)

    return answer


def random_clicker(question: Question, number: int, rng: np.random.Generator) -> Response:
    """A participant who clicks anywhere, quickly."""
    values = [*question.options, NONE]
    return Response(values[rng.integers(len(values))], float(rng.uniform(0.5, 3.0)))


@dataclass(frozen=True)
class Participant:
    """A simulated participant: a name that says so, what kind, and how it answers."""

    name: str
    kind: str
    behaviour: Behaviour


def make_crowd(
    count: int,
    crowd: Crowd,
    distances: Callable[[Item], Floats],
    artists: int,
    rng: np.random.Generator,
    name: str = "simulated",
) -> list[Participant]:
    """Simulated participants, of whom a stated share click at random; `name` begins their names."""
    clickers = set(rng.permutation(count)[: round(crowd.random_clickers * count)].tolist())
    people = []
    for number in range(count):
        behaviour = attentive(crowd, distances, int(rng.integers(artists)))
        known = ("random clicker", random_clicker) if number in clickers else ("attentive", behaviour)
        people.append(Participant(f"{name}-{number + 1:04d}", *known))
    return people


@dataclass(frozen=True)
class AnsweredQuestionnaire:
    """A questionnaire that a simulated participant answered."""

    participant: Participant
    questionnaire: Questionnaire
    responses: Mapping[str, Response]

    @property
    def passed(self) -> bool:
        """Whether all sentinels were answered rightly."""
        checks = (question for question in self.questionnaire.questions if question.sentinel)
        return all(question.choice(self.responses[question.field].value) == 0 for question in checks)

    @property
    def submission(self) -> Submission:
        """What comes back."""
        return Submission(self.participant.name, self.participant.kind, self.questionnaire.identifier, self.responses)


def answer_all(key: Key, participants: Iterable[Participant], seed: int) -> Iterator[AnsweredQuestionnaire]:
    """Each participant answers one questionnaire, in turn; when all are answered they go round again."""
    questionnaires = list(key.questionnaires.values())
    for number, participant in enumerate(participants):
        rng = np.random.default_rng([seed, number])
        yield answer_questionnaire(participant, questionnaires[number % len(questionnaires)], rng)


def answer_until_reliable(key: Key, participants: Iterable[Participant], seed: int) -> Iterator[AnsweredQuestionnaire]:
    """Each questionnaire is answered, and where a sentinel was failed posted again for the next participant."""
    waiting = deque(key.questionnaires.values())
    for number, participant in enumerate(participants):
        if not waiting:
            return
        answered = answer_questionnaire(participant, waiting.popleft(), np.random.default_rng([seed, number]))
        if not answered.passed:
            waiting.append(answered.questionnaire)
        yield answered


def answer_questionnaire(
    participant: Participant, questionnaire: Questionnaire, rng: np.random.Generator
) -> AnsweredQuestionnaire:
    """One participant answers one questionnaire."""
    responses = {
        question.field: participant.behaviour(question, place, rng)
        for place, question in enumerate(questionnaire.questions)
    }
    return AnsweredQuestionnaire(participant, questionnaire, responses)
