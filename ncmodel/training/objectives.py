"""What the three training stages minimise, and how their networks are judged on held-out views (section 5)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

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
    PairPart,
    Stored,
    StoredPairs,
    ViewPart,
    draw_poses,
    even_chunks,
    items_of,
    load_batch,
    pair_chunks,
    shrink,
    shuffled,
)
from ncmodel.training.dataset import ViewImages
from ncmodel.training.loader import Examiner, Part
from ncmodel.training.state import Measures

SCALE_VIEWS = 16
"""Views that the input scales are measured on."""


class Objective(Protocol):
    """One training stage: what it trains, what its steps look at and minimise, its judgement."""

    name: str
    networks: dict[str, nn.Module]
    rates: Rates
    averaging: float
    pretrained: bool

    @property
    def images(self) -> ViewImages | None:
        """Where its pictures are; None if it looks at none."""

    def prepare(self) -> None:
        """Set what the networks know before their first step: input scales and the like."""

    def steps(self, rng: np.random.Generator) -> Sequence[Part]:
        """What the steps of one pass over the training data look at."""

    def loss(self, batch: Any) -> Tensor:
        """What a step minimises, given what it looks at, or a part of that: the mean over its examples."""

    def validate(self, examiner: Examiner) -> Measures:
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
        batch = load_batch(self.images, sorted(ends), self.ranker.dims.size).on(device_of(self.ranker))
        self.ranker.standardise_maps.fit(self.ranker.pick(batch.maps))
        self.ranker.standardise_drawing.fit(batch.drawings)

    def steps(self, rng: np.random.Generator) -> Sequence[Part]:
        """One step a chunk of pairs."""
        return pair_steps(self.training, self.rates.batch, self.ranker.dims.size, self.preset, rng)

    def loss(self, pairs: PairBatch) -> Tensor:
        """The hinge loss."""
        scores = score_batch(self.ranker, pairs.batch)
        return ranking_loss(scores[pairs.better], scores[pairs.worse])

    def validate(self, examiner: Examiner) -> Measures:
        """Pair accuracy and mean hinge loss."""
        return judge_pairs(self.ranker, self.held_out, self.rates.batch, examiner)

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
        stored = load_batch(self.images, self.training[:SCALE_VIEWS], self.translator.dims.size)
        batch = stored.on(device_of(self.translator))
        self.translator.standardise.fit(self.translator.pick(batch.maps))
        self.translator.expect_ink(float(batch.drawings.mean()))

    def steps(self, rng: np.random.Generator) -> Sequence[Part]:
        """One step a few views."""
        size, variation = self.translator.dims.size, self.preset.variation
        chunks = even_chunks(shuffled(self.training, rng), self.rates.batch)
        return [ViewPart(tuple(c), size, draw_poses(items_of(c), variation, size, rng)) for c in chunks]

    def loss(self, batch: Batch) -> Tensor:
        """The cross-entropy."""
        return cross_entropy(self.translator.logits(batch.maps), batch.drawings)

    def validate(self, examiner: Examiner) -> Measures:
        """Mean cross-entropy."""
        return judge_views(self.translator, self.held_out, examiner)

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
        self.images = images

    def prepare(self) -> None:
        """Nothing: both networks come trained."""

    def steps(self, rng: np.random.Generator) -> Sequence[Part]:
        """One step a chunk of pairs."""
        return pair_steps(self.ranking.training, self.rates.batch, self.preset.translation.size, self.preset, rng)

    def loss(self, pairs: PairBatch) -> Tensor:
        """The sum of `FinetuneLosses`."""
        losses = finetune_losses(self.ranking.ranker, self.translation.translator, pairs)
        return losses.ranking + losses.merged_ranking + losses.cross_entropy

    def validate(self, examiner: Examiner) -> Measures:
        """The measures of both networks."""
        return {**self.ranking.validate(examiner), **self.translation.validate(examiner)}

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
        cross_entropy=cross_entropy(logits, batch.drawings[best], pairs.emphasis),
    )


def pair_steps(
    pairs: Sequence[Pair], batch: int, size: int, preset: Preset, rng: np.random.Generator
) -> list[PairPart]:
    """The steps of one pass over ranking pairs: about `batch` a step, each view in a pose of its own."""
    chunks = pair_chunks(pairs, batch, rng)
    return [
        PairPart(tuple(c), size, draw_poses(list(dict.fromkeys(p.item for p in c)), preset.variation, size, rng))
        for c in chunks
    ]


def score_batch(ranker: RankingModule, batch: Batch) -> Tensor:
    """(M,) scores of a batch's drawings."""
    size = ranker.dims.size
    embedded = ranker.embed(shrink(batch.maps, size))
    return ranker.score(shrink(batch.drawings, size), embedded[batch.view])


@torch.no_grad()
def judge_pairs(ranker: RankingModule, pairs: Sequence[Pair], batch: int, examiner: Examiner) -> Measures:
    """Pair accuracy and mean hinge loss on some pairs; empty without pairs."""
    if not pairs:
        return {}
    ranker.eval()

    def scores(stored: StoredPairs) -> Tensor:
        loaded = stored.on(device_of(ranker))
        found = score_batch(ranker, loaded.batch)
        return torch.stack([found[loaded.better], found[loaded.worse]])

    chunks = even_chunks(sorted(pairs, key=lambda pair: pair.item), batch)
    answers = examiner.answers([PairPart(tuple(chunk), ranker.dims.size, {}) for chunk in chunks], scores)
    better, worse = torch.cat(answers, dim=1)
    return {"accuracy": pair_accuracy(better, worse), "hinge": float(ranking_loss(better, worse))}


@torch.no_grad()
def judge_views(translator: TranslationBranch, views: Sequence[tuple[Item, int]], examiner: Examiner) -> Measures:
    """Mean cross-entropy on some views' best drawings; empty without views."""
    if not views:
        return {}
    translator.eval()

    def loss(stored: Stored) -> Tensor:
        batch = stored.on(device_of(translator))
        return cross_entropy(translator.logits(batch.maps), batch.drawings)

    answers = examiner.answers([ViewPart((view,), translator.dims.size, {}) for view in views], loss)
    return {"cross_entropy": float(torch.stack(answers).mean())}
