"""glTF: buffers, accessors, primitives, scenes, skins, and what isn't read."""

import base64
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ncmodel.errors import MeshError
from ncmodel.mesh.load import load_mesh, read_geometry
from ncmodel.types import Floats
from tests.helpers.gltf_files import INDICES, POSITIONS, as_glb, scene
from tests.helpers.mesh_files import tetrahedron

VERTICES, FACES = tetrahedron()


def read(folder: Path, record: object, data: bytes = POSITIONS + INDICES) -> tuple[Floats, Floats]:
    """The vertices, and the corners of faces, of a record with one buffer."""
    (folder / "a.bin").write_bytes(data)
    (folder / "a.gltf").write_text(json.dumps(record), encoding="utf-8")
    vertices, faces = read_geometry(folder / "a.gltf")
    return vertices, vertices[faces]


def test_buffers_beside_inside_and_in_the_text(tmp_path: Path) -> None:
    np.testing.assert_array_equal(read(tmp_path, scene())[1], VERTICES[FACES])
    (tmp_path / "é b.bin").write_bytes(POSITIONS + INDICES)
    inline = "data:application/octet-stream;base64," + base64.b64encode(POSITIONS + INDICES).decode()
    for uri in ("%C3%A9%20b.bin", "é b.bin", inline):
        record = scene()
        record["buffers"][0]["uri"] = uri
        np.testing.assert_array_equal(read(tmp_path, record, b"")[1], VERTICES[FACES])
    (tmp_path / "a.glb").write_bytes(as_glb(scene(lambda r: r["buffers"][0].pop("uri")), POSITIONS + INDICES))
    vertices, faces = read_geometry(tmp_path / "a.glb")
    np.testing.assert_array_equal(vertices[faces], VERTICES[FACES])


def test_nodes_without_a_scene(tmp_path: Path) -> None:
    def changes(record: dict[str, Any]) -> None:
        record.pop("scene")
        record.pop("scenes")
        record["nodes"] = [{"mesh": 0, "translation": [1, 0, 0]}, {"children": [0], "scale": [2, 2, 2]}]

    np.testing.assert_array_equal(read(tmp_path, scene(changes))[1], (VERTICES + [1, 0, 0])[FACES] * 2)


def test_instances_stand_where_their_nodes_put_them(tmp_path: Path) -> None:
    """Moved, mirrored (and still outwards), turned by its parent, and by a matrix."""

    def changes(record: dict[str, Any]) -> None:
        half = np.sqrt(0.5)
        matrix = [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]
        record["nodes"] = [
            {"mesh": 0, "translation": [3, 0, 0]},
            {"mesh": 0, "scale": [-1, 1, 1]},
            {"children": [3], "rotation": [0, half, 0, half]},
            {"mesh": 0, "scale": [1, 2, 1]},
            {"mesh": 0, "matrix": matrix},
        ]
        record["scenes"][0]["nodes"] = [0, 1, 2, 4]

    _, corners = read(tmp_path, scene(changes))
    x, y, z = VERTICES.T
    np.testing.assert_allclose(corners[:4], (VERTICES + [3, 0, 0])[FACES])
    np.testing.assert_allclose(corners[4:8], (VERTICES * [-1, 1, 1])[FACES[:, ::-1]])
    np.testing.assert_allclose(corners[8:12], np.stack([z, 2 * y, -x], 1)[FACES], atol=1e-12)
    np.testing.assert_allclose(corners[12:], np.stack([5 - y, 6 + x, 7 + z], 1)[FACES], atol=1e-12)


