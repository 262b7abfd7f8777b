"""Damage to a view folder is found, told, and made good by the next build."""

import json
from pathlib import Path

import pytest

from dataset_tools.build.build import Summary, folder_status
from dataset_tools.build.store import Store
from ncmodel.errors import InputError
from tests.helpers.builds import build, contents, state


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
