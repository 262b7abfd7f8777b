"""Training of the ranker on plain numbers, and how much it counts beside its habit and the ranking module."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
import torch
from scipy.optimize import minimize
from torch import Tensor, nn

from ncmodel.arrays import read_arrays
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair
from ncmodel.drawing.settings import Levels
from ncmodel.errors import InputError, UsageError
from ncmodel.images import read_grey
from ncmodel.model.statistics import Statistics, statistics
from ncmodel.nets.losses import pair_accuracy
from ncmodel.nets.presets import Preset
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.parsing import parse_json
from ncmodel.progress import Progress, silent
from ncmodel.training.batches import load_pairs
from ncmodel.training.dataset import ViewImages
from ncmodel.training.loader import Examiner
from ncmodel.training.objectives import score_batch
from ncmodel.training.state import Measures
from ncmodel.types import Floats, Ints, Mask

HABIT_VIEWS = 512
"""Training views that the habit is the mean over, at most."""

SHRINKAGE = 1e-3
"""Ridge on the weights of `VOICES`: where few votes are at hand, none gets very large."""


class Numbers(Protocol):
    """The numbers of items' drawings."""

    def of(self, item: Item) -> Statistics:
        """The numbers of all drawings that settings give."""

    def settings(self, item: Item) -> Ints:
        """Which setting each drawing has that pairs speak of; -1 for what no setting gives."""


class DrawingNumbers:
    """The numbers of a data folder's drawings, counted when first asked for.

    Args:
        data: The data folder.
    """

    def __init__(self, data: DataFolder) -> None:
        self.data = data
        self._known: dict[Item, tuple[Statistics, Ints]] = {}

    def of(self, item: Item) -> Statistics:
        """The numbers of all drawings that settings give.

        Raises:
            InputError: A file of the view is missing, damaged, or of other candidates.
        """
        return self._read(item)[0]

    def settings(self, item: Item) -> Ints:
        """(8,) which setting each of the item's drawings has; -1 for edges, which no setting gives."""
        return self._read(item)[1]

    def _read(self, item: Item) -> tuple[Statistics, Ints]:
        if item not in self._known:
            folder, levels = self.data.view_folder(item), Levels()
            masks = _layer_masks(folder, levels)
            maps = [np.asarray(read_grey(path), dtype=np.float32) for path in self.data.map_paths(item)]
            found = statistics(masks, levels.members, maps[0], np.stack(maps[1:]))
            medoids = np.array(self.data.medoids(item))
            self._known[item] = found, np.where(medoids < len(levels.members), medoids, -1)
        return self._known[item]


