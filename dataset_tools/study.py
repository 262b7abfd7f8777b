"""The perceptual study (appendix 6): two methods' drawings of a shape side by side, every pair asked about twice.

A questionnaire has 15 pairs, then the same 15 with sides swapped in another order: who answers more than 7 of them
differently the second time is unreliable.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from dataset_tools.batch_files import BatchWriter, Look, Sheet, Shown
from dataset_tools.pages import pair_template
from dataset_tools.questionnaire import KEY_NAME, NONE, Item, Tokens, field_name, read_key
from dataset_tools.spread import deal
from ncmodel.errors import InputError, UsageError

BOTH = "both"
"""The answer "both drawings convey the shape equally well"."""


class Preference(StrEnum):
    """What an answer means."""

    OURS = "ours"
    RIVAL = "rival"
    BOTH = "both"
    NONE = "none"


@dataclass(frozen=True, order=True)
class Comparison:
    """Our drawing of a case against a rival's."""

    case: str
    rival: str


@dataclass(frozen=True)
class StudyScheme:
    """How the study's questionnaires are put together; the defaults are the paper's.

    Attributes:
        pairs: Different comparisons in a questionnaire; each is asked about twice.
        answers: Consistent answers that each comparison should get.
        most_inconsistent: A participant with more inconsistent pairs of answers is unreliable.
        seed: Of everything random.
    """

    pairs: int = 15
    answers: int = 3
    most_inconsistent: int = 7
    seed: int = 0

    def __post_init__(self) -> None:
        for name, least in (("pairs", 1), ("answers", 1), ("most_inconsistent", 0), ("seed", 0)):
            if getattr(self, name) < least:
                raise UsageError(f"--{name.replace('_', '-')} is {getattr(self, name)}, expected {least} or more")


@dataclass(frozen=True)
class PairQuestion:
    """A question as the key knows it.

    Attributes:
        field: Name of its form field.
        comparison: What is compared.
        flipped: Whether it is the second asking.
        answers: Value -> what it means, the left drawing's first.
    """

    field: str
    comparison: Comparison
    flipped: bool
    answers: Mapping[str, Preference]


@dataclass(frozen=True)
class StudyKey:
    """All questionnaires of a study: identifier -> questions; and how it was made."""

    questionnaires: Mapping[str, Sequence[PairQuestion]]
    ours: str
    scheme: StudyScheme

    def record(self) -> dict[str, Any]:
        """What `key.json` holds; `shape` and `view` of a question are its case and rival."""
        return {
            "study": "pairs",
            "ours": self.ours,
            "scheme": asdict(self.scheme),
            "questionnaires": {
                name: {"questions": [_to_record(question) for question in questions]}
                for name, questions in self.questionnaires.items()
            },
        }

    @staticmethod
    def load(batch_dir: str | Path) -> "StudyKey":
        """Read the key of a study's batch folder.

        Raises:
            InputError: There is none, or it is of another kind.
        """
        record = read_key(batch_dir)
        try:
            questionnaires = {
                name: [_from_record(question) for question in entry["questions"]]
                for name, entry in record["questionnaires"].items()
            }
            return StudyKey(questionnaires, str(record["ours"]), StudyScheme(**record["scheme"]))
        except (KeyError, TypeError, ValueError) as error:
            found = f"not the key of a study ({type(error).__name__}: {error})"
            expected = "a key that `ncontours crowd study build` wrote"
            raise InputError(Path(batch_dir) / KEY_NAME, found, expected) from error


def _to_record(question: PairQuestion) -> dict[str, Any]:
    return {
        "field": question.field,
        "shape": question.comparison.case,
        "view": question.comparison.rival,
        "flipped": question.flipped,
        "options": {value: meaning.value for value, meaning in question.answers.items() if value not in (BOTH, NONE)},
        "words": [BOTH, NONE],
    }


def _from_record(record: Mapping[str, Any]) -> PairQuestion:
    answers = {value: Preference(meaning) for value, meaning in record["options"].items()}
    answers |= {BOTH: Preference.BOTH, NONE: Preference.NONE}
    comparison = Comparison(record["shape"], record["view"])
    return PairQuestion(record["field"], comparison, bool(record["flipped"]), answers)