@pytest.mark.parametrize(
    ("mode", "order", "expected"),
    [
        (4, [0, 1, 2, 2, 1, 3, 0], [[0, 1, 2], [2, 1, 3]]),
        (5, [0, 1, 2, 3], [[0, 1, 2], [2, 1, 3]]),
        (5, [0, 1, 2, 2, 3, 1], [[0, 1, 2], [3, 2, 1]]),
        (6, [0, 1, 2, 3], [[0, 1, 2], [0, 2, 3]]),
        (0, [0, 1, 2, 3], []),
    ],
)
def test_primitives(mode: int, order: list[int], expected: list[list[int]], tmp_path: Path) -> None:
    def changes(record: dict[str, Any]) -> None:
        record["meshes"][0]["primitives"][0]["mode"] = mode
        record["accessors"][1]["count"] = len(order)

    vertices, corners = read(tmp_path, scene(changes), POSITIONS + np.array(order, "<u2").tobytes())
    assert len(vertices) == 4
    np.testing.assert_array_equal(corners.reshape(-1, 3, 3), VERTICES[np.array(expected, int).reshape(-1, 3)])


def test_without_indices(tmp_path: Path) -> None:
    def changes(record: dict[str, Any]) -> None:
        record["accessors"][0]["count"] = 12
        record["meshes"][0]["primitives"] = [{"attributes": {"POSITION": 0}}]

    _, corners = read(tmp_path, scene(changes), VERTICES[FACES].astype("<f4").tobytes())
    np.testing.assert_array_equal(corners, VERTICES[FACES])


def test_lines_beside_faces_are_passed_over(tmp_path: Path) -> None:
    line = {"attributes": {"POSITION": 0}, "mode": 1}
    vertices, _ = read(tmp_path, scene(lambda r: r["meshes"][0]["primitives"].append(line)))
    assert len(vertices) == 4


def test_strided_and_normalised_numbers(tmp_path: Path) -> None:
    """Positions as 16-bit fractions of 2, a stride of eight bytes."""
    rows = np.zeros((4, 4), "<i2")
    rows[:, :3] = np.round(VERTICES / 2 * 32767)

    def changes(record: dict[str, Any]) -> None:
        record["extensionsRequired"] = ["KHR_mesh_quantization"]
        record["bufferViews"][0].update(byteStride=8, byteLength=32)
        record["bufferViews"][1].update(byteOffset=32)
        record["accessors"][0].update(componentType=5122, normalized=True)

    np.testing.assert_allclose(read(tmp_path, scene(changes), rows.tobytes() + INDICES)[0], VERTICES / 2, atol=2e-5)


@pytest.mark.parametrize("based", [True, False])
def test_sparse_accessors(based: bool, tmp_path: Path) -> None:
    def changes(record: dict[str, Any]) -> None:
        record["bufferViews"] += [{"buffer": 0, "byteOffset": 72}, {"buffer": 0, "byteOffset": 76}]
        indices, values = {"bufferView": 2, "componentType": 5123}, {"bufferView": 3}
        record["accessors"][0]["sparse"] = {"count": 2, "indices": indices, "values": values}
        if not based:
            del record["accessors"][0]["bufferView"]

    new = np.array([[7, 8, 9], [4, 5, 6]], "<f4")
    vertices, _ = read(tmp_path, scene(changes), POSITIONS + INDICES + struct.pack("<HH", 3, 1) + new.tobytes())
    np.testing.assert_array_equal(vertices[[3, 1]], new)
    np.testing.assert_array_equal(vertices[[0, 2]], VERTICES[[0, 2]] if based else np.zeros((2, 3)))


