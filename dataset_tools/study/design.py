"""The perceptual study (appendix 6): two methods' drawings of a shape side by side, every pair asked about twice.

A questionnaire has 15 pairs, then the same 15 with sides swapped in another order: who answers more than 7 of them
differently the second time is unreliable.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from dataset_tools.questionnaires.batch_folder import BatchWriter, Look, QuestionnaireStimuli, QuestionStimuli
from dataset_tools.questionnaires.counterbalancing import assign_items
from dataset_tools.questionnaires.pages import pair_template
from dataset_tools.questionnaires.questionnaire import KEY_NAME, NONE, Tokens, field_name, read_key
from dataset_tools.study.stimuli import Comparison, StudyFolders
from ncmodel.data.item import Item
from ncmodel.errors import ArgumentError, InputError

BOTH = "both"
"""The answer "both drawings convey the shape equally well"."""


class Preference(StrEnum):
    """What an answer means."""

    OURS = "ours"
    RIVAL = "rival"
    BOTH = "both"
    NONE = "none"


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
                raise ArgumentError(name, str(getattr(self, name)), f"{least} or more")


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
    """All questionnaires of a study: identifier -> questions; and how it was made.

    Attributes:
        questionnaires: By identifier, in the order of `tasks.csv`.
        ours: What our method is called.
        scheme: Numbers of questions.
        folders: Where the pictures are, seen from the batch's folder; None where a key doesn't tell.
    """

    questionnaires: Mapping[str, Sequence[PairQuestion]]
    ours: str
    scheme: StudyScheme
    folders: StudyFolders | None = None

    @property
    def comparisons(self) -> list[Comparison]:
        """All that is compared, sorted."""
        return sorted({question.comparison for asked in self.questionnaires.values() for question in asked})

    @property
    def fewest_pairs(self) -> int:
        """Comparisons in the shortest questionnaire."""
        return min(len(questions) for questions in self.questionnaires.values()) // 2

    def record(self) -> dict[str, Any]:
        """What `key.json` holds; `shape` and `view` of a question are its case and rival."""
        return {
            "study": "pairs",
            "ours": self.ours,
            "scheme": asdict(self.scheme),
            **({"folders": self.folders.record()} if self.folders else {}),
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
                name: _checked(name, [_from_record(question) for question in entry["questions"]])
                for name, entry in record["questionnaires"].items()
            }
            folders = StudyFolders.from_record(record["folders"]) if "folders" in record else None
            return StudyKey(questionnaires, str(record["ours"]), StudyScheme(**record["scheme"]), folders)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
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
    answers = {str(value): Preference(meaning) for value, meaning in record["options"].items()}
    if sorted(answers.values()) != [Preference.OURS, Preference.RIVAL]:
        raise ValueError(f"question {record['field']} has the options {list(answers.values())}")
    answers |= {BOTH: Preference.BOTH, NONE: Preference.NONE}
    comparison = Comparison(str(record["shape"]), str(record["view"]))
    return PairQuestion(str(record["field"]), comparison, bool(record["flipped"]), answers)


def _checked(name: str, questions: list[PairQuestion]) -> list[PairQuestion]:
    """The questions of a questionnaire, if each comparison is asked about once and once more with sides swapped."""
    asked, again = (sorted(q.comparison for q in questions if q.flipped is flipped) for flipped in (False, True))
    if asked != again or len(set(asked)) != len(asked) or len({q.field for q in questions}) != len(questions):
        raise ValueError(f"questionnaire {name} doesn't ask about every comparison twice, in fields of their own")
    return questions


def build_study(
    folders: StudyFolders,
    ours: str,
    scheme: StudyScheme,
    look: Look,
    batch_dir: Path,
    needs: Mapping[Comparison, int] | None = None,
) -> tuple[StudyKey, list[str]]:
    """Write the batch folder of a study.

    Args:
        folders: Where the pictures are.
        ours: What our method is called.
        scheme: Numbers of questions.
        look: How pictures are delivered.
        batch_dir: A folder that doesn't exist yet or is empty.
        needs: Comparison -> answers wanted; by default all comparisons, with the scheme's number. Others fill the
            questionnaires up, for who answers few pairs can't be told from who clicks.

    Returns:
        The study's key, and what the requester should know.

    Raises:
        UsageError: The folder holds something, or there are no rivals.
        InputError: A picture is missing or can't be read.
    """
    comparisons = folders.comparisons()
    wanted = dict.fromkeys(comparisons, scheme.answers) if needs is None else needs
    unknown = sorted(set(wanted) - set(comparisons))
    if unknown:
        found = f"no drawing of {unknown[0].case} by {unknown[0].rival}"
        raise InputError(folders.ours, found, "drawings of everything that is to be asked about")
    tokens = Tokens(scheme.seed, folders.fingerprint(wanted))
    rng = np.random.default_rng([scheme.seed, tokens.number("order")])
    items = {Item(one.case, one.rival): wanted.get(one, 0) for one in comparisons}
    questionnaires, stimuli = {}, []
    for number, block in enumerate(assign_items(items, scheme.pairs, rng, others=items)):
        name = tokens("questionnaire", number)
        questions = _plan([Comparison(item.shape, item.view) for item in block], name, tokens, rng)
        questionnaires[name] = questions
        stimuli.append(QuestionnaireStimuli(name, tuple(_shown(question, folders) for question in questions)))
    key = StudyKey(questionnaires, ours, scheme, folders.seen_from(batch_dir))
    notes = BatchWriter(tokens, look, pair_template).write(batch_dir, stimuli, key.record())
    same = sum(folders.are_same(comparison) for comparison in comparisons)
    if same:
        notes.append(f"{same} of {len(comparisons)} comparisons show the same picture twice: only chance decides them")
    if key.fewest_pairs <= scheme.most_inconsistent:
        notes.append(
            f"{key.fewest_pairs} comparisons in a questionnaire, and {scheme.most_inconsistent} inconsistent answers "
            "are let pass: nobody is unreliable, whatever they answer"
        )
    return key, notes


def _plan(block: Sequence[Comparison], name: str, tokens: Tokens, rng: np.random.Generator) -> list[PairQuestion]:
    """The pairs in random order with random sides, then all again with sides swapped in another order."""
    left = {comparison: bool(rng.integers(2)) for comparison in block}
    order = [block[i] for i in rng.permutation(len(block))] + [block[i] for i in rng.permutation(len(block))]
    questions = []
    for place, comparison in enumerate(order, 1):
        flipped = place > len(block)
        sides = [Preference.OURS, Preference.RIVAL]
        if left[comparison] == flipped:
            sides.reverse()
        answers = {tokens("value", name, place, side): side for side in sides}
        answers |= {BOTH: Preference.BOTH, NONE: Preference.NONE}
        questions.append(PairQuestion(field_name(place, len(order)), comparison, flipped, answers))
    return questions


def _shown(question: PairQuestion, folders: StudyFolders) -> QuestionStimuli:
    case, rival = question.comparison.case, question.comparison.rival
    sides = [(value, meaning) for value, meaning in question.answers.items() if value not in (BOTH, NONE)]
    drawings = tuple(folders.drawing(case, None if meaning is Preference.OURS else rival) for _, meaning in sides)
    return QuestionStimuli(
        question.field, tuple(value for value, _ in sides), drawings, tuple(folders.render_paths(case))
    )
