"""A model's opinion of drawings is what it chooses by."""

import json
from pathlib import Path

import numpy as np
import pytest

from eval.comparison.opinions import PICTURE, WHOLE, opinions, settings_of
from eval.comparison.views import open_as_drawn
from eval.measures.thinning import read_ink
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.drawing.settings import Levels, draw_layers
from ncmodel.model.maps import network_maps
from ncmodel.model.predictor import load_model
from ncmodel.model.threshold_search import Budget
from ncmodel.scene.hard_edges import has_hard_edges
from ncmodel.types import LineFamily
from tests.helpers.comparisons import HELD_OUT, make_folder

pytestmark = pytest.mark.usefixtures("one_thread")
ITEM = Item(HELD_OUT, "0")


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_folder(tmp_path_factory.mktemp("opinions"))


def test_what_it_likes_best_is_what_it_chooses(root: Path) -> None:
    """With all 256 on the shortlist, at the resolution that the model sees."""
    data = DataFolder(root / "data")
    view = data.open_view(ITEM, size=(1024, 768))
    model = load_model(root / "model.safetensors")
    drawings = draw_layers(view, Levels())
    said = opinions(model, network_maps(view), [], [], drawings)
    budget = Budget((0.5,), full_grid=True, climbs=0, iterations=0, shortlist=256)
    plan = model.choose(view, "geometry", budget)
    assert plan.score == pytest.approx(said[WHOLE].candidates.max(), abs=1e-5)
    borders = LineFamily.BOUNDARIES in plan.families
    settings = enumerate(drawings.levels.settings)
    alike = [n for n, s in settings if s.plan().filtered == plan.filtered and s.borders == borders]
    assert said[WHOLE].candidates[alike].max() == pytest.approx(said[WHOLE].candidates.max(), abs=1e-5)
    assert plan.finished
    assert LineFamily.INTERSECTIONS in plan.families
    assert (LineFamily.CREASES in plan.families) == has_hard_edges(view.surface, view.crease_angle)


def test_a_model_of_pictures_judges_by_these_alone(root: Path) -> None:
    data = DataFolder(root / "data")
    view = open_as_drawn(data, ITEM)
    inks = [read_ink(path) for path in data.drawing_paths(ITEM)]
    drawings, maps = draw_layers(view, Levels()), network_maps(view)
    counting, looking = (
        opinions(load_model(root / f"{name}.safetensors"), maps, inks, settings_of(data, ITEM), drawings)
        for name in ("model", "pictures")
    )
    assert set(counting) == {WHOLE, PICTURE}
    assert set(looking) == {WHOLE}
    # Both ranking modules were trained alike.
    assert looking[WHOLE].selected == pytest.approx(counting[PICTURE].selected)
    np.testing.assert_allclose(looking[WHOLE].candidates, counting[PICTURE].candidates)


def test_a_drawing_that_was_voted_on_is_one_of_the_settings(root: Path) -> None:
    data = DataFolder(root / "data")
    settings = settings_of(data, ITEM)
    medoids = json.loads(data.selection_path(ITEM).read_text(encoding="utf-8"))["medoids"]
    assert settings == [medoid if medoid < 256 else None for medoid in medoids]
    drawings = draw_layers(data.open_view(ITEM), Levels())
    for number, setting in enumerate(settings):
        if setting is not None:
            np.testing.assert_allclose(
                drawings.drawing(setting), read_ink(data.drawing_path(ITEM, number)), atol=1 / 255
            )
