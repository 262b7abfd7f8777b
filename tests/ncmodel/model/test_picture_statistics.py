"""A picture's numbers are those of the setting that drew it, and nearly so for hands that stray."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

from ncmodel.camera import Camera
from ncmodel.drawing.settings import INK_LEVEL, LayeredDrawings, Levels, draw_layers
from ncmodel.images import png_ink
from ncmodel.mesh.load import make_mesh
from ncmodel.model.maps import network_maps
from ncmodel.model.picture_statistics import picture_scores
from ncmodel.model.predictor import Model
from ncmodel.model.scoring import score_drawings
from ncmodel.model.setting_choice import setting_scores
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.presets import StatisticsDims
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Image
from tests.helpers import analytic
from tests.helpers.micro_training import MICRO

pytestmark = pytest.mark.usefixtures("one_thread")

SOME = [0, 3, 17, 100, 146, 200, 255]


@pytest.fixture(scope="module")
def counting() -> StatisticsRanker:
    """A ranker on numbers with random weights and habits: what is tested doesn't depend on them."""
    ranker = StatisticsRanker(StatisticsDims())
    generator = torch.Generator().manual_seed(0)
    ranker.initialise(generator)
    ranker.habit.copy_(torch.randn(256, generator=generator) / 1000)
    ranker.mix.copy_(torch.tensor([1.0, 0.5, 0.0]))
    return ranker.eval()


@pytest.fixture(scope="module")
def view() -> View:
    vertices, faces = analytic.torus(80, 40)
    bumps = 1 + 0.15 * np.sin(14 * vertices[:, :1]) * np.cos(11 * vertices[:, 2:])
    mesh = make_mesh(vertices * bumps, faces, "bumpy")
    return View(Surface(mesh), Camera.orbit(mesh.vertices, size=(768, 768)))


@pytest.fixture(scope="module")
def drawings(view: View) -> LayeredDrawings:
    return draw_layers(view, Levels())


def scored(drawings: LayeredDrawings, inks: list[Image], view: View, counting: StatisticsRanker) -> list[float]:
    found = picture_scores(inks, drawings, network_maps(view), counting)
    return [float(score) for score in found]


def test_a_drawing_of_ours_scores_as_its_setting(
    drawings: LayeredDrawings, view: View, counting: StatisticsRanker
) -> None:
    expected = setting_scores(drawings, network_maps(view), counting)
    found = scored(drawings, [drawings.drawing(number) for number in SOME], view, counting)
    pictures = [np.packbits(drawings.drawing(number) > INK_LEVEL).tobytes() for number in range(256)]
    for number, score in zip(SOME, found, strict=True):
        # Settings that switch on what the view has none of give the same picture.
        twins = [twin for twin in range(256) if pictures[twin] == pictures[number]]
        assert np.abs(expected[twins] - score).min() < 1e-5
    assert np.ptp(expected[SOME]) > 0.1


def test_a_hand_that_strays_by_a_pixel_or_two_scores_nearly_as_well(
    drawings: LayeredDrawings, view: View, counting: StatisticsRanker
) -> None:
    inks = [drawings.drawing(number) for number in SOME]
    moved = [np.roll(ink, (1, 1), axis=(0, 1)) for ink in inks]
    exact, near = (np.array(scored(drawings, some, view, counting)) for some in (inks, moved))
    assert np.abs(exact - near).mean() < 0.4 * exact.std()


def test_drawings_in_files_are_scored_without_a_ranking_module(
    drawings: LayeredDrawings, view: View, counting: StatisticsRanker, tmp_path: Path
) -> None:
    checkpoint = Checkpoint(MICRO, statistics=counting)
    expected = setting_scores(drawings, network_maps(view), counting)
    paths = {str(number): tmp_path / f"{number}.png" for number in SOME}
    for name, path in paths.items():
        path.write_bytes(png_ink(drawings.drawing(int(name))))
    found = score_drawings(view.surface, paths, view.camera, Model(checkpoint))
    assert list(found.scores.values()) == pytest.approx(expected[SOME].tolist(), abs=0.05)
    assert not found.calibrated
    checkpoint.training = {"stages": {"statistics": {"validation": {"accuracy": 0.8}}}}
    known = score_drawings(view.surface, paths, view.camera, Model(checkpoint))
    assert known.calibrated
    first, second = (str(number) for number in SOME[:2])
    odds = known.probability(first, second) / known.probability(second, first)
    assert np.log(odds) == pytest.approx(known.scores[first] - known.scores[second])


def test_an_empty_page_is_judged_too(drawings: LayeredDrawings, view: View, counting: StatisticsRanker) -> None:
    blank = np.zeros_like(drawings.drawing(0))
    blot = cv2.circle(blank.copy(), (384, 384), 20, 1.0, -1)
    assert np.isfinite(scored(drawings, [blank, np.asarray(blot, dtype=np.float32)], view, counting)).all()
