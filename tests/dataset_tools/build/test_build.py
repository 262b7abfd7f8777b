"""Whole builds: what they leave, that they resume, and that they leave the same bytes however they go."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from dataset_tools.build.build import Summary, build_dataset, folder_status
from dataset_tools.build.config import BuildConfig, TaskLimits
from dataset_tools.build.mesh_files import find_sources, read_up_table
from dataset_tools.build.runners import HereRunner, Runner, runner_for
from dataset_tools.build.store import Store
from dataset_tools.candidates.candidates import INK_LEVEL
from ncmodel.camera import Camera
from ncmodel.errors import InputError
from ncmodel.mesh.load import load_mesh
from ncmodel.mesh.ply import ply_bytes
from ncmodel.types import Mesh
from tests.helpers import analytic, dirty
from tests.helpers.loopback import dask_cluster

CONFIG = BuildConfig(width=64, height=48, render_size=32, min_faces=100)
PATIENCE = 120.0  # seconds


def make_meshes(folder: Path) -> Path:
    """Two shapes that can be drawn, one of them inside out, one that can't, and one of low resolution."""
    folder.mkdir()
    egg = dirty.sphere(fineness=2)
    bumpy = (egg[0] * (1 + 0.2 * np.sin(5 * egg[0][:, :1])), egg[1])
    parts = {
        "ball": dirty.sphere(fineness=2),
        "odd/bumpy": dirty.inside_out(bumpy),
        "cube": dirty.box(),
        "soup": (np.random.default_rng(0).random((900, 3)), np.arange(900).reshape(-1, 3)),
    }
    for name, part in parts.items():
        path = folder / f"{name}.ply"
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(ply_bytes(Mesh(*part)))
    return folder


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_meshes(tmp_path_factory.mktemp("build") / "meshes")


@pytest.fixture(scope="module")
def reference(meshes: Path) -> tuple[Path, Summary]:
    """An uninterrupted build in one process."""
    folder = meshes.parent / "reference"
    return folder, build(meshes, folder)


def build(meshes: Path, folder: Path, runner: Runner | None = None, retry: bool = False) -> Summary:
    return build_dataset(find_sources(meshes), folder, CONFIG, runner or HereRunner(), retry=retry)


def contents(folder: Path) -> dict[str, bytes]:
    """Every file but those that hold times and process numbers."""
    files = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    return {name: data for name, data in files.items() if name not in (".lock", "index.csv")}


def picture(path: Path) -> Any:
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


def state(folder: Path) -> dict[tuple[str, int], str]:
    return {(row.shape, row.view): row.status for row in folder_status(folder)}


def test_every_view_is_done_or_has_its_reason(reference: tuple[Path, Summary]) -> None:
    folder, summary = reference
    assert (summary.made, summary.count("done"), summary.count("failed"), summary.count("skipped")) == (4, 4, 2, 2)
    reasons = {row.shape: row.reason for row in folder_status(folder) if row.status != "done"}
    assert reasons["cube"] == "low resolution: 12 faces, expected at least 100"
    assert "loose triangles" in reasons["soup"]
    listed = (folder / "index.csv").read_text().splitlines()
    assert listed[0] == "shape,view,status,reason,seconds"
    assert len(listed) == 1 + 2 * 4
    assert listed[1].startswith("ball,0,done,,")


def test_a_view_folder_holds_what_the_formats_say(reference: tuple[Path, Summary]) -> None:
    view = reference[0] / "views" / "odd_bumpy_1"
    expected = {"camera.json", "candidates.json", "candidates.npz", "depth.png", "manifest.json", "selection.json"}
    expected |= {f"shaded_{level}.png" for level in range(6)} | {f"drawings/{number}.png" for number in range(8)}
    expected |= {f"renders/{number}.png" for number in range(3)}
    assert set(contents(view)) == expected
    camera = Camera.load(view / "camera.json")
    assert (camera.width, camera.height) == (64, 48)
    for name in ("depth.png", *(f"shaded_{level}.png" for level in range(6))):
        image = picture(view / name)
        assert (image.dtype, image.shape) == (np.uint16, (48, 64))
        assert image[0, 0] == 65535
        assert image.min() < 65535


