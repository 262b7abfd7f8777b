"""Batches of questionnaires: planned from a data folder's items, written as template, task list, pictures and key."""

import base64
import csv
import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from dataset_tools.images import DRAWING_LEVELS, image_pool
from dataset_tools.items import drawing_path, item_fingerprint, render_paths
from dataset_tools.pages import batch_template
from dataset_tools.questionnaire import (
    IMAGES_NAME,
    KEY_NAME,
    N_OPTIONS,
    TASKS_NAME,
    TEMPLATE_NAME,
    Item,
    Key,
    Question,
    Questionnaire,
    Scheme,
    Tokens,
    field_name,
)
from dataset_tools.sentinels import Drawing, SentinelPool
from dataset_tools.spread import Places, Positions, deal
from ncmodel.errors import UsageError
from ncmodel.files import write_text
from ncmodel.pictures import read_grey

MAX_STAND_INS = 40
"""Items whose candidates may stand in for artists' drawings of other shapes."""


@dataclass(frozen=True)
class Planned:
    """A question with the pictures that it shows, in the order shown."""

    question: Question
    drawings: tuple[Path, ...]
    renders: tuple[Path, ...]


@dataclass(frozen=True)
class ImageNames:
    """File names of a question's pictures, in the order shown."""

    drawings: tuple[str, ...]
    renders: tuple[str, ...]


@dataclass(frozen=True)
class Look:
    """How a batch's pictures reach participants.

    Attributes:
        drawing_side: Longest side of a drawing, pixels.
        render_side: Longest side of a render, pixels.
        base_url: What stands before the pictures' names in `tasks.csv`.
        embed: Put the pictures into `tasks.csv` themselves, as data URIs.
    """

    drawing_side: int = 512
    render_side: int = 384
    base_url: str = f"{IMAGES_NAME}/"
    embed: bool = False

    def __post_init__(self) -> None:
        for name in ("drawing_side", "render_side"):
            if not 16 <= getattr(self, name) <= 4096:
                raise UsageError(f"--{name.replace('_', '-')} is {getattr(self, name)}, expected 16..4096 pixels")


@dataclass(frozen=True)
class Built:
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
        data_dir: The data folder.
        scheme: Numbers of questions and votes.
        artists: Artists' drawings for sentinels (none where the scheme has no sentinels).
        needs: Item -> votes wanted.
        fill: Whether every questionnaire has exactly `scheme.real` questions, as `spread.deal` explains.
    """

    def __init__(
        self, data_dir: Path, scheme: Scheme, artists: Sequence[Drawing], needs: Mapping[Item, int], fill: bool = True
    ) -> None:
        self.data_dir, self.scheme, self.needs = data_dir, scheme, needs
        self.tokens = Tokens(scheme.seed, _fingerprint(data_dir, needs))
        rng = np.random.default_rng([scheme.seed, int(self.tokens("order"), 16)])
        self._hands = deal(needs, scheme.real, rng, fill)
        self._places, self._positions = Places(rng), Positions(rng)
        self.pool: SentinelPool | None = None
        if scheme.sentinels:
            items = sorted(needs)
            some = [items[i] for i in rng.permutation(len(items))[:MAX_STAND_INS]]
            stand_ins = [Drawing(item, drawing_path(data_dir, item, i)) for item in some for i in range(N_OPTIONS)]
            self.pool = SentinelPool(artists, stand_ins, scheme.pool, rng)
        self._renders = {item: tuple(render_paths(data_dir, item)) for item in self._shown()}
        self.render_count = min((len(paths) for paths in self._renders.values()), default=0)

    def _shown(self) -> set[Item]:
        return {*self.needs, *(self.pool.items if self.pool else ())}

    def image_names(self, questionnaire: Questionnaire, question: Question) -> "ImageNames":
        """What a question's pictures are called: every showing of a picture has a name of its own."""

        def names(kind: str, count: int) -> tuple[str, ...]:
            place = (questionnaire.identifier, question.field)
            return tuple(self.tokens(kind, *place, i) + ".png" for i in range(1, count + 1))

        return ImageNames(names("drawing", N_OPTIONS), names("render", self.render_count))

    @property
    def sentinels(self) -> int:
        """Sentinels in a questionnaire: fewer than asked for where the pool is smaller."""
        return min(self.scheme.sentinels, len(self.pool)) if self.pool else 0

    def questionnaires(self) -> Iterator[tuple[Questionnaire, list[Planned]]]:
        """The questionnaires one by one, each with its pictures."""
        for number, hand in enumerate(self._hands):
            identifier = self.tokens("questionnaire", number)
            drafts = [self._real(item) for item in hand]
            if self.pool:
                drafts += [
                    self._draft(sentinel.item, [drawing.path for drawing in sentinel.drawings], True)
                    for sentinel in self.pool.draw(self.sentinels, hand)
                ]
            ordered = self._places.order(drafts, [(draft.question.item, draft.question.sentinel) for draft in drafts])
            planned = [self._named(draft, identifier, place, len(ordered)) for place, draft in enumerate(ordered, 1)]
            yield Questionnaire(identifier, tuple(one.question for one in planned)), planned

    def _real(self, item: Item) -> Planned:
        return self._draft(item, [drawing_path(self.data_dir, item, i) for i in range(N_OPTIONS)], False)

    def _draft(self, item: Item, drawings: Sequence[Path], sentinel: bool) -> Planned:
        """A question whose options stand in order but don't have their opaque names yet."""
        order = self._positions.order((item, sentinel))
        question = Question("", item, sentinel, {str(index): index for index in order})
        renders = self._renders[item][: self.render_count]
        return Planned(question, tuple(drawings[index] for index in order), renders)

    def _named(self, draft: Planned, identifier: str, place: int, total: int) -> Planned:
        values = {self.tokens("value", identifier, place, i): i for i in draft.question.options.values()}
        return replace(draft, question=replace(draft.question, field=field_name(place, total), options=values))


