"""Sentinels: questions whose answer is known, which tell participants who look from those who click.

A sentinel shows renders of a shape, one artist's drawing of it and seven drawings of other shapes (appendix 5).
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from dataset_tools.questionnaires.counterbalancing import alternate_shapes
from dataset_tools.questionnaires.identical_drawings import distinct_pictures
from dataset_tools.questionnaires.questionnaire import Scheme
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.errors import InputError


@dataclass(frozen=True, order=True)
class Drawing:
    """A drawing of an item, in a picture file."""

    item: Item
    path: Path


@dataclass(frozen=True)
class Sentinel:
    """What a sentinel question shows: the artist's drawing first, then seven of other shapes."""

    item: Item
    drawings: tuple[Drawing, ...]


class SentinelDrawings(Protocol):
    """Where the artists' drawings that sentinels show come from."""

    @property
    def name(self) -> str:
        """Who drew, as the batch's key records it."""

    @property
    def note(self) -> str:
        """What the requester should know of them; "" for nothing."""

    def drawings(self, items: Sequence[Item], scheme: Scheme) -> Sequence[Drawing]:
        """Drawings of some of the items, enough for the scheme's pool where there are as many."""


@dataclass(frozen=True)
class ArtistsFolder:
    """Artists' drawings in a folder: SHAPE_VIEW.png, or any number of pictures in SHAPE_VIEW/."""

    folder: Path
    name: str = "artists"
    note: str = ""

    def drawings(self, items: Sequence[Item], scheme: Scheme) -> list[Drawing]:
        """All drawings of the items, without those that repeat another.

        Raises:
            InputError: There is none.
        """
        found = []
        for item in sorted(items):
            single = self.folder / f"{item.name}.png"
            several = sorted((self.folder / item.name).glob("*.png"))
            paths = ([single] if single.is_file() else []) + several
            found += [Drawing(item, path) for path in distinct_pictures(paths)]
        if not found:
            expected = "pictures named SHAPE_VIEW.png or SHAPE_VIEW/*.png"
            raise InputError(self.folder, "no drawing of any view", expected)
        return found


class SentinelPool:
    """The sentinels to draw from, and the drawings that stand beside the right ones.

    Nothing on a page may tell a sentinel, so within a questionnaire no drawing occurs twice while there are others:
    not as the answer of one sentinel and a stand-in in the next, nor as a stand-in and a drawing to vote on in a
    question about its item.

    Args:
        artists: Artists' drawings: the right answers, and the first choice for the others.
        stand_ins: Drawings of other items, which stand in where artists' drawings don't suffice.
        size: Sentinels in the pool, fewer where fewer views have an artist's drawing.
        rng: Source of the choices.

    Raises:
        InputError: All drawings are of one shape.
    """

    def __init__(
        self, artists: Sequence[Drawing], stand_ins: Sequence[Drawing], size: int, rng: np.random.Generator
    ) -> None:
        shapes = {drawing.item.shape for drawing in (*artists, *stand_ins)}
        if len(shapes) < 2:
            found = f"drawings of {len(shapes)} shape" + ("" if len(shapes) == 1 else "s")
            wanted = "two shapes or more, for sentinels show drawings of other shapes, or a scheme with no sentinels"
            raise InputError("sentinels", found, wanted)
        self._rng = rng
        self._answers = _one_an_item(artists, size, rng)
        self._artists, self._stand_ins = list(artists), list(stand_ins)

    def __len__(self) -> int:
        return len(self._answers)

    @property
    def items(self) -> list[Item]:
        """The views that sentinels are about."""
        return [answer.item for answer in self._answers]

    def draw(self, count: int, block: Sequence[Item]) -> list[Sentinel]:
        """Draw sentinels for a questionnaire about the items of `block`, of other shapes where there are any."""
        items, shapes = set(block), {item.shape for item in block}
        order = self._rng.permutation(len(self._answers))
        ranked = sorted(order, key=lambda i: (self._answers[i].item in items, self._answers[i].item.shape in shapes))
        answers = [self._answers[i] for i in ranked[:count]]
        used = Counter(answers)
        return [Sentinel(answer.item, (answer, *self._others(answer, items, used))) for answer in answers]

    def _others(self, answer: Drawing, block: set[Item], used: Counter[Drawing]) -> list[Drawing]:
        """Seven drawings of other shapes, each of another shape where there are as many."""
        shown: Counter[str] = Counter()
        chosen: list[Drawing] = []
        pool = [(d, rank) for rank, ds in enumerate((self._artists, self._stand_ins)) for d in ds]
        pool = [(d, rank) for d, rank in pool if d.item.shape != answer.item.shape]
        order = self._rng.permutation(len(pool))
        while len(chosen) < DRAWINGS - 1:
            best = min(
                order,
                key=lambda i: (
                    used[pool[i][0]] + (pool[i][1] == 1 and pool[i][0].item in block),
                    shown[pool[i][0].item.shape],
                    pool[i][1],
                ),
            )
            drawing = pool[best][0]
            chosen.append(drawing)
            used[drawing] += 1
            shown[drawing.item.shape] += 1
        return chosen


def _one_an_item(artists: Sequence[Drawing], size: int, rng: np.random.Generator) -> list[Drawing]:
    """One drawing each of up to `size` items, as many shapes among them as possible."""
    by_item: dict[Item, list[Drawing]] = {}
    for drawing in sorted(artists):
        by_item.setdefault(drawing.item, []).append(drawing)
    return [by_item[item][int(rng.integers(len(by_item[item])))] for item in alternate_shapes(by_item, rng)[:size]]
