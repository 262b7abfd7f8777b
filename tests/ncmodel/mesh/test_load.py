"""Reading meshes: formats, polygons, scenes, orientation, normalisation, and everything that isn't a mesh."""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from ncmodel.errors import MeshError, UsageError
from ncmodel.mesh.load import load_mesh, make_mesh, normalise
from ncmodel.mesh.reconstruct import reconstruct
from ncmodel.mesh.triangulate import triangulate
from ncmodel.mesh.weld import weld
from ncmodel.types import Floats, Ints
from tests.helpers import analytic

PLY_HEADER = (
    "ply\nformat {format} 1.0\ncomment made for a test\nelement vertex {v}\nproperty double x\nproperty double y\n"
    "property double z\nelement face {f}\nproperty list uchar int vertex_indices\nend_header\n"
)


def tetrahedron() -> tuple[Floats, Ints]:
    vertices = np.array([[0.0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1]])
    return vertices, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def as_obj(vertices: Floats, faces: Ints) -> bytes:
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return "\n".join(lines).encode()


def as_off(vertices: Floats, faces: Ints) -> bytes:
    lines = ["OFF # a comment", f"{len(vertices)} {len(faces)} 0"]
    lines += [f"{x:.17g} {y:.17g} {z:.17g}" for x, y, z in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
    return "\n".join(lines).encode()


def as_ply(vertices: Floats, faces: Ints) -> bytes:
    lines = [f"{x:.17g} {y:.17g} {z:.17g}" for x, y, z in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
    return (PLY_HEADER.format(format="ascii", v=len(vertices), f=len(faces)) + "\n".join(lines)).encode()


def as_binary_ply(vertices: Floats, faces: Ints, order: str = "<") -> bytes:
    name = "binary_little_endian" if order == "<" else "binary_big_endian"
    body = vertices.astype(order + "f8").tobytes()
    body += b"".join(struct.pack(order + "B3i", 3, *face) for face in faces)
    return PLY_HEADER.format(format=name, v=len(vertices), f=len(faces)).encode() + body


def as_big_endian_ply(vertices: Floats, faces: Ints) -> bytes:
    return as_binary_ply(vertices, faces, ">")


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


def test_scenes_are_joined_where_their_transforms_put_them(tmp_path: Path) -> None:
    """Two boxes, one mirrored and moved: both outwards, apart by what the transform says."""
    box = trimesh.creation.box((1, 1, 1))
    mirrored = np.diag([-1.0, 1, 1, 1])
    mirrored[0, 3] = 3
    scene = trimesh.Scene()
    scene.add_geometry(box)
    scene.add_geometry(box, transform=mirrored)
    scene.export(str(tmp_path / "two.glb"))
    mesh = load_mesh(tmp_path / "two.glb")
    corners = mesh.vertices[mesh.faces]
    assert len(mesh.faces) == 24
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(2 / 4**3, rel=1e-6)
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [1, 0.25, 0.25], rtol=1e-6)


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


def test_concave_polygons_keep_their_area() -> None:
    """A comb of 26 corners in a tilted plane, where a fan would cover what the polygon doesn't."""
    teeth = 6
    outline = [(0.0, 0.0), (2.0 * teeth, 0.0)]
    for n in reversed(range(teeth)):
        outline += [(2 * n + 2, 3), (2 * n + 1.5, 3), (2 * n + 1.5, 1), (2 * n + 0.5, 1)]
    flat = np.array(outline)
    area = abs(
        float(np.cross(np.pad(flat, ((0, 0), (0, 1))), np.pad(np.roll(flat, -1, 0), ((0, 0), (0, 1))))[:, 2].sum())
    )
    tilt = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    points = np.pad(flat, ((0, 0), (0, 1))) @ tilt
    faces = triangulate(points, np.arange(len(points)), np.array([len(points)]))
    corners = points[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert len(faces) == len(points) - 2
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(area, rel=1e-9)
    assert (areas @ areas[0] > 0).all()


@pytest.mark.parametrize("scale", [1e300, 1e-300])
def test_polygons_of_any_size(scale: float) -> None:
    outline = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.5, 0], [0, 2, 0], [0, 5, 0], [0.1, 2, 0], [0, 1, 0]])
    for corners, sizes in ((np.arange(5), [5]), (np.array([0, 4, 5, 6]), [4])):
        expected = triangulate(outline, corners, np.array(sizes))
        np.testing.assert_array_equal(triangulate(outline * scale, corners, np.array(sizes)), expected)


