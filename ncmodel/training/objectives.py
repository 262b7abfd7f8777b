"""What the three training stages minimise, and how their networks are judged on held-out views (section 5)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np
import torch
from torch import Tensor, nn

from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, best_drawings
from ncmodel.nets.devices import device_of
from ncmodel.nets.losses import cross_entropy, pair_accuracy, ranking_loss
from ncmodel.nets.presets import Preset, Rates
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from ncmodel.training.batches import (
    Batch,
    PairBatch,
    even_chunks,
    load_batch,
    load_pairs,
    pair_chunks,
    shrink,
    shuffled,
    vary,
)
from ncmodel.training.dataset import ViewImages

Measures = dict[str, float]

SCALE_VIEWS = 16
"""Views that the input scales are measured on."""


class Objective(Protocol):
    """One training stage: what it trains, its steps, its judgement."""

    name: str
    networks: dict[str, nn.Module]
    rates: Rates
    averaging: float
    pretrained: bool

    def prepare(self) -> None:
        """Set what the networks know before their first step: input scales and the like."""

    def steps(self, rng: np.random.Generator) -> Sequence[Callable[[], Tensor]]:
        """The steps of one pass over the training data, each giving its loss when called."""

    def validate(self) -> Measures:
        """Measures on the held-out items; empty when there are none."""

    def loss_of(self, measures: Measures) -> float:
        """What the best pass is chosen by: the held-out loss. It is less noisy than accuracy on few items."""


class RankerObjective:
    """Hinge ranking loss on pairs of drawings."""

    name = "ranker"
    pretrained = False

    def __init__(self, preset: Preset, ranker: RankingModule, images: ViewImages, pairs: Sequence[Pair]) -> None:
        self.preset, self.ranker, self.images = preset, ranker, images
        self.training = [pair for pair in pairs if pair.split == "train"]
        self.held_out = [pair for pair in pairs if pair.split == "validation"]
        self.networks: dict[str, nn.Module] = {"ranker": ranker}
        self.rates, self.averaging = preset.ranker, preset.averaging

    def prepare(self) -> None:
        """Measure the input scales."""
        items = set(sorted({pair.item for pair in self.training})[:SCALE_VIEWS])
        ends = {(pair.item, end) for pair in self.training for end in (pair.better, pair.worse) if pair.item in items}
        batch = load_batch(self.images, sorted(ends), self.ranker.dims.size).to(device_of(self.ranker))
        self.ranker.standardise_maps.fit(self.ranker.pick(batch.maps))
        self.ranker.standardise_drawing.fit(batch.drawings)

    def steps(self, rng: np.random.Generator) -> Sequence[Callable[[], Tensor]]:
        """One step a chunk of pairs."""
        chunks = pair_chunks(self.training, self.rates.batch, rng)
        return [partial(self._loss, chunk, rng) for chunk in chunks]

    def _loss(self, chunk: Sequence[Pair], rng: np.random.Generator) -> Tensor:
        pairs = load_pairs(self.images, chunk, self.ranker.dims.size).to(device_of(self.ranker))
        scores = score_batch(self.ranker, vary(pairs.batch, self.preset.variation, rng))
        return ranking_loss(scores[pairs.better], scores[pairs.worse])

    def validate(self) -> Measures:
        """Pair accuracy and mean hinge loss."""
        return judge_pairs(self.ranker, self.images, self.held_out, self.rates.batch)

    def loss_of(self, measures: Measures) -> float:
        """The hinge loss."""
        return measures["hinge"]


class TranslatorObjective:
    """Cross-entropy between the predicted line probability and each view's best drawing."""

    name = "translator"
    pretrained = False

    def __init__(
        self, preset: Preset, translator: TranslationBranch, images: ViewImages, pairs: Sequence[Pair]
    ) -> None:
        self.preset, self.translator, self.images = preset, translator, images
        best = best_drawings(pairs)
        held_out = {pair.item for pair in pairs if pair.split == "validation"}
        self.training = [(item, best[item]) for item in sorted(best) if item not in held_out]
        self.held_out = [(item, best[item]) for item in sorted(best) if item in held_out]
        self.networks: dict[str, nn.Module] = {"translator": translator}
        self.rates, self.averaging = preset.translator, preset.averaging

    def prepare(self) -> None:
        """Measure the input scales and the share of ink."""
        batch = load_batch(self.images, self.training[:SCALE_VIEWS], self.translator.dims.size)
        batch = batch.to(device_of(self.translator))
        self.translator.standardise.fit(self.translator.pick(batch.maps))
        self.translator.expect_ink(float(batch.drawings.mean()))

    def steps(self, rng: np.random.Generator) -> Sequence[Callable[[], Tensor]]:
        """One step a few views."""
        chunks = even_chunks(shuffled(self.training, rng), self.rates.batch)
        return [partial(self._loss, chunk, rng) for chunk in chunks]

    def _loss(self, chunk: Sequence[tuple[Item, int]], rng: np.random.Generator) -> Tensor:
        batch = load_batch(self.images, chunk, self.translator.dims.size).to(device_of(self.translator))
        batch = vary(batch, self.preset.variation, rng)
        return cross_entropy(self.translator.logits(batch.maps), batch.drawings)

    def validate(self) -> Measures:
        """Mean cross-entropy."""
        return judge_views(self.translator, self.images, self.held_out)

    def loss_of(self, measures: Measures) -> float:
        """The cross-entropy."""
        return measures["cross_entropy"]


