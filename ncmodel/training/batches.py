"""Training batches: which pairs or views go together in a step, and their pictures as tensors, varied at random.

Letters in shapes: N views, M drawings, P pairs, S side of the pictures in pixels.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair
from ncmodel.nets.presets import BACKGROUND, Variation
from ncmodel.training.dataset import ViewImages

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Batch:
    """Some views and some drawings of them.

    Attributes:
        maps: (N, K, S, S) depth and shaded maps, or others that networks read.
        drawings: (M, 1, S, S) ink.
        view: (M,) which of the N views each drawing is of.
    """

    maps: Tensor
    drawings: Tensor
    view: Tensor

    def to(self, device: torch.device) -> "Batch":
        """The same on another device."""
        return Batch(self.maps.to(device), self.drawings.to(device), self.view.to(device))


@dataclass(frozen=True, eq=False)
class PairBatch:
    """A batch and the ranking pairs among its drawings.

    Attributes:
        batch: The pictures. Each is there once, however many pairs it is in, and so is scored once.
        better: (P,) index of each pair's preferred drawing.
        worse: (P,) index of each pair's other drawing.
    """

    batch: Batch
    better: Tensor
    worse: Tensor

    def to(self, device: torch.device) -> "PairBatch":
        """The same on another device."""
        return PairBatch(self.batch.to(device), self.better.to(device), self.worse.to(device))


def load_batch(images: ViewImages, wanted: Sequence[tuple[Item, int]], size: int) -> Batch:
    """The given drawings, with the maps of the views that they are of, at one of the images' sizes."""
    items = list(dict.fromkeys(item for item, _ in wanted))
    place = {item: index for index, item in enumerate(items)}
    maps = np.stack([images.maps(item, size) for item in items])
    drawings = np.stack([images.drawing(item, index, size) for item, index in wanted])[:, None]
    view = torch.tensor([place[item] for item, _ in wanted])
    return Batch(torch.from_numpy(maps), torch.from_numpy(drawings), view)


def load_pairs(images: ViewImages, pairs: Sequence[Pair], size: int) -> PairBatch:
    """All drawings that some pairs speak of, at one of the images' sizes."""
    ends = [((pair.item, pair.better), (pair.item, pair.worse)) for pair in pairs]
    wanted = list(dict.fromkeys(end for both in ends for end in both))
    place = {drawing: index for index, drawing in enumerate(wanted)}
    better = torch.tensor([place[better] for better, _ in ends])
    worse = torch.tensor([place[worse] for _, worse in ends])
    return PairBatch(load_batch(images, wanted, size), better, worse)


def pair_chunks(pairs: Sequence[Pair], size: int, rng: np.random.Generator) -> list[list[Pair]]:
    """All pairs once, in random order of their items, in chunks of about `size` pairs.

    An item's pairs stay together, because they share their best drawing and their maps.
    """
    by_item: dict[Item, list[Pair]] = {}
    for pair in pairs:
        by_item.setdefault(pair.item, []).append(pair)
    ordered = [pair for item in shuffled(sorted(by_item), rng) for pair in by_item[item]]
    return even_chunks(ordered, size)


def even_chunks(values: Sequence[T], size: int) -> list[list[T]]:
    """Cut a list into chunks whose lengths differ by at most one, as near to `size` as that allows.

    No chunk is a small rest, whose batch statistics would be off.
    """
    count = max(1, round(len(values) / size))
    ends = [len(values) * index // count for index in range(count + 1)]
    return [list(values[begin:end]) for begin, end in itertools.pairwise(ends)]


def shuffled(values: Sequence[T], rng: np.random.Generator) -> list[T]:
    """The values in random order."""
    return [values[index] for index in rng.permutation(len(values))]


def vary(batch: Batch, variation: Variation, rng: np.random.Generator) -> Batch:
    """Show each view in another pose on the picture plane, its drawings with it.

    They stay as good or bad as they were: the light is at the camera, so that shading knows no up or left, and the
    frame has a margin to move in. With few shapes, this is what keeps a network from learning them by heart.
    """
    reach = int(variation.shift * batch.maps.shape[-1])
    maps, drawings = batch.maps.clone(), batch.drawings.clone()
    for index in range(len(maps)):
        turns, mirrored = int(rng.integers(4)), bool(rng.integers(2))
        down, right = (int(d) for d in rng.integers(-reach, reach + 1, 2))
        pose = _Pose(turns if variation.quarter_turns else 0, mirrored and variation.mirror, down, right)
        own = batch.view == index
        maps[index] = pose.of(maps[index], BACKGROUND)
        drawings[own] = pose.of(drawings[own], 0.0)
    return replace(batch, maps=maps, drawings=drawings)


@dataclass(frozen=True)
class _Pose:
    """Quarter turns, mirrored left to right or not, then moved by whole pixels."""

    turns: int
    mirror: bool
    down: int
    right: int

    def of(self, images: Tensor, background: float) -> Tensor:
        """Images (..., S, S) in this pose, `background` coming in where they have moved away."""
        turned = images.rot90(self.turns, (-2, -1))
        turned = turned.flip(-1) if self.mirror else turned
        return functional.pad(turned, (self.right, -self.right, self.down, -self.down), value=background)


def shrink(images: Tensor, size: int) -> Tensor:
    """(..., S, S) -> (..., size, size) by area averaging.

    Raises:
        ValueError: S isn't a multiple of size.
    """
    factor, rest = divmod(images.shape[-1], size)
    if rest:
        raise ValueError(f"pictures of side {images.shape[-1]} can't be averaged to side {size}")
    return functional.avg_pool2d(images, factor) if factor > 1 else images
