"""The benchmark: its meshes, its arithmetic, its tables; no timing is asserted."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from dataset_tools.simulation.shapes import bumpy_torus
from eval.benchmark.presets import Effort, mean_efforts, measure_presets
from eval.benchmark.processes import ProcessRun, run_command, write_ply
from eval.benchmark.report import Bench, effort_rows, scaling_rows
from eval.benchmark.scaling import CLASSIC, EXTRACTED, Scaling, measure_scaling, stages
from ncmodel.camera import Camera
from ncmodel.cli.main import main
from ncmodel.drawing.draw import PRESETS
from ncmodel.errors import NeuralContoursError
from ncmodel.mesh.load import load_mesh
from ncmodel.model.predictor import Model
from ncmodel.model.threshold_search import BUDGETS
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.presets import PRESETS as PRESETS_OF_NETWORKS
from ncmodel.nets.presets import RankingDims
from ncmodel.nets.ranking import RankingModule
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from tests.helpers.dirty import signed_volume

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.mark.parametrize("faces", [1_000, 10_000, 100_000])
def test_the_mesh_is_closed_and_has_about_the_faces_asked_for(faces: int) -> None:
    mesh = bumpy_torus(faces)
    assert len(mesh.faces) == pytest.approx(faces, rel=0.02)
    assert len(mesh.vertices) * 2 == len(mesh.faces)
    surface = Surface(mesh)
    assert surface.is_closed
    assert signed_volume(mesh.vertices, mesh.faces) > 0


def test_every_family_has_lines_to_extract() -> None:
    mesh = bumpy_torus(20_000)
    view = View(Surface(mesh), Camera.orbit(mesh.vertices))
    assert all(len(view.lines(family)) > 100 for family in EXTRACTED)


def test_growth_is_the_slope_of_the_logarithms() -> None:
    quadratic = Scaling("x", {faces: 3e-6 * faces**2 for faces in (1_000, 5_000, 100_000)})
    assert quadratic.exponent == pytest.approx(2.0)
    assert math.isnan(Scaling("x", {10: 1.0}).exponent)


def test_every_published_stage_is_timed() -> None:
    mesh = bumpy_torus(1_000)
    surface = Surface(mesh)
    assert set(CLASSIC) <= set(stages(surface, View(surface, Camera.orbit(mesh.vertices))))


def test_all_stages_are_measured_at_all_sizes() -> None:
    notes: list[str] = []
    times = measure_scaling([1_000, 2_000], notes.append)
    assert len(notes) == 2
    for time in times:
        assert len(time.milliseconds) == 2
        assert all(value > 0.0 for value in time.milliseconds.values()), time.stage


BENCH = Bench(
    scaling=[Scaling("curvature", {10_000: 1.0, 1_000_000: 123.4}), Scaling("rays", {10_000: 5.0, 1_000_000: 5.0})],
    processes=[ProcessRun("contours", 10_000, 0.5, 0.6, 120.0), ProcessRun("contours", 1_000_000, 3.0, 3.5, 900.0)],
    efforts=[
        Effort("cow", "draft", 0.01, 0.98, 0.2, 100, 30.0),
        Effort("cow", "accurate", 0.04, 1.0, 0.0, 101, 31.0),
        Effort("bone", "draft", 0.03, 1.0, 0.4, 12, 10.0),
        Effort("bone", "accurate", 0.06, 1.0, 0.0, 12, 11.0),
    ],
    machine={"processors": "2"},
    searches=[
        Effort("cow", "draft", 0.5, 0.9, 1.0, 50, 20.0, 10, 0.25),
        Effort("cow", "accurate", 5.0, 1.0, 0.0, 60, 22.0, 800, 0.0),
    ],
)


def test_the_table_sets_published_numbers_beside_ours() -> None:
    head, curvature, rays = scaling_rows(BENCH.scaling)
    assert head == ["stage (ms)", "10k", "1M", "growth", "C++ 100k", "C++ 1M"]
    assert curvature == ["curvature", "1.0", "123", "1.05", "28.0", "272"]
    assert rays == ["rays", "5.0", "5.0", "0.00", "", ""]


def test_presets_are_averaged_over_shapes() -> None:
    draft, accurate = mean_efforts(BENCH.efforts)
    assert (draft.preset, draft.strokes, accurate.preset) == ("draft", 56, "accurate")
    assert (draft.seconds, draft.f1, draft.chamfer) == pytest.approx((0.02, 0.99, 0.3))
    assert effort_rows([draft])[1] == ["mean", "draft", "20.0", "99.00", "0.300", "56", "20.0"]


def test_the_files_hold_numbers_and_a_page(tmp_path: Path) -> None:
    BENCH.write(tmp_path / "out")
    record = json.loads((tmp_path / "out" / "bench.json").read_text())
    assert record == BENCH.to_record()
    assert record["scaling"][0]["milliseconds"] == {"10000": 1.0, "1000000": 123.4}
    assert record["scaling"][0]["classic_milliseconds"]["1000000"] == 272.0
    page = (tmp_path / "out" / "bench.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 3
    assert 'data-value="1000000.0">1M' in page


def test_the_text_holds_all_tables() -> None:
    words = BENCH.to_text().split()
    assert {"curvature", "contours", "accurate", "0.25"} <= set(words)
    assert "0.25" not in replace(BENCH, searches=()).to_text().split()


@pytest.fixture(scope="module")
def ranker() -> Model:
    """A small ranking module that hasn't learnt anything."""
    torch.manual_seed(0)
    preset = replace(PRESETS_OF_NETWORKS["tiny"], ranking=RankingDims(size=32, width=2, blocks=(1, 1)))
    return Model(Checkpoint(preset, ranker=RankingModule(preset.ranking)))


