"""Mesh files of every format: what is read, and one clear line for what can't be."""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from ncmodel.errors import MeshError
from ncmodel.mesh.load import load_mesh, normalise
from ncmodel.types import Floats, Ints
from tests.helpers.mesh_files import PLY_HEADER, as_big_endian_ply, as_binary_ply, as_obj, as_off, as_ply, tetrahedron

INDEXED: dict[str, Callable[[Floats, Ints], bytes]] = {
    "a.obj": as_obj,
    "b.off": as_off,
    "c.ply": as_ply,
    "d.ply": as_binary_ply,
    "e.ply": as_big_endian_ply,
}


@pytest.mark.parametrize("name", INDEXED)
def test_indexed_formats_keep_every_vertex_and_face(name: str, tmp_path: Path) -> None:
    """Order, duplicates and unreferenced vertices stay; numbers are read exactly."""
    vertices, faces = tetrahedron()
    vertices = np.concatenate([vertices, vertices[:1], [[0.1, 0.2, 0.3]]])
    faces[0, 0] = 4
    (tmp_path / name).write_bytes(INDEXED[name](vertices, faces))
    mesh = load_mesh(tmp_path / name)
    np.testing.assert_array_equal(mesh.faces, faces)
    np.testing.assert_array_equal(mesh.vertices, (vertices - [1, 0.5, 0.5]) / 2)
    assert mesh.name == name[0]
    assert mesh.notes == ()


@pytest.mark.parametrize("name", ["a.stl", "b.stl", "c.glb", "d.gltf"])
def test_formats_of_loose_triangles_are_welded(name: str, tmp_path: Path) -> None:
    whole: Any = trimesh.Trimesh(*tetrahedron(), process=False)
    loose: Any = trimesh.Trimesh(whole.vertices[whole.faces].reshape(-1, 3), np.arange(12).reshape(4, 3), process=False)
    if name == "a.stl":
        (tmp_path / name).write_bytes(whole.export(file_type="stl"))
    elif name == "b.stl":
        (tmp_path / name).write_text(whole.export(file_type="stl_ascii"))
    elif name == "c.glb":
        (tmp_path / name).write_bytes(loose.export(file_type="glb"))
    else:
        for part, content in loose.export(file_type="gltf").items():
            (tmp_path / (name if part.endswith(".gltf") else part)).write_bytes(content)
    mesh = load_mesh(tmp_path / name)
    assert (len(mesh.vertices), len(mesh.faces)) == (4, 4)
    assert mesh.notes == ("welded 12 vertices to 4 at equal positions",)
    expected = normalise(tetrahedron()[0])[tetrahedron()[1]]
    np.testing.assert_allclose(mesh.vertices[mesh.faces], expected, atol=1e-7)


def test_obj_dialects(tmp_path: Path) -> None:
    """Texture and normal indices, negative ones, comments, continued lines, materials: positions and faces count."""
    text = (
        "# a comment\nmtllib missing.mtl\no thing\nv 0 0 0 1.0\n v 1 0 0\nv\t0 1 0 0.5 0.5 0.5\nvt 0 0\nvn 0 0 1\n"
        "usemtl one\nf 1/1/1 2/1/1 3/1/1 # first\ng group\ns off\nv 0 0 1\nf -4//1 -1//1 \\\n -3//1\nusemtl two\n"
        "f 1/1 3/1 4/1\r\nl 1 2\n\nf 2 4 3"
    )
    (tmp_path / "a.obj").write_bytes(text.encode())
    mesh = load_mesh(tmp_path / "a.obj")
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    np.testing.assert_array_equal(mesh.vertices * 1, np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]) - 0.5)


def test_polygons_in_every_text_format(tmp_path: Path) -> None:
    """A pentagon, a quad and a triangle: fans and diagonals, in the order of the polygons."""
    square = "0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 1 0\n3 3 0\n"
    (tmp_path / "a.off").write_text("OFF\n6 3 0\n" + square + "5 0 1 2 3 4\n4 0 1 2 4 255 0 0\n3 2 5 3\n")
    header = PLY_HEADER.format(format="ascii", v=6, f=3)
    (tmp_path / "a.ply").write_text(header + square + "5 0 1 2 3 4\n4 0 1 2 4\n3 2 5 3\n")
    vertices = "".join(f"v {line}\n" for line in square.splitlines())
    (tmp_path / "a.obj").write_text(vertices + "f 1 2 3 4 5\nf 1 2 3 5\nf 3 6 4\n")
    body = np.array([float(number) for number in square.split()]).astype("<f8").tobytes()
    body += struct.pack("<B5i", 5, 0, 1, 2, 3, 4) + struct.pack("<B4i", 4, 0, 1, 2, 4) + struct.pack("<B3i", 3, 2, 5, 3)
    binary = PLY_HEADER.format(format="binary_little_endian", v=6, f=3).encode() + body
    (tmp_path / "b.ply").write_bytes(binary)
    expected = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [1, 2, 4], [1, 4, 0], [2, 5, 3]]
    for name in ("a.off", "a.ply", "a.obj", "b.ply"):
        assert load_mesh(tmp_path / name).faces.tolist() == expected, name


STRIP_HEADER = (
    "ply\nformat {format} 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\n"
    "element tristrips 2\nproperty list int int vertex_indices\nend_header\n"
)