class FinetuneObjective:
    """Both networks end to end by the ranking loss, through the merged drawing max(I_best, I_L)."""

    name = "finetune"
    pretrained = True

    def __init__(
        self,
        preset: Preset,
        ranker: RankingModule,
        translator: TranslationBranch,
        images: ViewImages,
        pairs: Sequence[Pair],
    ) -> None:
        self.preset, self.rates, self.averaging = preset, preset.finetune, preset.averaging
        self.ranking = RankerObjective(preset, ranker, images, pairs)
        self.translation = TranslatorObjective(preset, translator, images, pairs)
        self.networks: dict[str, nn.Module] = {"ranker": ranker, "translator": translator}

    def prepare(self) -> None:
        """Nothing: both networks come trained."""

    def steps(self, rng: np.random.Generator) -> Sequence[Callable[[], Tensor]]:
        """One step a chunk of pairs."""
        chunks = pair_chunks(self.ranking.training, self.rates.batch, rng)
        return [partial(self._loss, chunk, rng) for chunk in chunks]

    def _loss(self, chunk: Sequence[Pair], rng: np.random.Generator) -> Tensor:
        loaded = load_pairs(self.ranking.images, chunk, self.preset.translation.size)
        loaded = loaded.to(device_of(self.ranking.ranker))
        pairs = replace(loaded, batch=vary(loaded.batch, self.preset.variation, rng))
        losses = finetune_losses(self.ranking.ranker, self.translation.translator, pairs)
        return losses.ranking + losses.merged_ranking + losses.cross_entropy

    def validate(self) -> Measures:
        """The measures of both networks."""
        return {**self.ranking.validate(), **self.translation.validate()}

    def loss_of(self, measures: Measures) -> float:
        """The sum of both networks' losses."""
        return measures["hinge"] + measures["cross_entropy"]


@dataclass(frozen=True, eq=False)
class FinetuneLosses:
    """What finetuning minimises the sum of.

    Attributes:
        ranking: L_R of the voted drawings; it keeps the ranking module true to the votes.
        merged_ranking: L_R with max(I_best, I_L), the drawing that is merged at test time, in the place of I_best. Its
            gradient reaches the image branch wherever that draws more than the best drawing does.
        cross_entropy: L_ce of the image branch; it keeps I_L from drawing whatever happens to please the ranking
            module.
    """

    ranking: Tensor
    merged_ranking: Tensor
    cross_entropy: Tensor


def finetune_losses(ranker: RankingModule, translator: TranslationBranch, pairs: PairBatch) -> FinetuneLosses:
    """The losses of one batch at the translator's resolution."""
    batch = pairs.batch
    best = torch.unique(pairs.better)
    logits = translator.logits(batch.maps[batch.view[best]])
    merged = torch.maximum(batch.drawings[best], torch.sigmoid(logits))
    everything = Batch(batch.maps, torch.cat([batch.drawings, merged]), torch.cat([batch.view, batch.view[best]]))
    scores = score_batch(ranker, everything)
    place = len(batch.drawings) + torch.searchsorted(best, pairs.better)
    return FinetuneLosses(
        ranking=ranking_loss(scores[pairs.better], scores[pairs.worse]),
        merged_ranking=ranking_loss(scores[place], scores[pairs.worse]),
        cross_entropy=cross_entropy(logits, batch.drawings[best]),
    )


def score_batch(ranker: RankingModule, batch: Batch) -> Tensor:
    """(M,) scores of a batch's drawings."""
    size = ranker.dims.size
    embedded = ranker.embed(shrink(batch.maps, size))
    return ranker.score(shrink(batch.drawings, size), embedded[batch.view])


@torch.no_grad()
def judge_pairs(ranker: RankingModule, images: ViewImages, pairs: Sequence[Pair], batch: int) -> Measures:
    """Pair accuracy and mean hinge loss on some pairs; empty without pairs."""
    if not pairs:
        return {}
    better, worse = [], []
    ranker.eval()
    for chunk in even_chunks(sorted(pairs, key=lambda pair: pair.item), batch):
        loaded = load_pairs(images, chunk, ranker.dims.size).to(device_of(ranker))
        scores = score_batch(ranker, loaded.batch)
        better.append(scores[loaded.better])
        worse.append(scores[loaded.worse])
    first, second = torch.cat(better), torch.cat(worse)
    return {"accuracy": pair_accuracy(first, second), "hinge": float(ranking_loss(first, second))}


@torch.no_grad()
def judge_views(translator: TranslationBranch, images: ViewImages, views: Sequence[tuple[Item, int]]) -> Measures:
    """Mean cross-entropy on some views' best drawings; empty without views."""
    if not views:
        return {}
    translator.eval()
    batches = (load_batch(images, [view], translator.dims.size).to(device_of(translator)) for view in views)
    losses = [cross_entropy(translator.logits(b.maps), b.drawings) for b in batches]
    return {"cross_entropy": float(torch.stack(losses).mean())}
