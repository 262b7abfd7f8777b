"""`ncontours dataset shapes` writes a collection, goes on where it stopped, and tells bad input in one line."""

from pathlib import Path

import pytest

from dataset_tools.build.mesh_files import Source
from dataset_tools.collection.selection import SPLITS, sources_of
from ncmodel.errors import ArgumentError
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


def test_a_folder_of_meshes_is_split_by_their_names(tmp_path: Path) -> None:
    names = ("boat_7", "vase_7", "elephant", "rabbit", "teapot", "dragon", "horse", "buddha")
    sources = [Source(f"other {name}", tmp_path / f"{name}.obj", f"{name}.obj") for name in names]
    parts = {split: {source.path.stem for source in sources_of(sources, split)} for split in SPLITS}
    assert parts["training"] | parts["test"] == parts["all"] == set(names)
    assert not parts["training"] & parts["test"]
    assert "boat_7" in parts["test"]
    assert "vase_7" in parts["training"]
    with pytest.raises(ArgumentError, match="none of 1 meshes"):
        sources_of(sources[:1], "training")
    assert sources_of([Source("x", tmp_path / "a" / "boat_7.ply", "a/boat_7.ply")], "test")


def test_a_build_takes_only_the_meshes_of_a_split(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "vase_7.obj").write_text("v 0 0 0")
    said = complaint(capsys, "dataset", "build", tmp_path / "meshes", tmp_path / "data", "--split", "test")
    assert "--split: found test, and none of 1 meshes is" in said
