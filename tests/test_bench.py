"""The benchmark: its meshes, its arithmetic, its tables; no timing is asserted."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from eval.bench import scaling_record, scaling_rows, scaling_section, write_bench
from eval.processes import run_command, write_ply
from eval.scaling import CLASSIC, EXTRACTED, Scaling, bumpy_torus, measure_scaling, stages
from ncmodel.camera import Camera
from ncmodel.geometry.mesh import load_mesh
from ncmodel.geometry.surface import Surface
from ncmodel.geometry.view import View


@pytest.mark.parametrize("faces", [1_000, 10_000, 100_000])
def test_the_mesh_is_closed_and_has_about_the_faces_asked_for(faces: int) -> None:
    mesh = bumpy_torus(faces)
    assert len(mesh.faces) == pytest.approx(faces, rel=0.02)
    assert len(mesh.vertices) * 2 == len(mesh.faces)
    surface = Surface(mesh)
    assert surface.is_closed
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    assert volume > 0.0


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


TIMES = [
    Scaling("curvature", {10_000: 1.0, 1_000_000: 123.4}),
    Scaling("rays", {10_000: 5.0, 1_000_000: 5.0}),
]


def test_the_table_sets_published_numbers_beside_ours() -> None:
    head, curvature, rays = scaling_rows(TIMES)
    assert head == ["stage", "10k", "1M", "growth", "C++ 100k", "C++ 1M"]
    assert curvature == ["curvature", "1.0", "123", "1.05", "28.0", "272"]
    assert rays == ["rays", "5.0", "5.0", "0.00", "", ""]


def test_the_files_hold_numbers_and_a_page(tmp_path: Path) -> None:
    write_bench(tmp_path / "out", [scaling_section(TIMES)], {"scaling": scaling_record(TIMES)}, "lead")
    record = json.loads((tmp_path / "out" / "bench.json").read_text())
    assert record["scaling"][0]["milliseconds"] == {"10000": 1.0, "1000000": 123.4}
    assert record["scaling"][0]["classic_milliseconds"]["1000000"] == 272.0
    assert "<svg" in (tmp_path / "out" / "bench.html").read_text(encoding="utf-8")


def test_a_written_mesh_is_read_back(tmp_path: Path) -> None:
    mesh = bumpy_torus(1_000)
    assert write_ply(tmp_path / "m.ply", mesh) == len(mesh.faces)
    np.testing.assert_array_equal(load_mesh(tmp_path / "m.ply").faces, mesh.faces)


def test_a_process_is_accounted_for() -> None:
    run = run_command(["--help"], "help", 0)
    assert run.processor_seconds > 0.0
    assert run.seconds > 0.0
    assert 5.0 < run.peak_megabytes < 1000.0


def test_a_failing_process_says_why() -> None:
    with pytest.raises(RuntimeError, match=r"exited with 2: ncontours: .*no-such-command"):
        run_command(["no-such-command"], "x", 0)
