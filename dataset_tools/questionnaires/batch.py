"""Batches of 8-drawing questionnaires, planned over a data folder's items."""

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from dataset_tools.questionnaires.batch_folder import BatchWriter, Look, QuestionnaireStimuli, QuestionStimuli
from dataset_tools.questionnaires.counterbalancing import DrawingOrder, QuestionOrder, assign_items
from dataset_tools.questionnaires.identical_drawings import ALL_DIFFERENT, distinct, item_twins
from dataset_tools.questionnaires.pages import batch_template
from dataset_tools.questionnaires.questionnaire import Key, Question, Questionnaire, Scheme, Tokens, field_name
from dataset_tools.questionnaires.sentinels import Drawing, SentinelDrawings, SentinelPool
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import InputError, UsageError

MAX_STAND_INS = 40
"""Items whose drawings may stand in for artists' drawings of other shapes."""


@dataclass(frozen=True)
class PlannedQuestion:
    """A question with the pictures of its drawings, in the order shown."""

    question: Question
    drawings: tuple[Path, ...]


@dataclass(frozen=True)
class BatchReport:
    """What a batch holds, and what its maker should know."""

    questionnaires: int
    real: int
    sentinels: int
    items: int
    spare_votes: int
    repeated_shapes: int
    notes: tuple[str, ...]


class Planner:
    """Plans questionnaires over a data folder's items.

    Args:
        data: The data folder.
        scheme: Numbers of questions and votes.
        artists: Artists' drawings for sentinels (none where the scheme has no sentinels).
        needs: Item -> votes wanted.
        fill: Whether every questionnaire has exactly `scheme.real` questions, as `assign_items` explains.

    Raises:
        UsageError: Nothing is needed.
        InputError: A file of the data folder is missing, or sentinels can't be made.
    """

    def __init__(
        self, data: DataFolder, scheme: Scheme, artists: Sequence[Drawing], needs: Mapping[Item, int], fill: bool = True
    ) -> None:
        if not needs:
            raise UsageError("no item needs votes: there is nothing to ask")
        self.data, self.scheme, self.needs = data, scheme, needs
        self.tokens = Tokens(scheme.seed, _fingerprint(data, needs))
        rng = np.random.default_rng([scheme.seed, self.tokens.number("order")])
        self._blocks = assign_items(needs, scheme.real, rng, fill)
        self._places, self._positions = QuestionOrder(rng), DrawingOrder(rng)
        self._twins = {item: item_twins(data, item) for item in needs}
        self.pool: SentinelPool | None = None
        if scheme.sentinels:
            items = sorted(needs)
            some = [items[i] for i in rng.permutation(len(items))[:MAX_STAND_INS]]
            stand_ins = [
                Drawing(item, data.drawing_path(item, i)) for item in some for i in distinct(self._twins[item])
            ]
            self.pool = SentinelPool(artists, stand_ins, scheme.pool, rng)

    @property
    def sentinels(self) -> int:
        """Sentinels in a questionnaire: fewer than asked for where the pool is smaller."""
        return min(self.scheme.sentinels, len(self.pool)) if self.pool else 0

    @cached_property
    def plans(self) -> dict[str, list[PlannedQuestion]]:
        """Questionnaire -> its questions in order."""
        return {
            (identifier := self.tokens("questionnaire", number)): self._plan(identifier, block)
            for number, block in enumerate(self._blocks)
        }

    def _plan(self, identifier: str, block: Sequence[Item]) -> list[PlannedQuestion]:
        drafts = [self._draft(item, self.data.drawing_paths(item), False) for item in block]
        for sentinel in self.pool.draw(self.sentinels, block) if self.pool else ():
            drafts.append(self._draft(sentinel.item, [drawing.path for drawing in sentinel.drawings], True))
        ordered = self._places.order(drafts, [(draft.question.item, draft.question.sentinel) for draft in drafts])
        return [self._named(draft, identifier, place, len(ordered)) for place, draft in enumerate(ordered, 1)]

    def _draft(self, item: Item, drawings: Sequence[Path], sentinel: bool) -> PlannedQuestion:
        """A question whose options stand in order but don't have their opaque names yet."""
        order = self._positions.order((item, sentinel))
        twins = ALL_DIFFERENT if sentinel else self._twins[item]
        question = Question("", item, sentinel, {str(index): index for index in order}, twins)
        return PlannedQuestion(question, tuple(drawings[index] for index in order))

    def _named(self, draft: PlannedQuestion, identifier: str, place: int, total: int) -> PlannedQuestion:
        values = {self.tokens("value", identifier, place, i): i for i in draft.question.options.values()}
        return replace(draft, question=replace(draft.question, field=field_name(place, total), options=values))

    def questionnaires(self) -> dict[str, Questionnaire]:
        """The questionnaires, without their pictures."""
        return {name: Questionnaire(name, tuple(one.question for one in plan)) for name, plan in self.plans.items()}

    def stimuli(self) -> list[QuestionnaireStimuli]:
        """The questionnaires as shown; every question has as many renders as the item with the fewest."""
        items = {one.question.item for plan in self.plans.values() for one in plan if one.question.item}
        renders = {item: tuple(self.data.render_paths(item)) for item in items}
        count = min(len(paths) for paths in renders.values())
        return [
            QuestionnaireStimuli(
                name, tuple(_shown(one, renders[one.question.item][:count]) for one in plan if one.question.item)
            )
            for name, plan in self.plans.items()
        ]