@dataclass(frozen=True)
class StudyFolders:
    """Where the study's pictures are.

    Attributes:
        ours: Folder with our drawings, CASE.png.
        rivals: Rival's name -> folder with its drawings of the same cases.
        renders: Folder with renders of the shapes, CASE/*.png, the same number for each case.
    """

    ours: Path
    rivals: Mapping[str, Path]
    renders: Path

    def cases(self) -> list[str]:
        """The cases: what we have drawings of.

        Raises:
            InputError: There are none, or a rival's drawing or the renders of one are missing.
        """
        names = sorted(path.stem for path in self.ours.glob("*.png"))
        if not names:
            raise InputError(self.ours, "no drawings", "CASE.png for each case")
        for name in names:
            for folder in self.rivals.values():
                if not (folder / f"{name}.png").is_file():
                    raise InputError(folder / f"{name}.png", "no such file", f"a drawing, as {self.ours} has one")
        counts = {name: len(self.render_paths(name)) for name in names}
        few = min(counts, key=lambda name: counts[name])
        if counts[few] == 0 or counts[few] != max(counts.values()):
            found = f"{counts[few]} renders"
            raise InputError(self.renders / few, found, f"as many as others have ({max(counts.values())}), 1 or more")
        return names

    def render_paths(self, case: str) -> list[Path]:
        """The renders of a case, in order."""
        return sorted((self.renders / case).glob("*.png"), key=lambda path: (len(path.stem), path.stem))

    def drawing(self, case: str, rival: str | None) -> Path:
        """A drawing of a case: the rival's, or ours."""
        return (self.ours if rival is None else self.rivals[rival]) / f"{case}.png"


def build_study(folders: StudyFolders, ours: str, scheme: StudyScheme, look: Look, batch_dir: Path) -> StudyKey:
    """Write the batch folder of a study.

    Args:
        folders: Where the pictures are.
        ours: What our method is called.
        scheme: Numbers of questions.
        look: How pictures are delivered.
        batch_dir: A folder that doesn't exist yet or is empty.

    Raises:
        UsageError: The folder holds something, or there are no rivals.
        InputError: A picture is missing or can't be read.
    """
    if not folders.rivals:
        raise UsageError("no rivals: there is nothing to compare with")
    cases = folders.cases()
    contents = b"".join(folders.drawing(case, None).read_bytes() for case in cases)
    tokens = Tokens(scheme.seed, hashlib.blake2b(contents).digest())
    rng = np.random.default_rng([scheme.seed, int(tokens("order"), 16)])
    needs = {Item(case, rival): scheme.answers for case in cases for rival in sorted(folders.rivals)}
    questionnaires, sheets = {}, []
    for number, hand in enumerate(deal(needs, scheme.pairs, rng)):
        name = tokens("questionnaire", number)
        questions = _plan([Comparison(item.shape, item.view) for item in hand], name, tokens, rng)
        questionnaires[name] = questions
        sheets.append(Sheet(name, tuple(_shown(question, folders) for question in questions)))
    key = StudyKey(questionnaires, ours, scheme)
    BatchWriter(tokens, look, pair_template).write(batch_dir, sheets, key.record())
    return key


def _plan(hand: Sequence[Comparison], name: str, tokens: Tokens, rng: np.random.Generator) -> list[PairQuestion]:
    """The pairs in random order with random sides, then all again with sides swapped in another order."""
    left = {comparison: bool(rng.integers(2)) for comparison in hand}
    order = [hand[i] for i in rng.permutation(len(hand))] + [hand[i] for i in rng.permutation(len(hand))]
    questions = []
    for place, comparison in enumerate(order, 1):
        flipped = place > len(hand)
        sides = [Preference.OURS, Preference.RIVAL]
        if left[comparison] == flipped:
            sides.reverse()
        answers = {tokens("value", name, place, side): side for side in sides}
        answers |= {BOTH: Preference.BOTH, NONE: Preference.NONE}
        questions.append(PairQuestion(field_name(place, len(order)), comparison, flipped, answers))
    return questions


def _shown(question: PairQuestion, folders: StudyFolders) -> Shown:
    case, rival = question.comparison.case, question.comparison.rival
    sides = [(value, meaning) for value, meaning in question.answers.items() if value not in (BOTH, NONE)]
    drawings = tuple(folders.drawing(case, None if meaning is Preference.OURS else rival) for _, meaning in sides)
    return Shown(question.field, tuple(value for value, _ in sides), drawings, tuple(folders.render_paths(case)))
