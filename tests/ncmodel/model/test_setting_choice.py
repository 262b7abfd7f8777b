"""Which setting is chosen: by numbers, by pictures of a shortlist, and of the families asked for only."""

import numpy as np
import pytest
import torch

from ncmodel.drawing.settings import Levels, draw_layers
from ncmodel.model.maps import network_maps
from ncmodel.model.setting_choice import choose_setting, setting_scores
from ncmodel.nets.presets import RankingDims, StatisticsDims
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.scene.view import View
from ncmodel.types import LineFamily
from tests.helpers.views import bumpy, orbited

pytestmark = pytest.mark.usefixtures("one_thread")


class MoreInk(StatisticsRanker):
    """Likes drawings by their first number: the amount of ink; or the less the better."""

    def __init__(self, sign: float) -> None:
        super().__init__(StatisticsDims(width=1, networks=1))
        self.sign = sign

    def forward(self, numbers: torch.Tensor) -> torch.Tensor:
        return self.sign * numbers[:, 0]


class LessInk(RankingModule):
    """Likes pictures by how little ink they have."""

    def score(self, drawings: torch.Tensor, embedded: torch.Tensor) -> torch.Tensor:
        return -1e6 * drawings.mean(dim=(1, 2, 3))


@pytest.fixture(scope="module")
def view() -> View:
    return orbited(*bumpy(), side=96)


def test_contours_alone_are_chosen_where_less_is_better(view: View) -> None:
    choice = choose_setting(view, network_maps(view), MoreInk(-1.0), None, shortlist=8)
    assert choice.setting == Levels().settings[Levels().settings.index(choice.setting)]
    assert choice.setting.layers == ("contours",), "the one with fewest layers, of those without inner ink"
    assert (choice.score, choice.evaluations) == (0.0, 0)


def test_only_families_that_were_asked_for_are_drawn(view: View) -> None:
    asked = (LineFamily.APPARENT, LineFamily.BOUNDARIES)
    choice = choose_setting(view, network_maps(view), MoreInk(1.0), None, 0, asked)
    assert choice.setting.apparent == 0.01
    assert (choice.setting.suggestive, choice.setting.ridges_valleys, choice.setting.creases) == (None, None, False)
    # Ridges and valleys are switched together: one of them alone can't be drawn.
    choice = choose_setting(view, network_maps(view), MoreInk(1.0), None, 0, (LineFamily.RIDGES,))
    assert choice.setting.layers == ("contours",)


def test_a_ranking_module_decides_among_the_shortlist(view: View) -> None:
    maps, counting = network_maps(view), MoreInk(1.0)
    counting.mix.copy_(torch.tensor([1.0, 0.0, 1.0]))
    pictures = LessInk(RankingDims(size=32, width=2, blocks=(1,))).eval()
    most = choose_setting(view, maps, counting, None, shortlist=0)
    few = choose_setting(view, maps, counting, pictures, shortlist=6)
    every = choose_setting(view, maps, counting, pictures, shortlist=256, mirrored=True)
    drawings = draw_layers(view, Levels())
    scores = setting_scores(drawings, maps, counting)
    place = {setting: index for index, setting in enumerate(Levels().settings)}
    assert (few.evaluations, every.evaluations) == (6, 512)
    assert scores[place[few.setting]] >= np.sort(scores)[-6]
    amounts = [drawings.drawing(place[choice.setting]).sum() for choice in (every, few, most)]
    assert amounts[0] < amounts[1] <= amounts[2]


def test_scores_mix_numbers_and_habit(view: View) -> None:
    maps, counting = network_maps(view), MoreInk(1.0)
    drawings = draw_layers(view, Levels())
    counted = setting_scores(drawings, maps, counting)
    counting.habit.copy_(torch.arange(256.0))
    counting.mix.copy_(torch.tensor([0.5, 2.0, 0.0]))
    np.testing.assert_allclose(setting_scores(drawings, maps, counting), 0.5 * counted + 2.0 * np.arange(256))