def test_candidates_selection_and_drawings_belong_together(reference: tuple[Path, Summary]) -> None:
    view = reference[0] / "views" / "odd_bumpy_0"
    with np.load(view / "candidates.npz") as archive:
        assert archive["shape"].tolist() == [264, 48, 64]
        ink = np.unpackbits(archive["ink"], axis=-1, count=64).astype(bool)
    specs = json.loads((view / "candidates.json").read_text())
    assert [spec["index"] for spec in specs] == list(range(264))
    selection = json.loads((view / "selection.json").read_text())
    assert len(selection["medoids"]) == 8
    assert len(selection["labels"]) == 264
    assert "symmetric Chamfer distance in pixels" in selection["distance"]
    for place, index in enumerate(selection["medoids"]):
        drawing = picture(view / "drawings" / f"{place}.png")
        assert np.array_equal(1 - drawing / 255 > INK_LEVEL, ink[index])


def test_the_cleaned_mesh_is_in_object_space(reference: tuple[Path, Summary]) -> None:
    shape = reference[0] / "shapes" / "odd_bumpy"
    mesh = load_mesh(shape / "mesh.ply")
    assert mesh.notes == ()
    assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(1.0)
    assert dirty.signed_volume(mesh.vertices, mesh.faces) > 0
    report = json.loads((shape / "clean.json").read_text())
    assert report["status"] == "done"
    assert {"found", "done", "left"} <= set(report)
    assert report["done"] == [{"step": "faces turned to face outwards", "count": 320}]


def test_a_second_run_makes_nothing(reference: tuple[Path, Summary], meshes: Path) -> None:
    folder, _ = reference
    before = {path: path.stat().st_mtime_ns for path in (folder / "views").rglob("*")}
    assert build(meshes, folder).made == 0
    assert {path: path.stat().st_mtime_ns for path in (folder / "views").rglob("*")} == before
    assert (folder / "index.csv").read_text().splitlines()[1].split(",")[-1] != "", "times are kept"


def test_the_number_of_workers_does_not_show(reference: tuple[Path, Summary], meshes: Path, tmp_path: Path) -> None:
    with runner_for(2) as pool:
        build(meshes, tmp_path / "pool", pool)
    assert contents(tmp_path / "pool") == contents(reference[0])


def test_a_cluster_leaves_the_same_bytes(reference: tuple[Path, Summary], meshes: Path, tmp_path: Path) -> None:
    with dask_cluster(tmp_path) as address, runner_for(1, address) as runner:
        build(meshes, tmp_path / "cluster", runner)
    assert contents(tmp_path / "cluster") == contents(reference[0])


@pytest.fixture
def copy(reference: tuple[Path, Summary], tmp_path: Path) -> Path:
    """A data folder to spoil."""
    for name, data in contents(reference[0]).items():
        path = tmp_path / "copy" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    (tmp_path / "copy" / "index.csv").write_bytes((reference[0] / "index.csv").read_bytes())
    return tmp_path / "copy"


def test_damage_is_found_and_made_again(copy: Path, reference: tuple[Path, Summary], meshes: Path) -> None:
    truncated, edited = copy / "views/ball_0/depth.png", copy / "views/odd_bumpy_1/selection.json"
    truncated.write_bytes(truncated.read_bytes()[:100])
    record = json.loads(edited.read_text())
    del record["medoids"]
    edited.write_text(json.dumps(record))
    (copy / "shapes/odd_bumpy/mesh.ply").write_bytes(b"ply\n")
    damaged = {key for key, status in state(copy).items() if status == "damaged"}
    assert damaged == {("ball", 0), ("odd_bumpy", 0), ("odd_bumpy", 1)}
    assert build(meshes, copy).made == 2
    assert contents(copy) == contents(reference[0])


def test_damage_that_keeps_sizes_is_found_by_checksums_and_then_made_again(
    copy: Path, reference: tuple[Path, Summary], meshes: Path
) -> None:
    changed = copy / "views/ball_1/shaded_3.png"
    data = bytearray(changed.read_bytes())
    data[-30] ^= 1
    changed.write_bytes(data)
    assert state(copy)["ball", 1] == "done"
    assert {row.reason for row in folder_status(copy, verify=True) if row.status == "damaged"} == {
        "shaded_3.png was changed"
    }
    assert build(meshes, copy).made == 1
    assert contents(copy) == contents(reference[0])


