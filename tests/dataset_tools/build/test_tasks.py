"""One shape or view that hangs, explodes, crashes or fails doesn't keep the others."""

from dataclasses import replace
from pathlib import Path

import pytest

from dataset_tools.build.build import Summary, build_dataset, folder_status
from dataset_tools.build.config import TaskLimits
from dataset_tools.build.mesh_files import find_sources
from dataset_tools.build.runners import runner_for
from tests.helpers.builds import CONFIG, build, contents, state


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