@pytest.mark.parametrize("binary", [False, True])
def test_triangle_strips(tmp_path: Path, binary: bool) -> None:
    """Every other triangle of a strip is turned, -1 starts anew, corners that occur twice make no triangle."""
    vertices = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [2, 0, 0], [2, 1, 0], [3, 3, 1]], dtype=np.float64)
    strips = [[0, 2, 1, 3, -1, 2, 4, 3, 5], [2, 4, 4, 6, 5]]
    if binary:
        body = vertices.astype("<f4").tobytes()
        body += b"".join(struct.pack(f"<{len(s) + 1}i", len(s), *s) for s in strips)
    else:
        lines = [" ".join(map(str, row)) for row in vertices.tolist() + [[len(s), *s] for s in strips]]
        body = "\n".join(lines).encode()
    name = "binary_little_endian" if binary else "ascii"
    (tmp_path / "strips.ply").write_bytes(STRIP_HEADER.format(format=name).encode() + body)
    mesh = load_mesh(tmp_path / "strips.ply")
    assert mesh.faces.tolist() == [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5], [4, 6, 5]]
    assert mesh.notes == ()


BAD_FILES = {
    "missing.obj": (None, "no such file"),
    "text.txt": (b"hello", "suffix is '.txt'"),
    "empty.obj": (b"", "no vertices; expected a mesh with faces"),
    "words.obj": (b"hello\nworld\n", "no vertices"),
    "points.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no faces, and 3 distinct points"),
    "index.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "faces use vertices 0..3, the mesh has 3"),
    "zero.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4 is 'f 0 1 2'"),
    "negative.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n", "faces use vertices -1..1"),
    "corner.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n", "line 4 is 'f 1 2 x'"),
    "short.obj": (b"v 0 0 0\nv 1 0\n", "line 2 is 'v 1 0'"),
    "fraction.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1.5 2 3\n", "line 4 is 'f 1.5 2 3'"),
    "letters.obj": (b"v 0 0 0\nv 1 a 0\nv 0 1 0\nf 1 2 3\n", "'a' among the numbers"),
    "commas.obj": (b"v 0 0 0\nv 1 0,5 0\nv 0 1 0\nf 1 2 3\n", "'0,5' among the numbers"),
    "nan.obj": (b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", r"vertex 1 is \[nan, 0.0, 0.0\]"),
    "huge.obj": (b"v 0 0 0\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n", r"vertex 1 is \[inf, 0.0, 0.0\]"),
    "spot.obj": (b"v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "all faces lie at one point"),
    "nan in a quad.obj": (b"v nan 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\n", r"vertex 0 is \[nan, 0.0, 0.0\]"),
    "infinite pentagon.off": (
        b"OFF 5 1\n0 0 0\n1 0 0\n2 1 0\n1 -inf 0\n0 1 0\n5 0 1 2 3 4\n",
        "vertex 3 is .1.0, -inf",
    ),
    "empty.ply": (b"", "no PLY header"),
    "format.ply": (b"ply\nformat x 1.0\nend_header\n", "header line 'format x 1.0'"),
    "formatless.ply": (b"ply\ncomment x\nend_header\n", "without a format"),
    "type.ply": (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n", "unknown type"),
    "flat.ply": (
        b"ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\nend_header\n1 2\n",
        "without x, y and z",
    ),
    "truncated.ply": (as_binary_ply(*tetrahedron())[:-3], "the data end after"),
    "cut.ply": (as_ply(*tetrahedron())[:-2], "the data end after"),
    "strips.ply": (
        STRIP_HEADER.format(format="ascii").encode() + b"0 0 0 " * 7 + b"3 0 1 7 3 0 1 2",
        "faces use vertices 0..7, the mesh has 7",
    ),
    "letters.ply": (as_ply(*tetrahedron()).replace(b"2 0 0", b"2 x 0"), "'x' among the numbers"),
    "fractions.ply": (as_ply(*tetrahedron()).replace(b"3 0 2 1", b"3 0.5 2 1"), "that aren't whole"),
    "nan.ply": (as_ply(*tetrahedron()).replace(b"3 0 2 1", b"3 nan 2 1"), "that aren't whole"),
    "empty.stl": (b"", "neither a text STL nor a binary one"),
    "noise.stl": (bytes(range(256)), "neither a text STL nor a binary one"),
    "cut.stl": (b"solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\n", "2 corners"),
    "empty.off": (b"", "no OFF header"),
    "short.off": (b"OFF\n4 4 0\n0 0 0\n", "1 lines for 4 vertices and 4 faces"),
    "counts.off": (b"OFF\nthree 1 0\n", "'three 1 0' for counts"),
    "negative.off": (b"OFF\n-3 1 0\n", "'-3 1 0' for counts"),
    "binary.off": (b"OFF BINARY\n\0\0", "' BINARY' for counts"),
    "corners.off": (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", "a face with fewer corners than it says"),
    "empty.xyz": (b"# nothing\n", "no vertices"),
    "flat.xyz": (b"1 2\n3 4\n", "4 numbers in 2 lines, the first of 2"),
    "ragged.xyz": (b"1 2 3\n4 5\n", "5 numbers in 2 lines, the first of 3"),
    "words.xyz": (b"x y z\n", "no vertices"),
    "noise.glb": (b"glTF and then nothing", "not readable as .glb"),
    "empty.gltf": (b"{}", "damaged"),
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_bad_files_are_one_clear_line(name: str, tmp_path: Path) -> None:
    content, message = BAD_FILES[name]
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshError, match=message) as caught:
        load_mesh(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_folder_is_no_mesh(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="a folder; expected a mesh file"):
        load_mesh(tmp_path)


def test_a_damaged_gltf_is_not_taken_for_its_neighbour(tmp_path: Path) -> None:
    for name, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(trimesh.creation.box())).items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "cut.gltf").write_bytes((tmp_path / "model.gltf").read_bytes()[:200])
    assert len(load_mesh(tmp_path / "model.gltf").faces) == 12
    with pytest.raises(MeshError, match=r"not readable as .gltf"):
        load_mesh(tmp_path / "cut.gltf")
