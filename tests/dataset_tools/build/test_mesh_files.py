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


def touch(root: Path, *names: str) -> Path:
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(name)
    return root


def places(root: Path) -> list[str]:
    return [source.place for source in find_sources(root)]


def test_shapes_are_named_after_their_paths(tmp_path: Path) -> None:
    touch(tmp_path, "a b/c.obj", "a b/c.STL", "Ünïcode.ply", "notes.txt", "d.e.off")
    found = {source.name: source.path.name for source in find_sources(tmp_path)}
    assert found == {"a_b_c.STL": "c.STL", "a_b_c.obj": "c.obj", "d.e": "d.e.off", "Ünïcode": "Ünïcode.ply"}


def test_what_systems_leave_behind_is_no_mesh(tmp_path: Path) -> None:
    touch(tmp_path, "ball.obj", "._ball.obj", ".trash/old.obj", "__MACOSX/._ball.obj", "__MACOSX/sub/x.obj")
    touch(tmp_path, "~$ball.obj", "$Recycle.Bin/a.obj", "System Volume Information/a.obj", "@eaDir/a.obj")
    touch(tmp_path, "lost+found/a.obj", "Thumbs.db", "desktop.ini", "ball.obj~", ".DS_Store")
    assert places(tmp_path) == ["ball.obj"]


@pytest.mark.parametrize("data", ["data", "deep/data", "."])
def test_what_a_build_wrote_is_no_mesh(tmp_path: Path, data: str) -> None:
    touch(tmp_path, "ball.obj", "shapes.obj", f"{data}/config.toml", f"{data}/shapes/ball/mesh.ply")
    assert places(tmp_path) == ["ball.obj", "shapes.obj"]
    touch(tmp_path, "other/shapes/egg.ply")  # a folder of that name that no build wrote
    assert "other/shapes/egg.ply" in places(tmp_path)


def test_linked_folders_are_followed_once(tmp_path: Path) -> None:
    meshes = touch(tmp_path / "meshes", "own/a.obj")
    touch(tmp_path / "elsewhere", "b.obj", "deep/c.obj")
    (meshes / "link").symlink_to(tmp_path / "elsewhere")
    (meshes / "a_second").symlink_to(meshes / "own")
    (meshes / "own" / "round").symlink_to(meshes)
    (meshes / "loop.obj").symlink_to(meshes / "loop.obj")
    assert places(meshes) == ["link/b.obj", "link/deep/c.obj", "loop.obj", "own/a.obj"]


def test_a_link_to_nothing_is_among_the_files_and_has_no_content(tmp_path: Path) -> None:
    (tmp_path / "gone.obj").symlink_to(tmp_path / "nowhere.obj")
    (source,) = find_sources(tmp_path)
    assert content_checksum(source.path) == ""


def test_a_folder_without_meshes_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no mesh file"):
        find_sources(tmp_path)
    with pytest.raises(InputError, match="no such folder"):
        find_sources(tmp_path / "nowhere")