@pytest.mark.parametrize("turned", [False, True])
def test_a_polygon_of_thousands_of_corners(turned: bool) -> None:
    """A star of 5000 rays, either way round: covered once, in time."""
    angle = np.linspace(0, 2 * np.pi, 10_000, endpoint=False)
    radius = np.where(np.arange(10_000) % 2, 1.0, 0.3)
    star = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)[:: -1 if turned else 1]
    a, b, c = star[triangulate(star, np.arange(10_000), np.array([10_000]))].transpose(1, 0, 2)
    areas = np.cross(b - a, c - a)[:, 2] / 2 * (-1 if turned else 1)
    assert (areas >= 0).all()
    assert areas.sum() == pytest.approx(10_000 * 0.3 * np.sin(2 * np.pi / 10_000) / 2, rel=1e-9)


def test_polygons_that_cross_themselves_are_cut_somehow() -> None:
    bow = np.array([[0.0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.5, 1]])
    line = np.array([[float(n), 0, 0] for n in range(6)])
    for points in (bow, line, bow[[0, 0, 0, 1, 1, 2]]):
        faces = triangulate(points, np.arange(len(points)), np.array([len(points)]))
        assert len(faces) == len(points) - 2
        assert set(faces.ravel()) == set(range(len(points)))


def test_z_up_stands_upright(tmp_path: Path) -> None:
    """What points up along z in the file points up along y; the turn is a rotation."""
    vertices, faces = tetrahedron()
    vertices[3] = [0, 0, 5]
    (tmp_path / "a.obj").write_bytes(as_obj(vertices, faces))
    mesh = load_mesh(tmp_path / "a.obj", up="z")
    assert mesh.vertices[3, 1] == 0.5
    np.testing.assert_allclose(mesh.vertices[2] - mesh.vertices[0], [0, 0, -0.2], atol=1e-15)
    with pytest.raises(UsageError, match="expected y or z"):
        load_mesh(tmp_path / "a.obj", up="x")


@pytest.mark.parametrize("size", [1e-300, 1e-12, 1.0, 1e12, 1e307])
def test_any_size_is_normalised(size: float) -> None:
    vertices, faces = analytic.torus(12, 8)
    mesh = make_mesh(vertices * size, faces)
    assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(1, rel=1e-12)
    np.testing.assert_allclose(mesh.vertices, vertices, atol=1e-12)


def test_far_from_the_origin() -> None:
    """At 1e7 from the origin a unit object keeps nine digits."""
    vertices, faces = analytic.torus(12, 8)
    np.testing.assert_allclose(make_mesh(vertices + 1e7, faces).vertices, vertices, atol=2e-9)


def test_normalising_twice_changes_no_bit() -> None:
    rng = np.random.default_rng(1)
    once = normalise(rng.normal(size=(100, 3)))
    assert normalise(once) is once
    in_float32 = once.astype(np.float32).astype(np.float64)
    assert normalise(in_float32) is in_float32


def test_stray_vertices_dont_shrink_the_shape() -> None:
    vertices, faces = tetrahedron()
    mesh = make_mesh(np.concatenate([vertices, [[1e6, 0, 0]]]), faces)
    assert np.ptp(mesh.vertices[:4], axis=0).max() == 1


def test_weld_keeps_first_occurrences_in_order() -> None:
    vertices = np.array([[1.0, 0, 0], [0, 0, 0], [1, 0, 0], [-0.0, 0, 0], [2, 0, 0]])
    welded, faces = weld(vertices, np.array([[0, 1, 4], [2, 3, 4]]))
    np.testing.assert_array_equal(welded, [[1, 0, 0], [0, 0, 0], [2, 0, 0]])
    np.testing.assert_array_equal(faces, [[0, 1, 2], [0, 1, 2]])