def _layer_masks(folder: Path, levels: Levels) -> Mask:
    """(12, H, W) inked pixels of the layers, from the candidates that show one of them beside the contours."""
    path, expected = folder / "candidates.json", "the candidates of `ncontours dataset build` at its own levels"
    try:
        records = parse_json(path.read_text(encoding="utf-8"))
        found = [tuple(record["layers"]) for record in records]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(path, f"can't be read ({type(error).__name__})", expected) from error
    outline = levels.layers[0].name
    single = [tuple(dict.fromkeys((outline, layer.name))) for layer in levels.layers]
    missing = next((layers for layers in single if layers not in found), None)
    if missing or found[: len(levels.settings)] != [setting.layers for setting in levels.settings]:
        raise InputError(path, "other candidates", expected)
    archive, wrote = folder / "candidates.npz", "what `ncontours dataset build` wrote"
    ink, shape = read_arrays(archive, ("ink", "shape"), wrote)
    if shape.shape != (3,) or ink.dtype != np.uint8 or ink.shape != (len(found), shape[1], -(-shape[2] // 8)):
        raise InputError(archive, f"ink of shape {ink.shape} for {len(found)} candidates", wrote)
    chosen, width = ink[[found.index(layers) for layers in single]], int(shape[2])
    return np.unpackbits(chosen, axis=-1, count=width).astype(np.bool_)


@dataclass(frozen=True, eq=False)
class Votes:
    """Pairs that are looked at at once; there are no pictures to load.

    Attributes:
        chosen: (E, B) which pairs each of the E networks looks at.
    """

    chosen: Tensor

    def __len__(self) -> int:
        return 1

    def cut(self, count: int) -> "list[Votes]":
        """This: one example, of all networks."""
        return [self]

    def load(self, images: None) -> "Votes":
        """This."""
        return self

    def on(self, device: torch.device) -> Tensor:
        """The pairs."""
        return self.chosen.to(device)


class StatisticsObjective:
    """Logistic loss (Bradley and Terry's) on pairs of drawings, by their numbers alone."""

    name = "statistics"
    pretrained = False
    images = None

    def __init__(
        self,
        preset: Preset,
        ranker: StatisticsRanker,
        numbers: Numbers,
        pairs: Sequence[Pair],
        progress: Progress = silent,
    ) -> None:
        self.ranker, self.numbers = ranker, numbers
        self.networks: dict[str, nn.Module] = {"statistics": ranker}
        self.rates, self.averaging = preset.counting, preset.averaging
        items = sorted({pair.item for pair in pairs})
        with progress("counting ink", len(items)) as advance:
            for item in items:
                numbers.of(item)
                advance(item.name)
        self.training, self.held_out = (self._of_lines(pairs, split) for split in ("train", "validation"))
        if not self.training:
            raise UsageError("no pair of two line drawings to train on: all are of edges, expected some of lines")
        self._training, self._held_out = self._ends(self.training), self._ends(self.held_out)

    def prepare(self) -> None:
        """Measure the numbers' scales."""
        self.ranker.fit_scales(torch.cat(self._training))

    def steps(self, rng: np.random.Generator) -> Sequence[Votes]:
        """Steps of one pass; each network goes through the pairs in an order of its own."""
        torch.manual_seed(int(rng.integers(2**31)))  # for dropout
        count = len(self._training[0])
        order = torch.from_numpy(np.stack([rng.permutation(count) for _ in range(self.ranker.dims.networks)]))
        return [Votes(part) for part in torch.split(order, self.rates.batch, dim=1)]

    def loss(self, chosen: Tensor) -> Tensor:
        """The networks' mean loss, each on its own (E, B) pairs."""
        better, worse = (self.ranker.votes(numbers[chosen]) for numbers in self._training)
        return nn.functional.softplus(worse - better).mean()

    @torch.no_grad()
    def validate(self, examiner: Examiner) -> Measures:
        """Pair accuracy and mean logistic loss."""
        if not len(self._held_out[0]):
            return {}
        self.ranker.eval()
        better, worse = (self.ranker(numbers) for numbers in self._held_out)
        loss = float(nn.functional.softplus(worse - better).mean())
        return {"accuracy": pair_accuracy(better, worse), "logistic": loss}

    def loss_of(self, measures: Measures) -> float:
        """The logistic loss."""
        return measures["logistic"]

    def margins(self) -> Floats:
        """(P,) by how much the ranker likes the better drawings of `held_out` better."""
        with torch.no_grad():
            better, worse = (self.ranker(numbers).double().numpy() for numbers in self._held_out)
        return np.asarray(better - worse)

    def _of_lines(self, pairs: Sequence[Pair], split: str) -> list[Pair]:
        """The pairs of a split whose drawings are both given by settings."""
        mine = [pair for pair in pairs if pair.split == split]
        return [p for p in mine if (self.numbers.settings(p.item)[[p.better, p.worse]] >= 0).all()]

    def _ends(self, pairs: Sequence[Pair]) -> tuple[Tensor, Tensor]:
        """(P, F) numbers of the better drawings, and of the worse ones."""
        if not pairs:
            return (torch.zeros(0, self.ranker.dims.numbers),) * 2
        ends = [self.numbers.of(p.item).numbers(self.numbers.settings(p.item)[[p.better, p.worse]]) for p in pairs]
        both = torch.from_numpy(np.stack(ends, axis=1))
        return both[0], both[1]


@torch.no_grad()
def learn_habit(objective: StatisticsObjective) -> None:
    """Set the habit: what the ranker thinks of each setting on average over training views."""
    items = sorted({pair.item for pair in objective.training})
    chosen = items[:: -(-len(items) // HABIT_VIEWS)]
    scores = [objective.ranker(torch.from_numpy(objective.numbers.of(item).numbers())) for item in chosen]
    habit = torch.stack([score - score.mean() for score in scores]).mean(dim=0)
    objective.ranker.habit.copy_(habit)


def learn_mix(objective: StatisticsObjective, pictures: RankingModule | None, images: ViewImages | None) -> None:
    """Set how much each of `VOICES` counts: the logistic regression of held-out votes on what they say of pairs.

    Without held-out pairs, statistics alone count.

    Args:
        objective: Of the trained ranker, habit learnt.
        pictures: The ranking module, if there is one.
        images: What it sees, if there is.
    """
    pairs = objective.held_out
    if not pairs:
        return
    habit = objective.ranker.habit.double().numpy()
    settings = np.array([objective.numbers.settings(p.item)[[p.better, p.worse]] for p in pairs])
    seen = np.zeros(len(pairs))
    if pictures is not None and images is not None:
        seen = picture_margins(pictures, images, pairs)
    voices = np.column_stack([objective.margins(), habit[settings[:, 0]] - habit[settings[:, 1]], seen])
    objective.ranker.mix.copy_(torch.from_numpy(logistic_weights(voices)))


@torch.no_grad()
def picture_margins(ranker: RankingModule, images: ViewImages, pairs: Sequence[Pair]) -> Floats:
    """(P,) by how much a ranking module likes the better drawings better."""
    ranker.to("cpu").eval()
    margins = np.zeros(len(pairs))
    for item in sorted({pair.item for pair in pairs}):
        rows = [number for number, pair in enumerate(pairs) if pair.item == item]
        loaded = load_pairs(images, [pairs[row] for row in rows], ranker.dims.size).on(torch.device("cpu"))
        scores = score_batch(ranker, loaded.batch)
        margins[rows] = (scores[loaded.better] - scores[loaded.worse]).double().numpy()
    return margins


def logistic_weights(differences: Floats) -> Floats:
    """(K,) weights >= 0 under which differences of K scores give the odds that the first of two drawings is preferred.

    Args:
        differences: (P, K) of pairs whose first drawing was preferred.
    """

    def loss(weights: Floats) -> tuple[float, Floats]:
        margin = differences @ weights
        chance = 1.0 / (1.0 + np.exp(np.clip(margin, -500, 500)))
        value = np.logaddexp(0.0, -margin).mean() + SHRINKAGE * (weights**2).sum()
        return float(value), -(chance[:, None] * differences).mean(axis=0) + 2 * SHRINKAGE * weights

    start = np.full(differences.shape[1], 0.5)
    found = minimize(loss, start, jac=True, method="L-BFGS-B", bounds=[(0.0, None)] * len(start))
    weights: Floats = found.x
    return weights
