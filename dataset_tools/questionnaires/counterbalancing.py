"""Counterbalancing: which items a questionnaire asks about, in what order, and how its drawings are ordered."""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from typing import TypeVar

import numpy as np
from scipy.optimize import linear_sum_assignment

from ncmodel.data.item import DRAWINGS, Item

T = TypeVar("T")


def assign_items(
    needs: Mapping[Item, int], size: int, rng: np.random.Generator, fill: bool = True, others: Collection[Item] = ()
) -> list[list[Item]]:
    """Assign items to the fewest blocks, one a questionnaire, that give each item the votes it needs.

    All votes are laid in a row, those of a shape side by side, and go to the blocks in turn. So no block holds an item
    twice, and none holds a shape twice unless the shape needs more votes than there are questionnaires; then its
    questions are spread evenly, which is the best that can be done.

    Args:
        needs: Item -> votes (items that need none are left out).
        size: Questions in a questionnaire; fewer where there are fewer items.
        rng: Source of the order.
        fill: Give every questionnaire exactly `size` items, with spare votes for some items; otherwise questionnaires
            are only as long as the votes need (at most one spare vote each, so that all are of one length).
        others: Items that need no votes and may fill questionnaires up.
    """
    short = {item: votes for item, votes in needs.items() if votes > 0}
    if not short:
        return []
    to_fill = [*short, *(item for item in others if item not in short)]
    total, size = sum(short.values()), min(size, len(to_fill))
    count = max(-(-total // size), max(short.values()))
    length = size if fill else -(-total // count)
    blocks: list[list[Item]] = [[] for _ in range(count)]
    row = [item for item in _by_shape(short, rng) for _ in range(short[item])]
    for place, item in enumerate(row):
        blocks[place % count].append(item)
    _fill(blocks, length, to_fill, rng)
    return [blocks[i] for i in rng.permutation(count)]


def _by_shape(items: Mapping[Item, int], rng: np.random.Generator) -> list[Item]:
    """The items in random order, those of one shape side by side."""
    shapes = sorted({item.shape for item in items})
    rank = dict(zip(shapes, rng.permutation(len(shapes)), strict=True))
    return sorted(items, key=lambda item: (rank[item.shape], item))


def _fill(blocks: list[list[Item]], length: int, items: list[Item], rng: np.random.Generator) -> None:
    """Fill short blocks up in place, with items that got the fewest spare votes and shapes that aren't in the block."""
    spare: Counter[Item] = Counter()
    order = {items[i]: rank for rank, i in enumerate(rng.permutation(len(items)))}
    for block in blocks:
        while len(block) < length:
            held, shapes = set(block), {item.shape for item in block}
            free = (item for item in items if item not in held)
            item = min(free, key=lambda item: (item.shape in shapes, spare[item], order[item]))
            spare[item] += 1
            block.append(item)


def alternate_shapes(items: Collection[Item], rng: np.random.Generator) -> list[Item]:
    """The items in a random order in which shapes take turns: its beginning holds as many shapes as possible."""
    ordered = sorted(items)
    seen: Counter[str] = Counter()
    turn: dict[Item, int] = {}
    for i in rng.permutation(len(ordered)):
        turn[ordered[i]] = seen[ordered[i].shape]
        seen[ordered[i].shape] += 1
    return sorted(turn, key=lambda item: turn[item])


class QuestionOrder:
    """Puts the questions of each questionnaire in an order in which every item stands at places it hasn't stood at.

    Real questions and sentinels are treated alike, so that a place says nothing.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._taken: dict[object, list[int]] = {}

    def order(self, questions: Sequence[T], identities: Sequence[object]) -> list[T]:
        """The questions in order; `identities[i]` says what question i is about."""
        n = len(questions)
        cost = 0.01 * self._rng.random((n, n))
        for row, identity in enumerate(identities):
            for place in self._taken.get(identity, []):
                # Places near one that the item has had cost up to 1, those a third of the questionnaire away nothing.
                cost[row] += np.maximum(0.0, 1.0 - np.abs(np.arange(n) - place) / max(n / 3, 1.0))
        rows, places = linear_sum_assignment(cost)
        ordered: list[T] = list(questions)
        for row, place in zip(rows, places, strict=True):
            ordered[place] = questions[row]
            self._taken.setdefault(identities[row], []).append(int(place))
        return ordered


class DrawingOrder:
    """Orders the 8 drawings of a question so that each drawing of an item meets all positions about equally often.

    The first time an item is asked about, its order is random; each further time the row is turned by an odd step, so
    that 8 askings put every drawing at every position once.
    """

    STEP = 3
    """Odd, so that it runs through all 8 turns; not 1, so that neighbours in time don't look alike."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._asked: dict[object, tuple[list[int], int]] = {}

    def order(self, identity: object) -> list[int]:
        """Drawings 0..7 in the order to show."""
        row, times = self._asked.get(identity) or (self._rng.permutation(DRAWINGS).tolist(), 0)
        if times == DRAWINGS:
            row, times = self._rng.permutation(DRAWINGS).tolist(), 0
        self._asked[identity] = (row, times + 1)
        turn = (self.STEP * times) % DRAWINGS
        return row[turn:] + row[:turn]