def test_point_clouds_become_surfaces(tmp_path: Path) -> None:
    """Points of a torus: a surface of its volume, outwards, said in the notes."""
    points, _ = analytic.torus(60, 30)
    rows = "\n".join(f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in points)
    header = PLY_HEADER.format(format="ascii", v=len(points), f=0).split("element face")[0] + "end_header\n"
    (tmp_path / "cloud.ply").write_text(header + rows)
    mesh = load_mesh(tmp_path / "cloud.ply")
    corners = mesh.vertices[mesh.faces]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(2 * np.pi**2 * 0.355 * 0.145**2, rel=0.03)
    assert mesh.notes == (f"reconstructed {len(mesh.faces)} faces from points (screened Poisson)",)
    (tmp_path / "cloud.xyz").write_text("# x y z nx ny nz\n" + rows.replace("\n", " 0 0 1\n\n") + " 0 0 1 # last")
    np.testing.assert_array_equal(load_mesh(tmp_path / "cloud.xyz").vertices, mesh.vertices)
    (tmp_path / "cloud.obj").write_text("v " + rows.replace("\n", "\nv "))
    np.testing.assert_array_equal(load_mesh(tmp_path / "cloud.obj").vertices, mesh.vertices)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((100, 3)), "1 distinct points"),
        (np.linspace(0, 1, 300).reshape(-1, 1) * np.ones(3), "on a line"),
        (np.full((100, 3), np.nan), "finite"),
    ],
)
def test_points_without_a_surface(points: Floats, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        reconstruct(points)


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
    "words.xyz": (b"x y z\n", "'x' among the numbers"),
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


def test_bad_arrays() -> None:
    vertices, faces = tetrahedron()
    for wrong_vertices, wrong_faces in (
        (vertices[:, :2], faces),
        (vertices, faces[:, :2]),
        (vertices, faces[:0]),
        (vertices, faces + 1),
        (vertices, faces - 1),
        (np.concatenate([vertices * 1e-300, [[1e300, 0, 0]]]), faces),
    ):
        with pytest.raises(MeshError):
            make_mesh(wrong_vertices, wrong_faces)


def test_real_files(bundled: Path) -> None:
    """The sample meshes: textured OBJ with fewer texture than position indices, range scan, binary and text PLY."""
    for name, count in (("bunny.obj", 56172), ("bunny10k_textured.obj", None), ("bone.ply", 3022), ("cow.obj", 5804)):
        mesh = load_mesh(bundled / name)
        assert count is None or len(mesh.faces) == count
        assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(1, rel=1e-9)


def test_loose_triangles_are_welded_in_any_format(tmp_path: Path) -> None:
    vertices, faces = analytic.icosphere(1)
    rows = [f"v {x} {y} {z}" for x, y, z in vertices[faces].reshape(-1, 3).tolist()]
    rows += [f"f {3 * n + 1} {3 * n + 2} {3 * n + 3}" for n in range(len(faces))]
    (tmp_path / "loose.obj").write_text("\n".join(rows), encoding="utf-8")
    mesh = load_mesh(tmp_path / "loose.obj")
    assert len(mesh.vertices) == len(vertices)
    assert mesh.notes == (f"welded {3 * len(faces)} vertices to {len(vertices)} at equal positions",)


def test_rounding_leaves_no_cracks(tmp_path: Path) -> None:
    vertices, faces = analytic.icosphere(2)
    rng = np.random.default_rng(0)
    corners = vertices[faces].astype(np.float32)
    nudged = np.where(rng.random(corners.shape) < 0.1, np.nextafter(corners, np.float32(2.0)), corners)
    trimesh.Trimesh(nudged.reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3), process=False).export(
        tmp_path / "ball.stl"
    )
    assert len(load_mesh(tmp_path / "ball.stl").vertices) == len(vertices)
