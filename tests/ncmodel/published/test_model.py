"""Imported networks on meshes: vector lines carry the published filter, in the camera's own picture."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw_view
from ncmodel.drawing.thresholding import fade
from ncmodel.errors import ArgumentError
from ncmodel.mesh.load import make_mesh
from ncmodel.model.predictor import Model
from ncmodel.model.threshold_search import Budget
from ncmodel.nets.checkpoints import Checkpoint, build_network, save_checkpoint
from ncmodel.published.model import PublishedModel, load_model
from ncmodel.published.scoring import filtered
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, LineFamily, LineSet, Thresholds
from tests.helpers import analytic
from tests.helpers import published_reference as reference
from tests.helpers.published_weights import NARROW

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture(scope="module")
def model() -> PublishedModel:
    """Narrow networks with random weights."""
    networks = {name: build_network(name, NARROW) for name in ("ranker", "translator")}
    for seed, network in enumerate(networks.values()):
        reference.randomise(network, seed)
    return PublishedModel(Checkpoint(NARROW, **networks))  # type: ignore[arg-type]


@pytest.mark.parametrize("family", FILTERED_FAMILIES)
def test_lines_of_a_mesh_fade_as_pixels_do(family: LineFamily) -> None:
    rng = np.random.default_rng(0)
    count, size, p90, t = 50, 0.02, 400.0, 0.07
    feature, facing = rng.uniform(0, 3 * p90, (count, 1)).repeat(2, 1), rng.uniform(0.01, 1, (count, 1)).repeat(2, 1)
    denominator = facing if family is LineFamily.SUGGESTIVE else np.ones_like(facing)
    points = rng.normal(size=(count, 2, 3))
    lines = LineSet(family, points, np.arange(count), feature, denominator, scale=123.0)
    thresholds = Thresholds(t, t, t, t, unit="published", p90=dict.fromkeys(FILTERED_FAMILIES, p90), feature_size=size)
    threshold = thresholds.of(family)
    assert threshold is not None
    faded = fade(lines, threshold)
    power = 2 if family in (LineFamily.SUGGESTIVE, LineFamily.APPARENT) else 1
    strength = torch.from_numpy(np.minimum(feature[:, 0], p90) * size**power).expand(4, -1)
    ink = torch.ones(4, count, dtype=torch.float64)
    pixels = filtered(ink, strength, torch.from_numpy(facing[:, 0]), torch.full((1, 4), t, dtype=torch.float64))
    expected = np.zeros(count)
    expected[faded.face] = faded.alpha[:, 0]
    assert 0 < (expected > 0).sum() < count or family is LineFamily.RIDGES
    assert expected == pytest.approx(pixels[0, FILTERED_FAMILIES.index(family)].numpy(), abs=1e-6)


def test_lines_of_the_image_branch_lie_in_the_camera_s_picture(model: PublishedModel) -> None:
    mesh = make_mesh(*analytic.torus(40, 20))
    view = View(Surface(mesh), Camera.orbit(mesh.vertices, size=(300, 300)))
    plan = model.choose(view, "image")
    assert plan.families == (LineFamily.CONTOURS, LineFamily.CREASES)
    assert plan.strokes
    points = np.concatenate([stroke.points for stroke in plan.strokes])
    # The published frame is wider than this picture: 128 of its 1024 columns lie on either side.
    assert points[:, 0].min() >= -50.0 - 1
    assert points[:, 0].max() <= 350.0 + 1
    assert 0.0 <= points[:, 1].min() <= points[:, 1].max() <= 300.0


def test_thresholds_are_chosen_among_the_families_asked_for(model: PublishedModel) -> None:
    mesh = make_mesh(*analytic.torus(40, 20))
    view = View(Surface(mesh), Camera.orbit(mesh.vertices, size=(300, 300)))
    brief = Budget((0.3, 0.0), full_grid=False, climbs=1, iterations=1)
    plan = model.choose(view, "geometry", brief, (LineFamily.APPARENT,))
    assert set(plan.families) == {LineFamily.CONTOURS, LineFamily.CREASES, LineFamily.APPARENT}
    assert plan.thresholds.unit == "published"
    assert plan.strokes == ()
    assert draw_view(view, plan).strokes
    with pytest.raises(ArgumentError, match="draft, balanced, accurate, published"):
        model.choose(view, "geometry", "instant")


def test_the_mode_is_the_checkpoint_s_unless_told(model: PublishedModel, tmp_path: Path) -> None:
    official, ours = tmp_path / "official", tmp_path / "ours"
    save_checkpoint(official, model.checkpoint)
    save_checkpoint(ours, replace(model.checkpoint, preset=replace(NARROW, published=False)))
    assert type(load_model(official)) is PublishedModel
    assert type(load_model(official, "paper")) is Model
    assert type(load_model(ours)) is Model
    with pytest.raises(ArgumentError, match="weren't imported"):
        load_model(ours, "published")
    with pytest.raises(ArgumentError, match="paper or published"):
        load_model(ours, "artist")  # type: ignore[arg-type]