def test_a_model_s_drawings_are_compared_with_its_most_thorough_one(
    ranker: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number, preset in enumerate(BUDGETS):
        short = replace(BUDGETS[preset], shares=(0.5, 0.0), full_grid=number > 0, climbs=1, iterations=1 + number)
        monkeypatch.setitem(BUDGETS, preset, short)
    efforts = measure_presets([bumpy_torus(2_000)], lambda note: None, ranker)
    best = efforts[-1]
    assert (best.f1, best.chamfer, best.shortfall) == (1.0, 0.0, 0.0)
    assert 0 < efforts[0].evaluations < best.evaluations
    assert effort_rows(efforts)[0][-2:] == ["drawings scored", "score short by"]


def test_every_preset_is_compared_with_the_most_accurate_one() -> None:
    mesh = bumpy_torus(2_000)
    notes: list[str] = []
    efforts = measure_presets([mesh], notes.append)
    assert notes == [mesh.name]
    assert [effort.preset for effort in efforts] == [preset for preset in PRESETS if preset != "instant"]
    best = efforts[-1]
    assert (best.f1, best.chamfer) == (1.0, 0.0)
    for effort in efforts:
        assert effort.f1 > 0.95
        assert effort.chamfer < 0.5
        assert effort.seconds > 0.0
        assert effort.strokes > 10
        assert effort.evaluations == effort.shortfall == 0


def test_a_written_mesh_is_read_back(tmp_path: Path) -> None:
    mesh = bumpy_torus(1_000)
    assert write_ply(tmp_path / "m.ply", mesh) == len(mesh.faces)
    np.testing.assert_array_equal(load_mesh(tmp_path / "m.ply").faces, mesh.faces)


def test_a_process_is_accounted_for() -> None:
    ballast = np.ones(50_000_000)  # 400 MB of ours, which aren't the command's
    run = run_command(["--help"], "help", 0)
    assert run.processor_seconds > 0.0
    assert run.seconds > 0.0
    assert 5.0 < run.peak_megabytes < ballast.nbytes / 2e6


def test_a_failing_process_says_why() -> None:
    with pytest.raises(NeuralContoursError, match=r"exited with 2: ncontours: .*no-such-command"):
        run_command(["no-such-command"], "x", 0)


def test_the_command_measures_and_reports(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("eval.benchmark.scaling.SIZES", (1_000,))
    monkeypatch.setattr("eval.benchmark.processes.CASES", {"contours": "contours"})
    monkeypatch.setattr("dataset_tools.build.costs.VIEW_FACES", 1_000)
    monkeypatch.setattr("dataset_tools.build.costs.BUILD_SHAPES", 1)
    write_ply(tmp_path / "torus.ply", bumpy_torus(2_000))
    assert main(["bench", str(tmp_path / "torus.ply"), "-o", str(tmp_path / "out"), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record == json.loads((tmp_path / "out" / "bench.json").read_text())
    assert [run["case"] for run in record["processes"]] == ["contours"]
    assert {effort["shape"] for effort in record["presets"]} == {"torus"}
    # Of this coarse torus a pixel in fifteen hundred is farther from its contour, which runs on the smooth surface.
    assert [view["outline"] for view in record["coverage"]] == pytest.approx([1.0] * 5, abs=0.002)
    assert [view["shape"] for view in record["neatness"]] == ["torus"] * 5
    assert (tmp_path / "out" / "coverage.csv").read_text(encoding="utf-8").count("torus") == 5
    assert record["view"]["faces"] == pytest.approx(1_000, rel=0.05)
    assert record["distances"][0]["way"] == "layers"
    assert [build["workers"] for build in record["builds"]] == [1, 2]
    assert (tmp_path / "out" / "bench.html").is_file()


def test_only_parts_of_it_on_meshes_some_of_which_fail(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_ply(tmp_path / "torus.ply", bumpy_torus(2_000))
    (tmp_path / "empty.obj").write_text("")
    meshes = [str(tmp_path / "empty.obj"), str(tmp_path / "torus.ply")]
    assert main(["bench", *meshes, "-o", str(tmp_path / "out"), "--parts", "neatness"]) == 1
    out, error = capsys.readouterr()
    assert error.splitlines()[-1].startswith("ncontours: 1 could not be measured: ")
    assert out.split()[:3] == ["shape", "jaggedness", "dashes"]
    record = json.loads((tmp_path / "out" / "bench.json").read_text(encoding="utf-8"))
    assert (len(record["neatness"]), len(record["failures"]), record["scaling"]) == (5, 1, [])
    assert "empty.obj" in record["failures"][0]
    page = (tmp_path / "out" / "bench.html").read_text(encoding="utf-8")
    assert "How neat drawings are" in page
    assert "empty.obj" in page


@pytest.mark.parametrize("parts", ["speed,taste", ",", ""])
def test_parts_that_are_none_are_refused(parts: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "-o", str(tmp_path / "out"), "--parts", parts]) == 2
    error = capsys.readouterr().err
    assert error.startswith("ncontours: --parts: found ")
    assert "neatness" in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("options", [["missing.ply"], ["--model", "missing.safetensors"]])
def test_what_is_missing_is_said_before_anything_is_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str]
) -> None:
    assert main(["bench", *options, "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert error.startswith("ncontours: missing.")
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()
