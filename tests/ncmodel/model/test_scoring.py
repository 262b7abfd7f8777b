"""Drawings from files get the score that the ranking module gives their pictures, and shares of people from votes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel import Camera, draw_shape, score_drawing
from ncmodel.drawing.drawing import Drawing
from ncmodel.errors import InputError, UsageError
from ncmodel.images import from_ink, write_png
from ncmodel.mesh.load import make_mesh
from ncmodel.model.calibration import RECORD
from ncmodel.model.letterbox import Square
from ncmodel.model.maps import network_maps
from ncmodel.model.predictor import Model
from ncmodel.model.scoring import score_drawings
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.presets import BACKGROUND
from ncmodel.nets.ranking import RankingModule
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from tests.helpers import analytic
from tests.helpers.micro_training import MICRO

pytestmark = pytest.mark.usefixtures("one_thread")

MESH = make_mesh(*analytic.torus(60, 30), "torus")
CAMERA = Camera.orbit(MESH.vertices, size=(1024, 768))


@pytest.fixture(scope="module")
def model() -> Model:
    """A ranking module with random weights: what is tested doesn't depend on them."""
    ranker = RankingModule(MICRO.ranking)
    initialise(ranker, torch.Generator().manual_seed(0))
    return Model(Checkpoint(MICRO, ranker=ranker))


@pytest.fixture(scope="module")
def drawings() -> dict[str, Drawing]:
    return {lines: draw_shape(MESH, CAMERA, lines) for lines in ("contours", "contours,ridges,valleys,apparent")}


def test_the_score_is_the_ranking_modules(model: Model, drawings: dict[str, Drawing]) -> None:
    """Held against the network called by hand on maps and drawing, both fitted into its square."""
    ranker = model.checkpoint.ranker
    assert ranker is not None
    square = Square(768, 1024, MICRO.ranking.size)
    maps = torch.from_numpy(square.fit(network_maps(View(Surface(MESH), CAMERA)), BACKGROUND))[None]
    for drawing in drawings.values():
        ink = torch.from_numpy(square.fit(drawing.ink()[None], 0.0))[None]
        expected = float(ranker(ink, maps)[0])
        assert score_drawing(MESH, drawing, CAMERA, model) == pytest.approx(expected, abs=1e-4)


def test_a_file_scores_as_what_it_was_written_from(model: Model, drawings: dict[str, Drawing], tmp_path: Path) -> None:
    (tmp_path / "camera.json").write_text(CAMERA.to_json())
    for number, drawing in enumerate(drawings.values()):
        drawing.save(tmp_path / f"{number}.png")
        found = score_drawing(MESH, tmp_path / f"{number}.png", tmp_path / "camera.json", model)
        assert found == pytest.approx(score_drawing(MESH, drawing, CAMERA, model), abs=1e-3)


def test_the_size_of_a_drawing_matters_little(model: Model, drawings: dict[str, Drawing]) -> None:
    first, second = (score_drawing(MESH, drawing, CAMERA, model) for drawing in drawings.values())
    half = draw_shape(MESH, CAMERA.resized(512, 384), "contours")
    assert score_drawing(MESH, half, CAMERA, model) == pytest.approx(first, abs=0.2 * abs(first - second))


def test_shares_of_people_follow_from_the_temperature(model: Model, drawings: dict[str, Drawing]) -> None:
    known = Model(replace(model.checkpoint, training={RECORD: {"temperature": 0.25}}))
    found = score_drawings(MESH, drawings, CAMERA, known)
    first, second = drawings
    difference = found.scores[first] - found.scores[second]
    assert found.calibrated
    assert found.probability(first, second) == pytest.approx(1 / (1 + np.exp(-difference / 0.25)))
    assert found.probability(first, second) + found.probability(second, first) == pytest.approx(1.0)
    guessed = score_drawings(MESH, drawings, CAMERA, model)
    assert not guessed.calibrated
    assert guessed.probability(first, second) == pytest.approx(1 / (1 + np.exp(-difference)))


def test_what_is_no_drawing_of_the_view_is_refused(model: Model, drawings: dict[str, Drawing], tmp_path: Path) -> None:
    ink = drawings["contours"].ink()
    write_png(tmp_path / "white_on_black.png", 255 - from_ink(ink))
    write_png(tmp_path / "square.png", from_ink(ink[:, 128:-128]))
    (tmp_path / "text.png").write_text("no picture")
    for name, reason in {
        "white_on_black": r"9\d% of it is ink; expected dark lines on light paper",
        "square": "768 x 768 pixels; expected the camera's frame, 1024 x 768",
        "text": "damaged or no picture",
        "none": "can't be read",
    }.items():
        with pytest.raises(InputError, match=rf"{name}\.png: .*{reason}"):
            score_drawing(MESH, tmp_path / f"{name}.png", CAMERA, model)
    with pytest.raises(InputError, match=r"drawing: an array of shape \(768, 1024, 3\); expected \(H, W\) ink"):
        score_drawing(MESH, np.zeros((768, 1024, 3), np.float32), CAMERA, model)
    with pytest.raises(UsageError, match="ranks nothing"):
        score_drawing(MESH, ink, CAMERA, Model(Checkpoint(MICRO)))