def test_a_killed_build_goes_on_to_the_same_bytes(
    reference: tuple[Path, Summary], meshes: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "killed"
    for moment in ("shapes", "views"):
        process = start_build(meshes, folder)
        # The kill comes while others of the kind are in the making.
        wait_for(lambda kind=moment: any((folder / kind).glob("*")), process)
        os.killpg(process.pid, signal.SIGKILL) if moment == "shapes" else process.kill()
        process.wait()
        assert set(state(folder).values()) <= {"pending", "done", "failed", "skipped"}
    wait_until_unlocked(folder)
    build(meshes, folder)
    assert contents(folder) == contents(reference[0])


REAL_CONFIG = BuildConfig(width=256, height=192, render_size=96)
REAL = ("bob.obj", "citroen_van.ply", "goathead.obj", "husky_wheel.stl", "milk_truck.ply", "wingnut.obj")
KILLS = 8


@pytest.mark.slow
def test_real_views_are_the_same_bytes_however_they_come_about(shared: Path, tmp_path: Path) -> None:
    meshes = tmp_path / "meshes"
    meshes.mkdir()
    for name in REAL:
        (meshes / name).symlink_to(shared / "meshes" / "clean" / name)
    with runner_for(1) as pool:
        summary = build_dataset(find_sources(meshes), tmp_path / "reference", REAL_CONFIG, pool)
    assert summary.count("done") == 2 * len(REAL)
    expected = contents(tmp_path / "reference")
    with runner_for(2) as pool:
        build_dataset(find_sources(meshes), tmp_path / "two", REAL_CONFIG, pool)
    assert contents(tmp_path / "two") == expected
    with dask_cluster(tmp_path) as address, runner_for(1, address) as runner:
        build_dataset(find_sources(meshes), tmp_path / "cluster", REAL_CONFIG, runner)
    assert contents(tmp_path / "cluster") == expected
    rng = np.random.default_rng(0)
    for kill in range(KILLS):
        process = start_build(meshes, tmp_path / "killed")
        with suppress(subprocess.TimeoutExpired):
            process.wait(rng.uniform(3.0, 15.0))
        with suppress(ProcessLookupError):  # it came to its end
            os.killpg(process.pid, signal.SIGKILL) if kill % 2 else process.kill()
        process.wait()
        if (tmp_path / "killed" / "config.toml").exists():
            found = {row.status for row in folder_status(tmp_path / "killed", verify=True)}
            assert found <= {"done", "pending"}, "nothing half-written counts"
    with runner_for(2) as pool:
        build_dataset(find_sources(meshes), tmp_path / "killed", REAL_CONFIG, pool)
    assert contents(tmp_path / "killed") == expected


def start_build(meshes: Path, folder: Path) -> "subprocess.Popen[bytes]":
    (meshes.parent / "settings.toml").write_text((meshes.parent / "reference" / "config.toml").read_text())
    command = [sys.executable, "-m", "ncmodel.cli.main", "dataset", "build", str(meshes), str(folder), "--workers", "2"]
    command += ["--config", str(meshes.parent / "settings.toml")]
    return subprocess.Popen(
        command,
        cwd=Path(__file__).parents[3],
        start_new_session=True,
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )


def wait_for(condition: object, process: "subprocess.Popen[bytes]") -> None:
    assert callable(condition)
    deadline = time.monotonic() + PATIENCE
    while not condition() and process.poll() is None:
        assert time.monotonic() < deadline, "took too long"
        time.sleep(0.02)


def wait_until_unlocked(folder: Path) -> None:
    with Store(folder).locked():
        pass


def test_failures_are_kept_until_they_are_tried_again(
    copy: Path, meshes: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stumble(*arguments: object) -> dict[str, bytes]:
        raise ZeroDivisionError("strange shape")

    damaged = copy / "views" / "ball_0" / "depth.png"
    damaged.unlink()
    with monkeypatch.context() as patch:
        patch.setattr("dataset_tools.build.tasks.view_files", stumble)
        assert build(meshes, copy).made == 0
    assert state(copy)["ball", 0] == "failed"
    assert not damaged.parent.exists(), "what is damaged and can't be made again doesn't stay"
    assert build(meshes, copy).made == 0
    summary = build(meshes, copy, retry=True)
    assert summary.made == 1
    assert state(copy)["ball", 0] == "done"


def test_a_folder_of_other_settings_is_not_mixed(copy: Path, meshes: Path) -> None:
    with pytest.raises(InputError, match=r"config.toml: views is 2; expected 3"):
        build_dataset(find_sources(meshes), copy, replace(CONFIG, views=3), HereRunner())


def test_limits_may_differ_between_runs(copy: Path, meshes: Path) -> None:
    settings = replace(CONFIG, limits=TaskLimits(view_seconds=7.0))
    assert build_dataset(find_sources(meshes), copy, settings, HereRunner()).made == 0
    assert "view_seconds = 7.0" in (copy / "config.toml").read_text()


def test_a_mesh_file_with_other_content_is_made_again(copy: Path, tmp_path: Path) -> None:
    folder = make_meshes(tmp_path / "meshes")
    ball, bumpy = (folder / name for name in ("ball.ply", "odd/bumpy.ply"))
    swapped = ball.read_bytes(), bumpy.read_bytes()
    ball.write_bytes(swapped[1])
    bumpy.write_bytes(swapped[0])
    assert build(folder, copy).made == 4
    fresh = tmp_path / "fresh"
    build(folder, fresh)
    assert contents(copy) == contents(fresh)


def test_a_mesh_file_that_came_to_nothing_leaves_no_old_view(copy: Path, tmp_path: Path) -> None:
    folder = make_meshes(tmp_path / "meshes")
    (folder / "ball.ply").write_bytes(b"no mesh")
    assert build(folder, copy).made == 0
    assert not (copy / "views" / "ball_0").exists()
    assert state(copy)["ball", 0] == "failed"


def test_a_renamed_mesh_file_is_another_shape(copy: Path, tmp_path: Path) -> None:
    folder = make_meshes(tmp_path / "meshes")
    (folder / "cube.ply").rename(folder / "dice.ply")
    assert build(folder, copy).made == 0
    assert state(copy)["dice", 0] == "skipped"
    (folder / "soup.ply").rename(folder / "cube.ply")
    build(folder, copy)
    assert state(copy)["cube", 0] == "failed", "another file under an old name"


def test_each_file_has_its_own_upward_axis(tmp_path: Path) -> None:
    ball = dirty.sphere(fineness=2)
    folder = tmp_path / "meshes"
    (folder / "cad").mkdir(parents=True)
    for name, tall in (("cad/part.ply", [1, 1, 2]), ("pot.ply", [1, 2, 1])):
        (folder / name).write_bytes(ply_bytes(Mesh(ball[0] * tall, ball[1])))
    (tmp_path / "up.csv").write_text("file,up\ncad/*,z\n")
    config = replace(CONFIG, views=1, up_rules=read_up_table(tmp_path / "up.csv"), duplicate_distance=0.0)
    build_dataset(find_sources(folder), tmp_path / "data", config, HereRunner())
    for shape in ("cad_part", "pot"):
        extent = np.ptp(load_mesh(tmp_path / "data" / "shapes" / shape / "mesh.ply").vertices, axis=0)
        assert extent == pytest.approx([0.5, 1.0, 0.5]), shape
    changed = replace(config, up_rules=("*=y",))
    assert build_dataset(find_sources(folder), tmp_path / "data", changed, HereRunner()).made == 1


def test_damage_is_told_where_nothing_can_be_written_and_beside_a_build(
    copy: Path, meshes: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    changed = copy / "views/ball_1/candidates.npz"
    data = bytearray(changed.read_bytes())
    data[50] ^= 1
    changed.write_bytes(data)

    def damaged() -> list[str]:
        return [row.reason for row in folder_status(copy, verify=True) if row.status == "damaged"]

    with Store(copy).locked():
        assert damaged() == ["candidates.npz was changed"]
    for path in (copy, *(path for path in copy.rglob("*") if path.is_dir())):
        path.chmod(0o555)
    before = {path: path.stat().st_mtime_ns for path in copy.rglob("*")}
    with monkeypatch.context() as patch:
        patch.setattr(Store, "locked", forbidden)  # the superuser may write everywhere
        assert damaged() == ["candidates.npz was changed"]
    assert {path: path.stat().st_mtime_ns for path in copy.rglob("*")} == before
    for path in (copy, *(path for path in copy.rglob("*") if path.is_dir())):
        path.chmod(0o755)
    assert state(copy)["ball", 1] == "done", "nothing was noted"
    damaged()
    assert state(copy)["ball", 1] == "damaged"
    assert build(meshes, copy).made == 1


def forbidden(store: Store, sweep: bool) -> None:
    raise InputError(store.root, "can't be written (Read-only file system)", "a folder to write to")


def test_shapes_can_be_added_later(copy: Path, meshes: Path, tmp_path: Path) -> None:
    more = tmp_path / "more"
    more.mkdir()
    (more / "extra.ply").write_bytes(ply_bytes(Mesh(*analytic.torus(24, 12))))
    assert build(more, copy).made == 2
    assert len(folder_status(copy)) == 10


@pytest.mark.parametrize(
    ("limits", "reason"),
    [
        (TaskLimits(clean_seconds=0.01), "it took more than 0.01 s"),
        (TaskLimits(memory_gb=0.3), "it needs more than 0.3 GB of memory"),
    ],
    ids=["time", "memory"],
)
def test_a_cleaner_over_its_limits_fails_that_shape_alone(
    meshes: Path, tmp_path: Path, limits: TaskLimits, reason: str
) -> None:
    sources = [source for source in find_sources(meshes) if source.name == "ball"]
    with runner_for(1) as pool:
        summary = build_dataset(sources, tmp_path / "data", replace(CONFIG, limits=limits), pool)
    assert [(row.status, row.reason) for row in summary.rows] == [("failed", reason)] * 2


def test_a_process_that_crashes_fails_that_shape_alone(
    meshes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    crash = tmp_path / "crash"
    crash.write_text("#!/bin/sh\necho 'about to crash' >&2\nkill -SEGV $$\n")
    crash.chmod(0o755)
    monkeypatch.setattr("sys.executable", str(crash))
    sources = [source for source in find_sources(meshes) if source.name == "ball"]
    with runner_for(1) as pool:
        summary = build_dataset(sources, tmp_path / "data", CONFIG, pool)
    assert {row.reason for row in summary.rows} == {"its process died with signal SIGSEGV (about to crash)"}


@pytest.mark.parametrize(
    ("trouble", "reason"),
    [("ctypes.CDLL(None).sleep(1000)", "it took more than 5 s"), ("bytearray(1 << 40)", "it needs more than 8 GB")],
    ids=["hangs", "explodes"],
)
def test_a_view_over_its_limits_fails_alone(
    trouble: str, reason: str, reference: tuple[Path, Summary], meshes: Path, tmp_path: Path
) -> None:
    # Python runs sitecustomize.py at the start of every process, those of the workers too.
    (tmp_path / "sitecustomize.py").write_text(TROUBLE_WITH_ONE_VIEW.format(trouble=trouble))
    folder = tmp_path / "data"
    settings = replace(CONFIG, limits=TaskLimits(view_seconds=5.0))
    with pytest.MonkeyPatch.context() as patch, runner_for(2) as pool:
        patch.syspath_prepend(str(tmp_path))
        build_dataset(find_sources(meshes), folder, settings, pool)
    wrong = {(row.shape, row.view): row.reason for row in folder_status(folder) if row.status == "failed"}
    assert wrong.pop(("ball", 1)).startswith(reason)
    assert {shape for shape, _ in wrong} == {"soup"}
    assert not (folder / "views" / "ball_1").exists()
    assert build(meshes, folder, retry=True).made == 1
    assert contents(folder) == contents(reference[0])


TROUBLE_WITH_ONE_VIEW = """
import ctypes
import dataset_tools.build.tasks as work

plain = work.view_files


def strange(surface, number, config):
    if (surface.mesh.name, number) == ("ball", 1):
        {trouble}
    return plain(surface, number, config)


work.view_files = strange
"""


def test_the_state_of_something_else_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no config.toml in it"):
        folder_status(tmp_path)
