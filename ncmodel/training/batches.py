"""Training batches: which pairs or views are looked at together, how they are shown, and their pictures as tensors.

Letters in shapes: N views, M drawings, P pairs, S side of the pictures in pixels.
"""

import itertools
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair
from ncmodel.nets.presets import Variation
from ncmodel.training.dataset import WHITE, Levels, ViewImages

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


@dataclass(frozen=True, eq=False)
class PairBatch:
    """A batch and the ranking pairs among its drawings.

    Attributes:
        batch: The pictures. Each is there once, however many pairs it is in, and so is scored once.
        better: (P,) index of each pair's preferred drawing.
        worse: (P,) index of each pair's other drawing.
        emphasis: How much each drawing counts that is better in some pair, in the order of their indices, where a loss
            is a mean over these drawings: 1 in a whole step. A part of a step may have some of a drawing's pairs only.
    """

    batch: Batch
    better: Tensor
    worse: Tensor
    emphasis: Tensor


@dataclass(frozen=True, eq=False)
class Stored:
    """A `Batch` as it is kept and handed between processes: half as large.

    Attributes:
        maps: (N, K, S, S) levels in 0..`WHITE`.
        drawings: (M, 1, S, S) likewise, ink dark.
        view: (M,) which of the N views each drawing is of.
    """

    maps: Tensor
    drawings: Tensor
    view: Tensor

    def on(self, device: torch.device) -> Batch:
        """The batch, on a device."""
        maps, drawings = (levels.to(device).to(torch.float32) / WHITE for levels in (self.maps, self.drawings))
        return Batch(maps, 1.0 - drawings, self.view.to(device))


@dataclass(frozen=True, eq=False)
class StoredPairs:
    """A `PairBatch` as it is kept and handed between processes."""

    batch: Stored
    better: Tensor
    worse: Tensor
    emphasis: Tensor

    def on(self, device: torch.device) -> PairBatch:
        """The batch, on a device."""
        indices = (values.to(device) for values in (self.better, self.worse, self.emphasis))
        return PairBatch(self.batch.on(device), *indices)


@dataclass(frozen=True)
class Pose:
    """Quarter turns, mirrored left to right or not, then moved by whole pixels."""

    turns: int
    mirror: bool
    down: int
    right: int

    def of(self, images: Levels) -> Levels:
        """Images (..., S, S) in this pose, white coming in where they have moved away."""
        turned = np.rot90(images, self.turns, (-2, -1))
        turned = np.flip(turned, -1) if self.mirror else turned
        moved = np.full_like(images, WHITE)
        (to_row, from_row), (to_column, from_column) = _shifted(self.down), _shifted(self.right)
        moved[..., to_row, to_column] = turned[..., from_row, from_column]
        return moved


def _shifted(by: int) -> tuple[slice, slice]:
    """Where to, and where from, when a row moves."""
    return slice(max(by, 0), min(by, 0) or None), slice(max(-by, 0), min(-by, 0) or None)


Poses = Mapping[Item, Pose]
"""How views are shown; those that aren't in it as they are."""


def draw_poses(items: Sequence[Item], variation: Variation, size: int, rng: np.random.Generator) -> Poses:
    """Show each view in another pose on the picture plane, its drawings with it.

    They stay as good or bad as they were: the light is at the camera, so that shading knows no up or left, and the
    frame has a margin to move in. With few shapes, this is what keeps a network from learning them by heart.
    """
    reach = int(variation.shift * size)
    poses = {}
    for item in items:
        turns, mirrored = int(rng.integers(4)), bool(rng.integers(2))
        down, right = (int(d) for d in rng.integers(-reach, reach + 1, 2))
        poses[item] = Pose(turns if variation.quarter_turns else 0, mirrored and variation.mirror, down, right)
    return poses


def load_batch(images: ViewImages, wanted: Sequence[tuple[Item, int]], size: int, poses: Poses | None = None) -> Stored:
    """The given drawings, with the maps of the views that they are of, at one of the images' sizes."""
    items = items_of(wanted)
    place = {item: index for index, item in enumerate(items)}
    poses = poses or {}

    def posed(item: Item, levels: Levels) -> Levels:
        return poses[item].of(levels) if item in poses else levels

    maps = np.stack([posed(item, images.map_levels(item, size)) for item in items])
    drawings = np.stack([posed(item, images.drawing_levels(item, index, size)) for item, index in wanted])[:, None]
    view = torch.tensor([place[item] for item, _ in wanted])
    return Stored(torch.from_numpy(maps), torch.from_numpy(drawings), view)


