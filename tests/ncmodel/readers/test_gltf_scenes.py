"""glTF as exporters and stores of data sets leave it: padding, morph targets, hidden nodes, linked buffers."""

import json
import os
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dataset_tools.build.mesh_files import content_checksum
from ncmodel.errors import MeshError
from ncmodel.mesh.load import load_mesh, read_geometry
from ncmodel.readers import gltf
from tests.helpers.gltf_files import INDICES, POSITIONS, scene
from tests.helpers.mesh_files import tetrahedron

VERTICES, FACES = tetrahedron()


def written(folder: Path, record: object, data: bytes = POSITIONS + INDICES) -> Path:
    (folder / "a.bin").write_bytes(data)
    path = folder / "a.gltf"
    path.write_text(json.dumps(record), encoding="utf-8")
    return path


@pytest.mark.parametrize("padding", [b"\0", b"\0\0\0", b" \0", b"  "])
def test_a_json_chunk_padded_by_zeros(padding: bytes, tmp_path: Path) -> None:
    text = json.dumps(scene(lambda record: record["buffers"][0].pop("uri"))).encode() + padding
    data = POSITIONS + INDICES
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    (tmp_path / "a.glb").write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    np.testing.assert_array_equal(read_geometry(tmp_path / "a.glb")[1], FACES)


@pytest.mark.parametrize(
    ("of_mesh", "of_node", "amounts"),
    [(None, None, (0, 0)), ([1, 0], None, (1, 0)), ([0.5, 2], None, (0.5, 2)), ([1, 1], [0, 0.25], (0, 0.25))],
)
def test_morph_targets_by_their_default_weights(
    of_mesh: list[float] | None, of_node: list[float] | None, amounts: tuple[float, float], tmp_path: Path
) -> None:
    """A node's weights go before its mesh's; one target has no positions, only normals, and moves nothing."""
    moves = np.random.default_rng(0).normal(size=(2, 4, 3)).astype("<f4")

    def changes(record: dict[str, Any]) -> None:
        mesh = record["meshes"][0]
        mesh["primitives"][0]["targets"] = [{"POSITION": 2}, {"POSITION": 3}, {"NORMAL": 2}]
        mesh.update({} if of_mesh is None else {"weights": [*of_mesh, 1]})
        record["nodes"][0].update({} if of_node is None else {"weights": [*of_node, 1]}, translation=[7, 0, 0])
        for view, offset in ((2, 72), (3, 120)):
            record["bufferViews"].append({"buffer": 0, "byteOffset": offset})
            record["accessors"].append({"bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3"})

    vertices, _ = read_geometry(written(tmp_path, scene(changes), POSITIONS + INDICES + moves.tobytes()))
    expected = VERTICES + amounts[0] * moves[0] + amounts[1] * moves[1] + [7, 0, 0]
    np.testing.assert_allclose(vertices, expected, atol=1e-6)


def hide(node: dict[str, Any], visible: bool = False) -> None:
    node["extensions"] = {"KHR_node_visibility": {"visible": visible}}


def test_hidden_nodes_and_all_below_them_are_not_drawn(tmp_path: Path) -> None:
    def changes(record: dict[str, Any]) -> None:
        record["nodes"] = [
            {"mesh": 0, "children": [1, 2]},
            {"mesh": 0, "translation": [10, 0, 0], "children": [3]},
            {"mesh": 0, "translation": [20, 0, 0]},
            {"mesh": 0, "translation": [30, 0, 0]},
        ]
        hide(record["nodes"][1])
        hide(record["nodes"][2], True)
        hide(record["nodes"][3], True)

    mesh = load_mesh(written(tmp_path, scene(changes)))
    assert len(mesh.faces) == 2 * len(FACES)
    assert mesh.notes[0] == "2 hidden nodes aren't drawn"
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [1, 1 / 22, 1 / 22], atol=1e-6)


def test_a_hidden_joint_still_moves_its_skin(tmp_path: Path) -> None:
    def changes(record: dict[str, Any]) -> None:
        record["nodes"] = [{"mesh": 0, "skin": 0}, {"translation": [5, 0, 0]}]
        hide(record["nodes"][1])
        record["scenes"][0]["nodes"] = [0, 1]
        record["skins"] = [{"joints": [1]}]
        record["meshes"][0]["primitives"][0]["attributes"].update(JOINTS_0=2, WEIGHTS_0=3)
        record["bufferViews"] += [{"buffer": 0, "byteOffset": 72}, {"buffer": 0, "byteOffset": 88}]
        for view, kind in ((2, 5121), (3, 5126)):
            record["accessors"].append({"bufferView": view, "componentType": kind, "count": 4, "type": "VEC4"})

    weights = np.tile([1, 0, 0, 0], (4, 1)).astype("<f4").tobytes()
    vertices, _ = read_geometry(written(tmp_path, scene(changes), POSITIONS + INDICES + bytes(16) + weights))
    np.testing.assert_allclose(vertices, VERTICES + [5, 0, 0])


