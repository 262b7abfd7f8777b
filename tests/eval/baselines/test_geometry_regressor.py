"""The Geometry-Regressor as a row: lines at the thresholds that it predicts, whatever the size of the picture."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from eval.baselines.geometry_regressor import draw, plan
from eval.comparison.methods import REGRESSOR, learned_methods
from ncmodel.model.maps import line_maps
from ncmodel.model.predictor import Model, as_seen
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.regressor import GeometryRegressor
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, LineFamily
from tests.helpers.micro_training import MICRO
from tests.helpers.views import bumpy, seen

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture(scope="module")
def regressor() -> GeometryRegressor:
    network = GeometryRegressor(MICRO)
    initialise(network, torch.Generator().manual_seed(0))
    return network.eval()


@pytest.fixture(scope="module")
def view() -> View:
    return seen(bumpy(amplitude=0.08))


def test_all_families_are_drawn_below_the_last_of_their_lines(view: View, regressor: GeometryRegressor) -> None:
    chosen = plan(view, regressor, MICRO)
    lines = line_maps(as_seen(view))
    present = [family for n, family in enumerate(FILTERED_FAMILIES) if lines.lines[n].any()]
    assert chosen.families == (LineFamily.CONTOURS, LineFamily.BOUNDARIES, *present)
    for number, family in enumerate(FILTERED_FAMILIES):
        if family in present:
            threshold = chosen.thresholds.value(family)
            assert threshold is not None
            assert 0 <= threshold < lines.features[number].max()
            assert chosen.thresholds.p90[family] == pytest.approx(lines.p90[number])


def test_larger_pictures_get_the_same_thresholds(view: View, regressor: GeometryRegressor) -> None:
    camera = view.camera
    larger = View(view.surface, camera.resized(2 * camera.width, 2 * camera.height))
    assert plan(larger, regressor, MICRO) == plan(view, regressor, MICRO)


def test_a_checkpoint_with_it_has_a_row(view: View, regressor: GeometryRegressor) -> None:
    model = Model(Checkpoint(replace(MICRO), regressor=regressor))
    (method,) = learned_methods({"a": model}, "draft")
    assert method.name == f"{REGRESSOR}@a"
    ink = method.draw(view).ink
    assert ink.max() > 0.9
    np.testing.assert_array_equal(method.draw(view).ink, ink)
    assert draw(view, regressor, MICRO).plan == plan(view, regressor, MICRO)
