"""Drawings of maps: which search chooses their thresholds."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from ncmodel.errors import ArgumentError
from ncmodel.model.filters import Glance
from ncmodel.model.predictor import Model
from ncmodel.model.threshold_search import LARGE_BUDGETS, Budget
from ncmodel.nets.blocks import WIDE, initialise
from ncmodel.nets.checkpoints import Checkpoint, build_network
from ncmodel.nets.ranking import RankingModule
from ncmodel.published.folder import PublishedView
from ncmodel.published.model import PublishedModel
from ncmodel.published.pictures import draw_maps
from ncmodel.published.scoring import PublishedScore
from tests.helpers import published_reference as reference
from tests.helpers.micro_training import MICRO
from tests.helpers.published_weights import NARROW

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture(scope="module")
def narrow() -> RankingModule:
    """The published ranking module, narrow, with random weights."""
    ranker = build_network("ranker", NARROW)
    assert isinstance(ranker, RankingModule)
    reference.randomise(ranker, 0)
    return ranker


def test_large_ranking_modules_take_few_looks_at_maps_too(published: PublishedView) -> None:
    ranker = RankingModule(replace(MICRO.ranking, width=WIDE))
    initialise(ranker, torch.Generator().manual_seed(0))
    model = Model(Checkpoint(replace(MICRO, ranking=ranker.dims), ranker=ranker))
    drawing = draw_maps(published, model, preset="draft")
    looks = LARGE_BUDGETS["draft"].looks
    assert drawing.plan.evaluations == looks + 1
    with pytest.raises(ArgumentError, match="doesn't count ink"):
        draw_maps(published, model, preset="instant")


def test_the_published_score_is_searched_with_few_looks(published: PublishedView, narrow: RankingModule) -> None:
    brief = Budget((0.6,), full_grid=True, climbs=0, iterations=0, looks=3)
    model = PublishedModel(Checkpoint(NARROW, ranker=narrow))
    choice = model.choose_lines(published, "geometry", brief)
    assert choice.plan.evaluations == brief.looks + 1
    values = [choice.plan.thresholds.value(family) for family in choice.plan.families[2:]]
    score = PublishedScore(narrow, published).scores(np.array([values], dtype=np.float64))[0]
    assert choice.plan.score == pytest.approx(score, rel=1e-6)


def test_a_drawing_looks_from_afar_as_its_pixels_do(published: PublishedView, narrow: RankingModule) -> None:
    score, t = PublishedScore(narrow, published), np.random.default_rng(0).uniform(0, 1, (3, 4))
    pixels = np.flatnonzero(published.lines.any(axis=0))
    glance = Glance(pixels, published.lines.max(axis=0).ravel()[pixels], published.base.shape)
    inks = np.stack([score.ink(row.tolist()).ravel()[pixels[glance.pixels]] for row in t])
    np.testing.assert_allclose(score.glance(t), glance(inks), rtol=1e-5)
    assert np.ptp(inks, axis=0).max() > 0.5
