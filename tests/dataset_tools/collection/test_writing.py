"""`ncontours dataset shapes` writes a collection, goes on where it stopped, and tells bad input in one line."""

from pathlib import Path

import pytest

from ncmodel.mesh.load import load_mesh
from tests.helpers.commands import complaint, printed

OPTIONS = ("--families", "bottle,lamp,cabinet", "--workers", 0)


def test_a_collection_is_written_and_gone_on_with(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first = printed(capsys, "dataset", "shapes", tmp_path / "made", "--count", 2, *OPTIONS)
    assert (first["made"], first["kept"], first["failed"]) == (2, 0, {})
    before = {path.name: path.read_bytes() for path in (tmp_path / "made").iterdir()}
    assert sorted(before) == ["cabinet_0.ply", "lamp_0.ply"]
    again = printed(capsys, "dataset", "shapes", tmp_path / "made", "--count", 3, *OPTIONS)
    assert (again["made"], again["kept"]) == (1, 2)
    assert {name: (tmp_path / "made" / name).read_bytes() for name in before} == before
    assert len(load_mesh(tmp_path / "made" / "bottle_0.ply").faces) > 4_500


def test_unknown_families_and_splits_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "--families: found teapot" in complaint(capsys, "dataset", "shapes", tmp_path, "--families", "teapot")
    assert "--split: found some" in complaint(capsys, "dataset", "shapes", tmp_path, "--split", "some")
    assert list(tmp_path.iterdir()) == []