def build_batch(planner: Planner, batch_dir: Path, look: Look, settings: Mapping[str, object]) -> Built:
    """Write a batch folder; it appears whole or not at all.

    Args:
        planner: What to ask.
        batch_dir: A folder that doesn't exist yet or is empty.
        look: How pictures are delivered.
        settings: What else the key should record.

    Raises:
        UsageError: The folder holds something, or there is nothing to ask.
        InputError: A picture can't be read.
    """
    if batch_dir.exists() and any(batch_dir.iterdir()):
        raise UsageError(f"{batch_dir}: holds files already; a batch goes into a folder of its own")
    if not planner.needs:
        raise UsageError("no item needs votes: there is nothing to ask")
    batch_dir.parent.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{batch_dir.name}-", dir=batch_dir.parent))
    try:
        questionnaires = _write(planner, aside, look)
        record = {
            "data": os.path.relpath(planner.data_dir.resolve(), batch_dir.resolve()),
            "scheme": {**asdict(planner.scheme), "sentinels": planner.sentinels},
            **settings,
        }
        Key(questionnaires, record).save(aside / KEY_NAME)
        aside.chmod(0o755)
        os.replace(aside, batch_dir)
    except BaseException:
        shutil.rmtree(aside, ignore_errors=True)
        raise
    return _report(planner, list(questionnaires.values()))


def _write(planner: Planner, folder: Path, look: Look) -> dict[str, Questionnaire]:
    images = folder / IMAGES_NAME
    images.mkdir()
    sample = next(iter(planner.needs))
    drawing_size = _frame(drawing_path(planner.data_dir, sample, 0), look.drawing_side)
    render_size = _frame(render_paths(planner.data_dir, sample)[0], look.render_side)
    questionnaires: dict[str, Questionnaire] = {}
    with image_pool(images) as pool:
        for questionnaire, planned in planner.questionnaires():
            for one in planned:
                names = planner.image_names(questionnaire, one.question)
                for name, path in zip(names.drawings, one.drawings, strict=True):
                    pool.add(name, path, drawing_size, DRAWING_LEVELS)
                for name, path in zip(names.renders, one.renders, strict=True):
                    pool.add(name, path, render_size)
            questionnaires[questionnaire.identifier] = questionnaire
    with (folder / TASKS_NAME).open("w", encoding="utf-8", newline="") as file:
        writer: csv.DictWriter[str] | None = None
        for questionnaire in questionnaires.values():
            row = _task(planner, questionnaire, images, look)
            if writer is None:
                writer = csv.DictWriter(file, list(row), lineterminator="\n")
                writer.writeheader()
            writer.writerow(row)
    length = len(next(iter(questionnaires.values())).questions)
    text = batch_template(length, planner.render_count, drawing_size, render_size)
    write_text(folder / TEMPLATE_NAME, text)
    return questionnaires


def _task(planner: Planner, questionnaire: Questionnaire, images: Path, look: Look) -> dict[str, str]:
    """A row of `tasks.csv`: the identifier, where each picture is, then the value of each answer."""

    def address(name: str) -> str:
        if not look.embed:
            return look.base_url + name
        return "data:image/png;base64," + base64.b64encode((images / name).read_bytes()).decode("ascii")

    row, values = {"questionnaire": questionnaire.identifier}, {}
    for question in questionnaire.questions:
        names = planner.image_names(questionnaire, question)
        row |= {f"{question.field}_d{i}": address(name) for i, name in enumerate(names.drawings, 1)}
        row |= {f"{question.field}_r{i}": address(name) for i, name in enumerate(names.renders, 1)}
        values.update({f"{question.field}_v{i}": value for i, value in enumerate(question.options, 1)})
    return row | values


def _frame(path: Path, longest: int) -> tuple[int, int]:
    """(width, height) that a picture is shown at so that its longest side is `longest`."""
    height, width = read_grey(path).shape
    scale = longest / max(height, width)
    return max(1, round(width * scale)), max(1, round(height * scale))


def _report(planner: Planner, questionnaires: Sequence[Questionnaire]) -> Built:
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
    return Built(
        questionnaires=len(questionnaires),
        real=real,
        sentinels=planner.sentinels,
        items=len(planner.needs),
        spare_votes=asked - sum(planner.needs.values()),
        repeated_shapes=sum(len(names) - len(set(names)) for names in shapes),
        notes=tuple(notes),
    )


def _fingerprint(data_dir: Path, needs: Mapping[Item, int]) -> bytes:
    """What the opaque names are keyed with: the data set's contents, which participants don't have."""
    digest = hashlib.blake2b()
    for item, votes in sorted(needs.items()):
        digest.update(f"{item.name} {votes}".encode())
        digest.update(item_fingerprint(data_dir, item))
    return digest.digest()