def _shown(planned: PlannedQuestion, renders: tuple[Path, ...]) -> QuestionStimuli:
    return QuestionStimuli(planned.question.field, tuple(planned.question.options), planned.drawings, renders)


def make_batch(
    data_dir: Path,
    batch_dir: Path,
    needs: Mapping[Item, int],
    scheme: Scheme,
    look: Look,
    artists: SentinelDrawings,
    fill: bool = True,
) -> BatchReport:
    """Write a batch of questionnaires about the items of a data folder.

    Args:
        data_dir: The data folder.
        batch_dir: Where to write; doesn't exist yet or is empty.
        needs: Item -> votes wanted.
        scheme: Numbers of questions. Where all items are of one shape there are no sentinels.
        look: How pictures are delivered.
        artists: Where the sentinels' drawings come from.
        fill: Whether every questionnaire has exactly `scheme.real` items.

    Raises:
        UsageError: The batch folder holds something already, or no item needs votes.
        InputError: A file of the data folder or an artists' drawing can't be read.
    """
    data, notes = DataFolder(data_dir), []
    items = data.items()
    if scheme.sentinels and len({item.shape for item in items}) == 1:
        scheme = replace(scheme, sentinels=0)
        notes.append("no sentinels: they show drawings of other shapes, and there is one shape; nobody is unreliable")
    drawings = artists.drawings(items, scheme) if scheme.sentinels else ()
    settings = {"sentinels_from": artists.name} if scheme.sentinels else {}
    if scheme.sentinels and artists.note:
        notes.append(artists.note)
    report = build_batch(Planner(data, scheme, drawings, needs, fill), batch_dir, look, settings)
    return replace(report, notes=(*report.notes, *notes))


def build_batch(planner: Planner, batch_dir: Path, look: Look, settings: Mapping[str, object]) -> BatchReport:
    """Write a batch folder; it appears whole or not at all.

    Args:
        planner: What to ask.
        batch_dir: A folder that doesn't exist yet or is empty.
        look: How pictures are delivered.
        settings: What else the key should record.

    Raises:
        UsageError: The folder holds something.
        InputError: A picture can't be read.
    """
    questionnaires = planner.questionnaires()
    record = {
        "data": os.path.relpath(planner.data.root.resolve(), batch_dir.resolve()),
        "scheme": {**asdict(planner.scheme), "sentinels": planner.sentinels},
        **settings,
    }
    writer = BatchWriter(planner.tokens, look, batch_template)
    notes = writer.write(batch_dir, planner.stimuli(), Key(questionnaires, record).record())
    report = _report(planner, list(questionnaires.values()))
    return replace(report, notes=(*report.notes, *notes))


def _report(planner: Planner, questionnaires: Sequence[Questionnaire]) -> BatchReport:
    scheme, real = planner.scheme, sum(not question.sentinel for question in questionnaires[0].questions)
    asked = sum(1 for questionnaire in questionnaires for _ in questionnaire.items)
    shapes = [[q.item.shape for q in questionnaire.questions if q.item] for questionnaire in questionnaires]
    notes = []
    if real < scheme.real:
        notes.append(f"{real} items a questionnaire instead of {scheme.real}: there are {len(planner.needs)} items")
    if planner.sentinels < scheme.sentinels:
        notes.append(f"{planner.sentinels} sentinels a questionnaire instead of {scheme.sentinels}: the pool is small")
    elif planner.pool and len(planner.pool) < scheme.pool:
        notes.append(
            f"a pool of {len(planner.pool)} sentinels instead of {scheme.pool}: no more views have an artist's drawing"
        )
    return BatchReport(
        questionnaires=len(questionnaires),
        real=real,
        sentinels=planner.sentinels,
        items=len(planner.needs),
        spare_votes=asked - sum(planner.needs.values()),
        repeated_shapes=sum(len(names) - len(set(names)) for names in shapes),
        notes=tuple(notes),
    )


def _fingerprint(data: DataFolder, needs: Mapping[Item, int]) -> bytes:
    """What the opaque names are keyed with: the data set's contents, which participants don't have."""
    digest = hashlib.blake2b()
    for item, votes in sorted(needs.items()):
        digest.update(f"{item.name} {votes}".encode())
        for path in (data.camera_path(item), data.selection_path(item)):  # they say which drawings an item has
            try:
                digest.update(path.read_bytes())
            except OSError as error:
                raise InputError(path, f"can't be read ({error.strerror})", "a finished view") from error
    return digest.digest()
