"""Views of made-up ink: the numbers of their 256 drawings without any shape, and how they are trained on in moments."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, Split
from ncmodel.drawing.settings import Levels
from ncmodel.model.statistics import Statistics, statistics
from ncmodel.nets.presets import Rates, StatisticsDims
from ncmodel.types import Floats, Image, Ints, Mask
from tests.helpers.micro_training import MICRO

SIDE = 20

COUNTING = replace(
    MICRO,
    statistics=StatisticsDims(width=8, networks=2, dropout=0.1),
    counting=Rates(1e-2, batch=32, epochs=6),
)
"""A preset whose last stage takes moments too."""


def made_ink(rng: np.random.Generator) -> tuple[Mask, Image, Image]:
    """(12, H, W) layers of very different amounts of ink, depth of a square, and shaded maps."""
    shares = rng.uniform(0.02, 0.2, 12)
    masks = rng.random((12, SIDE, SIDE)) < shares[:, None, None]
    depth = np.ones((SIDE, SIDE), dtype=np.float32)
    depth[3:-3, 3:-3] = 0.5
    return masks, depth, rng.random((6, SIDE, SIDE)).astype(np.float32)


def counted(rng: np.random.Generator) -> Statistics:
    """The numbers of the drawings of one made-up view."""
    masks, depth, shaded = made_ink(rng)
    return statistics(masks, Levels().members, depth, shaded)


class MadeNumbers:
    """The numbers of some made-up views, whose drawings are all 256.

    Args:
        count: How many views.
    """

    def __init__(self, count: int) -> None:
        self.known = {Item("s", str(number)): counted(np.random.default_rng(number)) for number in range(count)}

    def of(self, item: Item) -> Statistics:
        """The numbers of all drawings of an item."""
        return self.known[item]

    def settings(self, item: Item) -> Ints:
        """(256,) which setting each of its drawings has."""
        return np.arange(len(self.known[item].drawings))


def ink_pairs(numbers: MadeNumbers, held_out: Sequence[str], each: int = 60) -> list[Pair]:
    """Pairs of drawings at random, of which the one with more ink is better."""
    pairs = []
    for item, found in numbers.known.items():
        split: Split = "validation" if item.view in held_out else "train"
        amount: Floats = found.drawings[:, 0]
        for first, second in np.random.default_rng(int(item.view)).integers(256, size=(each, 2)):
            better, worse = (first, second) if amount[first] > amount[second] else (second, first)
            if amount[better] > amount[worse]:
                pairs.append(Pair(item, int(better), int(worse), split))
    return pairs