def load_pairs(
    images: ViewImages, pairs: Sequence[Pair], size: int, poses: Poses | None = None, step: Sequence[Pair] | None = None
) -> StoredPairs:
    """All drawings that some pairs speak of, at one of the images' sizes.

    Args:
        images: Where they are.
        pairs: The pairs.
        size: Side of the pictures, pixels.
        poses: How views are shown.
        step: All pairs of the training step that these are a part of; these, by default.
    """
    ends = [((pair.item, pair.better), (pair.item, pair.worse)) for pair in pairs]
    wanted = list(dict.fromkeys(end for both in ends for end in both))
    place = {drawing: index for index, drawing in enumerate(wanted)}
    better = torch.tensor([place[better] for better, _ in ends])
    worse = torch.tensor([place[worse] for _, worse in ends])
    emphasis = torch.tensor(_emphasis(wanted, pairs, step or pairs))
    return StoredPairs(load_batch(images, wanted, size, poses), better, worse, emphasis)


def _emphasis(drawings: Sequence[tuple[Item, int]], pairs: Sequence[Pair], step: Sequence[Pair]) -> list[float]:
    """What makes means over better drawings, of parts that are weighted as their pairs are many, the step's mean."""
    mine, whole = (Counter((pair.item, pair.better) for pair in some) for some in (pairs, step))
    one = (len(mine) / len(whole)) / (len(pairs) / len(step))
    return [one * mine[drawing] / whole[drawing] for drawing in drawings if drawing in mine]


@dataclass(frozen=True)
class PairPart:
    """Ranking pairs that are looked at at once: those of a step, or some of them.

    Attributes:
        pairs: They.
        size: Side of the pictures, pixels.
        poses: How views are shown.
        step: All pairs of the step; None if these are all.
    """

    pairs: tuple[Pair, ...]
    size: int
    poses: Poses
    step: tuple[Pair, ...] | None = None

    def __len__(self) -> int:
        return len(self.pairs)

    def cut(self, count: int) -> "list[PairPart]":
        """Up to `count` parts, of nearly the same length."""
        whole = self.step or self.pairs
        return [PairPart(tuple(part), self.size, self.poses, whole) for part in cut(self.pairs, count)]

    def load(self, images: ViewImages) -> StoredPairs:
        """The pictures."""
        return load_pairs(images, self.pairs, self.size, self.poses, self.step)


@dataclass(frozen=True)
class ViewPart:
    """Views that are looked at at once, each with one of its drawings.

    Attributes:
        views: They.
        size: Side of the pictures, pixels.
        poses: How views are shown.
    """

    views: tuple[tuple[Item, int], ...]
    size: int
    poses: Poses

    def __len__(self) -> int:
        return len(self.views)

    def cut(self, count: int) -> "list[ViewPart]":
        """Up to `count` parts, of nearly the same length."""
        return [ViewPart(tuple(part), self.size, self.poses) for part in cut(self.views, count)]

    def load(self, images: ViewImages) -> Stored:
        """The pictures."""
        return load_batch(images, self.views, self.size, self.poses)


def items_of(wanted: Sequence[tuple[Item, int]]) -> list[Item]:
    """The views that drawings are of, each once."""
    return list(dict.fromkeys(item for item, _ in wanted))


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
    return cut(values, max(1, round(len(values) / size)))


def cut(values: Sequence[T], count: int) -> list[list[T]]:
    """Cut a list into `count` pieces whose lengths differ by at most one; a shorter list into single values."""
    count = max(1, min(count, len(values)))
    ends = [len(values) * index // count for index in range(count + 1)]
    return [list(values[begin:end]) for begin, end in itertools.pairwise(ends)]


def shuffled(values: Sequence[T], rng: np.random.Generator) -> list[T]:
    """The values in random order."""
    return [values[index] for index in rng.permutation(len(values))]


def shrink(images: Tensor, size: int) -> Tensor:
    """(..., S, S) -> (..., size, size) by area averaging.

    Raises:
        ValueError: S isn't a multiple of size.
    """
    factor, rest = divmod(images.shape[-1], size)
    if rest:
        raise ValueError(f"pictures of side {images.shape[-1]} can't be averaged to side {size}")
    return functional.avg_pool2d(images, factor) if factor > 1 else images
