"""The mesh files of a data set: names, upward axes, content."""

import json
from pathlib import Path

import pytest

from dataset_tools.build.config import BuildConfig
from dataset_tools.build.manifest import file_checksum
from dataset_tools.build.mesh_files import content_checksum, find_sources, read_up_table
from ncmodel.errors import InputError


def test_rules_about_axes() -> None:
    config = BuildConfig(up="z", up_rules=("a/*=y", "a/b.obj=z"))
    places = ("a/c.obj", "a/b.obj", "b.obj", "b.glb", "B.GLTF")
    assert [config.upward(place) for place in places] == ["y", "z", "z", "y", "y"]
    with pytest.raises(ValueError, match="expected PATTERN=y or PATTERN=z"):
        BuildConfig(up_rules=("a=x",))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [("file,axis\na,y\n", "expected columns file, up"), ("file,up\na.obj,x\n", "row 2 has file 'a.obj', up 'x'")],
)
def test_a_table_of_axes_that_makes_no_sense_is_bad_input(tmp_path: Path, text: str, complaint: str) -> None:
    (tmp_path / "up.csv").write_text(text)
    with pytest.raises(InputError, match=complaint):
        read_up_table(tmp_path / "up.csv")


def test_the_buffers_of_a_gltf_count_as_its_content(tmp_path: Path) -> None:
    (tmp_path / "a.gltf").write_text(json.dumps({"buffers": [{"uri": "a.bin"}, {"uri": "data:,x"}]}))
    (tmp_path / "a.bin").write_bytes(b"one")
    before = content_checksum(tmp_path / "a.gltf")
    (tmp_path / "a.bin").write_bytes(b"two")
    assert len({before, content_checksum(tmp_path / "a.gltf"), ""}) == 3


def test_the_buffers_of_a_gltf_lie_beside_it(tmp_path: Path) -> None:
    """Whatever else one names isn't opened: /dev/zero would never end."""
    (tmp_path / "a.gltf").write_text(json.dumps({"buffers": [{"uri": "/dev/zero"}]}))
    assert content_checksum(tmp_path / "a.gltf") == file_checksum(tmp_path / "a.gltf")


def test_shapes_are_named_after_their_paths(tmp_path: Path) -> None:
    for name in ("a b/c.obj", "a b/c.STL", "Ünïcode.ply", "notes.txt", "d.e.off"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("")
    found = {source.name: source.path.name for source in find_sources(tmp_path)}
    assert found == {"a_b_c": "c.STL", "a_b_c.obj": "c.obj", "d.e": "d.e.off", "n_code": "Ünïcode.ply"}


def test_no_shape_takes_anothers_place(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    for name in ("a/b.ply", "a b.ply", "a_b.ply"):
        (tmp_path / name).write_text("")
    sources = find_sources(tmp_path)
    assert len({source.name for source in sources}) == len({source.path for source in sources}) == 3


def test_a_folder_without_meshes_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no mesh file"):
        find_sources(tmp_path)
    with pytest.raises(InputError, match="no such folder"):
        find_sources(tmp_path / "nowhere")
