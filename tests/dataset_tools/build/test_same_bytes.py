"""A build leaves the same bytes however it goes: by how many workers, where, and how often it was killed."""

import os
import signal
import subprocess
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from dataset_tools.build.build import Summary, build_dataset, folder_status
from dataset_tools.build.config import BuildConfig
from dataset_tools.build.mesh_files import find_sources
from dataset_tools.build.runners import runner_for
from dataset_tools.build.store import Store
from tests.helpers.builds import build, contents, start_build, state
from tests.helpers.loopback import dask_cluster
from tests.helpers.waiting import wait_until


def test_the_number_of_workers_does_not_show(reference: tuple[Path, Summary], meshes: Path, tmp_path: Path) -> None:
    with runner_for(2) as pool:
        build(meshes, tmp_path / "pool", pool)
    assert contents(tmp_path / "pool") == contents(reference[0])


def test_a_cluster_leaves_the_same_bytes(reference: tuple[Path, Summary], meshes: Path, tmp_path: Path) -> None:
    with dask_cluster(tmp_path) as address, runner_for(1, address) as runner:
        build(meshes, tmp_path / "cluster", runner)
    assert contents(tmp_path / "cluster") == contents(reference[0])


def _begun(folder: Path, process: subprocess.Popen[bytes]) -> Callable[[], bool]:
    return lambda: any(folder.glob("*")) or process.poll() is not None


def test_a_killed_build_goes_on_to_the_same_bytes(
    reference: tuple[Path, Summary], meshes: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "killed"
    for moment in ("shapes", "views"):
        process = start_build(meshes, folder)
        # The kill comes while others of the kind are in the making.
        wait_until(_begun(folder / moment, process), 120)
        assert any((folder / moment).glob("*")), "the build ended before it made anything"
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


def wait_until_unlocked(folder: Path) -> None:
    with Store(folder).locked():
        pass
