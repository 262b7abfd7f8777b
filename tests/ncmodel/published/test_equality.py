"""Imported networks say what the published ones say: held against a reference written from the facts alone."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import nn

from ncmodel.nets.checkpoints import load_checkpoint, save_checkpoint
from ncmodel.nets.presets import Preset
from ncmodel.published.folder import PublishedView, read_folder
from ncmodel.published.model import PublishedModel
from ncmodel.published.ridges import line_mask
from ncmodel.published.scoring import PublishedScore
from ncmodel.published.weights import PRESET, import_weights
from tests.helpers import published_reference as reference
from tests.helpers.published_weights import NARROW, save_weights

pytestmark = pytest.mark.usefixtures("one_thread")

SAME = 1e-5
"""Relative difference of scores, of gradients and of the image branch's output."""


@pytest.fixture(scope="module", params=[NARROW, pytest.param(PRESET, marks=pytest.mark.slow)], ids=["narrow", "full"])
def preset(request: pytest.FixtureRequest) -> Preset:
    found: Preset = request.param
    return found


@pytest.fixture(scope="module")
def networks(preset: Preset) -> dict[str, nn.Module]:
    """The reference's networks with random weights and batch-norm statistics."""
    translation = reference.Translation(preset.translation.width)
    return {
        "ranker": reference.randomise(reference.Ranking(preset.ranking.width), 1),
        "translator": reference.randomise(translation, 2),
    }


@pytest.fixture(scope="module")
def model(preset: Preset, networks: dict[str, nn.Module], tmp_path_factory: pytest.TempPathFactory) -> PublishedModel:
    """The same networks, imported from .pth files and read from our checkpoint."""
    folder = tmp_path_factory.mktemp("weights")
    checkpoint = import_weights(*save_weights(folder, networks), preset)
    save_checkpoint(folder / "official.safetensors", checkpoint)
    return PublishedModel(load_checkpoint(folder / "official.safetensors"))


@pytest.fixture(scope="module")
def view(published: PublishedView, tmp_path_factory: pytest.TempPathFactory) -> PublishedView:
    """The view as it comes from its folder."""
    folder = tmp_path_factory.mktemp("view")
    for name, content in published.files().items():
        (folder / name).write_bytes(content)
    return read_folder(folder)


def test_the_image_branch_gives_the_same_output(
    model: PublishedModel, networks: dict[str, nn.Module], view: PublishedView
) -> None:
    expected = networks["translator"](reference.translation_input(view.maps[1:], view.maps[0]))[0, 0].numpy()
    found = model.paper(view.maps)
    assert found.shape == (768, 1024)
    assert expected.max() - expected.min() > 0.3
    assert np.abs(found - expected).max() < SAME


def test_the_ranking_module_gives_the_same_score_and_slope(
    model: PublishedModel, networks: dict[str, nn.Module], view: PublishedView
) -> None:
    ranker = model.checkpoint.ranker
    assert ranker is not None
    score = PublishedScore(ranker, view)
    parts = view.lines, view.features, view.n_dot_v, view.base, view.p90, view.feature_size
    for start in ([0.1, 0.2, 0.3, 0.4], [0.9, 0.02, 0.6, 1.2]):
        t = torch.tensor(start, requires_grad=True)
        theirs = reference.ranking_score(networks["ranker"], reference.drawing(*parts, t), view.maps[1], view.maps[0])
        (slope,) = torch.autograd.grad(theirs, t)
        ours, ascent = score.slope(np.array(start))
        assert slope.abs().min() > 0
        assert ours == pytest.approx(-theirs.item(), rel=SAME)
        assert np.abs(ascent + slope.double().numpy()).max() < SAME * float(slope.abs().max())
        assert score.scores(np.array([start]))[0] == pytest.approx(ours, rel=1e-6)


def test_drawings_are_the_published_ones_pixel_by_pixel(model: PublishedModel, view: PublishedView) -> None:
    assert model.checkpoint.ranker is not None
    score = PublishedScore(model.checkpoint.ranker, view)
    parts = view.lines, view.features, view.n_dot_v, view.base, view.p90, view.feature_size
    for t in ([0.0, 0.0, 0.0, 0.0], [0.1, 0.2, 0.3, 0.4], [7.0, 7.0, 7.0, 7.0]):
        expected = reference.drawing(*parts, torch.tensor(t)).numpy()
        assert np.abs(score.ink(t) - expected).max() < 1e-6


def test_ridge_detection_finds_the_same_pixels(view: PublishedView) -> None:
    # Lines of all strengths, as the image branch draws them, up to the picture's rim.
    paper = np.clip(1 - np.maximum(view.lines[1], 0.6 * view.lines[2]) * np.linspace(0, 1, 1024), 0, 1)
    expected = reference.ridge_pixels(paper.astype(np.float32))
    assert 0.005 < expected.mean() < 0.3
    assert (line_mask(paper.astype(np.float32)) == expected).mean() >= 0.999


def test_shares_of_ink_and_thresholds_belong_together(model: PublishedModel, view: PublishedView) -> None:
    assert model.checkpoint.ranker is not None
    for family in range(4):
        alone = np.zeros_like(view.lines)
        alone[family] = view.lines[family]
        score = PublishedScore(model.checkpoint.ranker, replace(view, base=np.zeros_like(view.base), lines=alone))
        # At threshold 0 suggestive contours are faded already.
        fading, whole = score.fading[family], float(score.ink([0.0] * 4).sum())
        assert score.present.tolist() == [other == family for other in range(4)]
        for share in (1.0, 0.6, 0.1):
            left = float(score.ink([fading.threshold(share)] * 4).sum())
            assert left == pytest.approx(share * whole, abs=1e-3 * whole)
        assert fading.threshold(0.3) > fading.threshold(0.5)
