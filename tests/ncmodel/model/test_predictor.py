"""The model as `draw` uses it: what each variant computes, what it chooses, and what it can't do."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel.camera import Camera
from ncmodel.cli.main import main
from ncmodel.drawing.draw import draw
from ncmodel.errors import UsageError
from ncmodel.model.predictor import SEEN_SIDE, Model, load_model
from ncmodel.model.ridge_detection import IMAGE_FAMILY
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import Checkpoint, save_checkpoint
from ncmodel.nets.presets import Preset, RankingDims, Rates, TranslationDims
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, LineFamily, Mesh
from tests.helpers.analytic import monkey_saddle, torus
from tests.helpers.views import orbited

pytestmark = pytest.mark.usefixtures("one_thread")

GEOMETRY_STAGES = {"curvature", "dcurv", "outlines", "view_curvature", "line_maps", "threshold_search"}

ANY_RATES = Rates(1e-3, batch=16, epochs=1)
PRESET = Preset(
    "micro",
    TranslationDims(size=64, width=2, levels=2, blocks=1),
    RankingDims(size=64, width=2, blocks=(1, 1)),
    ANY_RATES,
    ANY_RATES,
    ANY_RATES,
)


def networks(seed: int = 0) -> Checkpoint:
    """Untrained networks."""
    ranker, translator = RankingModule(PRESET.ranking), TranslationBranch(PRESET.translation)
    for number, network in enumerate((ranker, translator)):
        initialise(network, torch.Generator().manual_seed(seed + number))
    return Checkpoint(PRESET, ranker, translator)


class ShadedEdges(TranslationBranch):
    """An image branch whose lines are known: the rim of the object."""

    def forward(self, maps: torch.Tensor) -> torch.Tensor:
        inside = (maps[:, :1] < 0.999).float()
        near = torch.nn.functional.max_pool2d(inside, 3, stride=1, padding=1)
        return near - inside


class InkLover(RankingModule):
    """A ranking module whose taste is known: the more ink the better, or the less."""

    def __init__(self, dims: RankingDims, sign: float) -> None:
        super().__init__(dims)
        self.sign = sign

    def score(self, drawings: torch.Tensor, embedded: torch.Tensor) -> torch.Tensor:
        return self.sign * drawings.mean(dim=(1, 2, 3))


def with_edges() -> Checkpoint:
    return Checkpoint(PRESET, networks().ranker, ShadedEdges(PRESET.translation))


@pytest.fixture(scope="module")
def bent() -> Surface:
    vertices, faces = torus(48, 24)
    x, y, z = vertices.T
    return Surface(Mesh(np.stack([x * (1 + 0.3 * np.sin(7 * y)), y * 1.4, z], axis=1), faces))


def view_of(surface: Surface, side: int = SEEN_SIDE) -> View:
    """A view that shares no view-independent quantities either, so that its trace is its own."""
    return orbited(surface.mesh.vertices, surface.mesh.faces, side)


def test_variants_are_what_the_networks_allow() -> None:
    both = networks()
    assert Model(both).variants == ("full", "geometry", "image")
    assert Model(Checkpoint(PRESET, ranker=both.ranker)).variants == ("geometry",)
    assert Model(Checkpoint(PRESET, translator=both.translator)).variants == ("image",)


def test_the_image_branch_alone_computes_no_geometry_of_lines(bent: Surface) -> None:
    view = view_of(bent)
    choice = Model(with_edges()).choose(view, "image")
    assert (choice.score, choice.evaluations) == (None, 0)
    assert choice.families == ()
    assert all(choice.thresholds.value(family) is None for family in FILTERED_FAMILIES)
    assert choice.strokes
    assert not set(view.trace.seconds()) & GEOMETRY_STAGES


def test_the_geometry_branch_alone_runs_no_image_branch(bent: Surface) -> None:
    view = view_of(bent)
    choice = Model(networks()).choose(view, "geometry", "draft")
    assert choice.strokes == ()
    assert "image_branch" not in view.trace.seconds()
    assert choice.score is not None
    assert choice.evaluations > 1


def test_the_full_model_merges_both(bent: Surface) -> None:
    view = view_of(bent)
    choice = Model(with_edges()).choose(view, budget="draft")
    assert LineFamily.CONTOURS in choice.families
    assert LineFamily.BOUNDARIES not in choice.families
    assert {stroke.family for stroke in choice.strokes} == {IMAGE_FAMILY}
    rim = np.concatenate([stroke.points for stroke in choice.strokes])
    rows, columns = np.nonzero(view.buffers.hit)
    # The rim of the object, to within the image branch's coarse pixels.
    pixel = SEEN_SIDE / PRESET.translation.size
    assert abs(rim[:, 0].min() - columns.min()) < 2 * pixel
    assert abs(rim[:, 1].max() - rows.max()) < 2 * pixel


def test_families_that_were_not_asked_for_are_not_computed(bent: Surface) -> None:
    view = view_of(bent)
    choice = Model(networks()).choose(view, "geometry", "draft", [LineFamily.RIDGES])
    assert set(choice.families) <= {LineFamily.CONTOURS, LineFamily.RIDGES}
    assert not {"lines_suggestive", "lines_apparent"} & set(view.trace.seconds())


def test_a_familys_threshold_is_there_where_it_is_drawn(bent: Surface) -> None:
    choice = Model(networks()).choose(view_of(bent), "geometry", "draft")
    assert choice.thresholds.unit == "p90"
    for family in FILTERED_FAMILIES:
        assert (choice.thresholds.value(family) is not None) == (family in choice.families)
        assert choice.thresholds.p90[family] > 0


def test_the_size_of_the_drawing_does_not_change_the_choice(bent: Surface) -> None:
    model = Model(with_edges())
    at_size, smaller = (model.choose(view_of(bent, side), budget="draft") for side in (SEEN_SIDE, 200))
    assert smaller.thresholds == at_size.thresholds
    for a, b in zip(at_size.strokes, smaller.strokes, strict=True):
        np.testing.assert_allclose(a.points * 200 / SEEN_SIDE, b.points)


def test_strips_are_seen_at_a_bounded_size(bent: Surface) -> None:
    camera = Camera.orbit(bent.mesh.vertices, size=(2000, 2))
    choice = Model(networks()).choose(View(bent, camera), "geometry", "draft", [])
    assert choice.families == (LineFamily.CONTOURS,)


def test_the_number_of_threads_changes_nothing_and_stays_as_it_was(bent: Surface) -> None:
    view, model = view_of(bent), Model(networks())
    alone = model.choose(view, "geometry", "draft")
    torch.set_num_threads(2)
    assert model.choose(view, "geometry", "draft") == alone
    assert torch.get_num_threads() == 2
    torch.set_num_threads(1)


def test_choices_are_deterministic(bent: Surface) -> None:
    first, again = (Model(networks()).choose(view_of(bent), budget="draft") for _ in range(2))
    assert replace(first, strokes=()) == replace(again, strokes=())


def test_boundaries_are_a_choice_where_there_are_some() -> None:
    view = orbited(*monkey_saddle(16), SEEN_SIDE)
    for sign in (1.0, -1.0):
        model = Model(Checkpoint(PRESET, ranker=InkLover(PRESET.ranking, sign)))
        assert (LineFamily.BOUNDARIES in model.choose(view, "geometry", "draft").families) == (sign > 0)


def test_what_a_model_cannot_do_is_said(bent: Surface) -> None:
    only = Model(Checkpoint(PRESET, ranker=networks().ranker))
    with pytest.raises(UsageError, match="variant: found 'full', expected one of geometry, which this model offers"):
        only.choose(view_of(bent), "full")
    with pytest.raises(UsageError, match="'fast', expected one of instant, draft, balanced, accurate"):
        only.choose(view_of(bent), budget="fast")
    with pytest.raises(UsageError, match="no image branch"):
        only.probability(np.ones((7, 8, 8), np.float32))


def test_draw_takes_a_model(bent: Surface, tmp_path: Path) -> None:
    save_checkpoint(tmp_path / "m.ckpt", networks())
    drawing = draw(bent, size=(120, 90), model=load_model(tmp_path / "m.ckpt"), preset="draft")
    assert (drawing.width, drawing.height) == (120, 90)
    assert drawing.plan.thresholds.unit == "p90"
    assert drawing.plan.score is not None
    assert drawing.plan.evaluations > 0
    assert drawing.ink().any()


def test_the_command_reports_score_and_evaluations(
    bundled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_checkpoint(tmp_path / "m.ckpt", networks())
    mesh, out = str(bundled / "bone.ply"), str(tmp_path / "bone.svg")
    arguments = ["draw", mesh, "-o", out, "--model", str(tmp_path / "m.ckpt"), "--preset", "draft", "--json"]
    assert main(arguments) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["score_evaluations"] > 0
    assert record["threshold_unit"] == "p90"
    assert np.isfinite(record["score"])


def test_a_checkpoint_that_is_none_ends_in_one_line(bundled: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.ckpt").write_bytes(b"no model")
    arguments = ["draw", str(bundled / "bone.ply"), "-o", str(tmp_path / "b.svg")]
    assert main([*arguments, "--model", str(tmp_path / "bad.ckpt")]) == 2
    assert main([*arguments, "--model", str(tmp_path / "missing.ckpt")]) == 2


def test_a_device_that_is_not_there_ends_in_one_line(
    bundled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_checkpoint(tmp_path / "m.ckpt", networks())
    mesh, model = str(bundled / "bone.ply"), str(tmp_path / "m.ckpt")
    (tmp_path / "c.json").write_text(Camera.orbit(torus(8, 4)[0]).to_json())
    for command in (
        ["draw", mesh, "-o", str(tmp_path / "b.svg")],
        ["score", mesh, str(tmp_path / "b.png"), "--camera", str(tmp_path / "c.json")],
    ):
        assert main([*command, "--model", model, "--device", "abacus"]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert "--device: found 'abacus', which torch can't use" in line


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs cuda")
def test_a_gpu_draws_what_a_cpu_draws(bent: Surface) -> None:
    on_cpu, on_gpu = (Model(networks(), device).choose(view_of(bent), budget="draft") for device in ("cpu", "cuda"))
    assert on_gpu.families == on_cpu.families
    assert on_gpu.score == pytest.approx(on_cpu.score, abs=1e-3)
    assert len(on_gpu.strokes) == len(on_cpu.strokes)