def test_skins_in_the_pose_of_the_file(tmp_path: Path) -> None:
    """Vertices follow their joints, by weight; the place of the skinned node doesn't count."""
    joints = np.array([[0, 1, 0, 0]] * 4, "u1")
    weights = np.array([[1, 0, 0, 0], [0, 2, 0, 0], [0.5, 0.5, 0, 0], [1, 0, 0, 0]], "<f4")
    inverse = np.stack([np.eye(4), np.eye(4)])
    inverse[1, :3, 3] = [0, 0, -1]  # bound where the second joint stood 1 in front

    def changes(record: dict[str, Any]) -> None:
        record["nodes"] = [
            {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
            {"children": [2], "translation": [0, 10, 0]},
            {"translation": [1, 0, 0]},
        ]
        record["scenes"][0]["nodes"] = [0, 1]
        record["skins"] = [{"joints": [1, 2], "inverseBindMatrices": 4}]
        record["meshes"][0]["primitives"][0]["attributes"].update(JOINTS_0=2, WEIGHTS_0=3)
        record["bufferViews"] += [{"buffer": 0, "byteOffset": offset} for offset in (72, 88, 152)]
        for view, kind, count, shape in ((2, 5121, 4, "VEC4"), (3, 5126, 4, "VEC4"), (4, 5126, 2, "MAT4")):
            record["accessors"].append({"bufferView": view, "componentType": kind, "count": count, "type": shape})

    tail = joints.tobytes() + weights.tobytes() + inverse.transpose(0, 2, 1).astype("<f4").tobytes()
    vertices, _ = read(tmp_path, scene(changes), POSITIONS + INDICES + tail)
    first, second = VERTICES + [0, 10, 0], VERTICES + [1, 10, -1]
    np.testing.assert_allclose(vertices, [first[0], second[1], (first[2] + second[2]) / 2, first[3]], atol=1e-12)


def test_points_alone_are_a_cloud(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(400, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)

    def changes(record: dict[str, Any]) -> None:
        record["accessors"][0]["count"] = 400
        record["meshes"][0]["primitives"] = [{"attributes": {"POSITION": 0}, "mode": 0}]

    read(tmp_path, scene(changes), points.astype("<f4").tobytes())
    assert "reconstructed" in load_mesh(tmp_path / "a.gltf").notes[0]


UNREADABLE: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "another version": (lambda r: r["asset"].update(version="1.0"), "glTF 1.0, where 2.0 is read"),
    "compressed": (
        lambda r: r.update(extensionsRequired=["KHR_draco_mesh_compression"]),
        "KHR_draco_mesh_compression, which isn't read",
    ),
    "instances": (lambda r: r.update(extensionsUsed=["EXT_mesh_gpu_instancing"]), "gpu_instancing, which isn't read"),
    "no buffer": (lambda r: r["buffers"][0].update(uri="b.bin"), r"its buffer 'b.bin' can't be read \(No such file"),
    "a buffer elsewhere": (lambda r: r["buffers"][0].update(uri="../a.bin"), "no file in the folder of the mesh"),
    "no file": (lambda r: r["buffers"][0].update(uri="/dev/zero"), "no file in the folder of the mesh"),
    "rows on rows": (lambda r: r["bufferViews"][0].update(byteStride=0), "the data end after 72 bytes"),
    "short": (lambda r: r["accessors"][1].update(count=13), "the data end after 72 bytes"),
    "huge": (lambda r: r["accessors"][0].update(count=10**12), "the data end after 72 bytes"),
    "less than nothing": (lambda r: r["accessors"][0].update(count=-1), "the data end after 72 bytes"),
    "no such vertex": (lambda r: r["accessors"][0].update(count=3), "faces use vertices 0..3, the mesh has 3"),
    "a circle of nodes": (lambda r: r["nodes"][0].update(children=[0]), "node 0 has two places"),
    "no accessor": (lambda r: r["accessors"].pop(), r"damaged \(IndexError"),
    "no type": (lambda r: r["accessors"][0].update(type="VEC9"), r"damaged \(KeyError: 'VEC9'"),
    "no version": (lambda r: r.pop("asset"), r"damaged \(KeyError: 'asset'"),
    "no mesh": (lambda r: r["nodes"][0].pop("mesh"), "no vertices"),
}


@pytest.mark.parametrize("name", UNREADABLE)
def test_what_cant_be_read_is_one_clear_line(name: str, tmp_path: Path) -> None:
    changes, message = UNREADABLE[name]
    (tmp_path / "a.bin").write_bytes(POSITIONS + INDICES)
    (tmp_path / "a.gltf").write_text(json.dumps(scene(changes)), encoding="utf-8")
    with pytest.raises(MeshError, match=message):
        load_mesh(tmp_path / "a.gltf")


@pytest.mark.parametrize("content", [b"", b"glTF", b"glTF\2\0\0\0", as_glb({}, b"")[:-3], b"glTF" + bytes(40)])
def test_damaged_containers(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.glb").write_bytes(content)
    with pytest.raises(MeshError, match=r"not readable as .glb"):
        load_mesh(tmp_path / "a.glb")