def test_a_part_without_positions_is_passed_over(tmp_path: Path) -> None:
    part: dict[str, Any] = {"attributes": {"NORMAL": 0}, "indices": 1}
    mesh = load_mesh(written(tmp_path, scene(lambda r: r["meshes"][0]["primitives"].insert(0, part))))
    assert len(mesh.faces) == 4
    assert mesh.notes[0] == "1 parts without positions are passed over"


def with_buffer(uri: str) -> Callable[[dict[str, Any]], object]:
    return lambda record: record["buffers"][0].update(uri=uri)


def stored(root: Path, record: object) -> Path:
    """A store of files under their checksums, and a folder of links to them; the model's."""
    (root / "blobs").mkdir(parents=True)
    (root / "snapshots" / "main" / "parts").mkdir(parents=True)
    (root / "blobs" / "aa11").write_bytes(POSITIONS + INDICES)
    (root / "blobs" / "bb22").write_text(json.dumps(record), encoding="utf-8")
    (root / "snapshots" / "main" / "a.bin").symlink_to("../../blobs/aa11")
    (root / "snapshots" / "main" / "parts" / "a.bin").symlink_to("../../../blobs/aa11")
    model = root / "snapshots" / "main" / "scene.gltf"
    model.symlink_to("../../blobs/bb22")
    return model


@pytest.mark.parametrize("uri", ["a.bin", "parts/a.bin", "./parts/../a.bin"])
def test_buffers_of_a_store_of_links(uri: str, tmp_path: Path) -> None:
    model = stored(tmp_path / "store", scene(with_buffer(uri)))
    np.testing.assert_array_equal(read_geometry(model)[1], FACES)
    before = content_checksum(model)
    (tmp_path / "store/blobs/aa11").write_bytes(INDICES + POSITIONS)
    assert content_checksum(model) != before, "the data folder sees that a linked buffer changed"


def test_nothing_outside_the_store_is_read(tmp_path: Path) -> None:
    model = stored(tmp_path / "store", scene())
    (tmp_path / "secret").write_bytes(POSITIONS + INDICES)
    link = model.parent / "a.bin"
    for target in ("../../../secret", str(tmp_path / "secret"), "/etc/passwd", "/dev/zero"):
        link.unlink()
        link.symlink_to(target)
        with pytest.raises(MeshError, match="is no file in the folder of the mesh"):
            read_geometry(model)
    link.unlink()
    for uri in ("../../blobs/aa11", "parts/../../../blobs/aa11", os.path.abspath(tmp_path / "store/blobs/aa11")):
        (tmp_path / "store/blobs/bb22").write_text(json.dumps(scene(with_buffer(uri))))
        with pytest.raises(MeshError, match="is no file in the folder of the mesh"):
            read_geometry(model)


def test_a_link_out_of_a_plain_folder_is_refused(tmp_path: Path) -> None:
    """The model is no link: its tree is its folder."""
    (tmp_path / "model").mkdir()
    (tmp_path / "secret").write_bytes(POSITIONS + INDICES)
    model = written(tmp_path / "model", scene())
    (tmp_path / "model" / "a.bin").unlink()
    (tmp_path / "model" / "a.bin").symlink_to("../secret")
    with pytest.raises(MeshError, match="no file in the folder"):
        read_geometry(model)


def test_a_mesh_of_many_nodes_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def changes(record: dict[str, Any]) -> None:
        record["nodes"] = [{"mesh": 0, "translation": [n, 0, 0]} for n in range(50)]
        record["scenes"][0]["nodes"] = list(range(50))

    read: list[int] = []
    once = gltf._Scene._accessor

    def noted(self: gltf._Scene, index: int) -> Any:
        read.append(index)
        return once(self, index)

    monkeypatch.setattr(gltf._Scene, "_accessor", noted)
    vertices, faces = read_geometry(written(tmp_path, scene(changes)))
    assert read == [0, 1]
    np.testing.assert_array_equal(vertices, np.concatenate([VERTICES + [n, 0, 0] for n in range(50)]))
    np.testing.assert_array_equal(faces, np.concatenate([FACES + 4 * n for n in range(50)]))
