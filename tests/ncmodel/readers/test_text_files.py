"""Text as exporters and people write it: backslashes, scripts, line ends, exponents, headers and commas."""

from pathlib import Path

import numpy as np
import pytest

from ncmodel.errors import MeshError
from ncmodel.mesh.load import load_mesh, read_geometry
from tests.helpers.mesh_files import as_binary_ply, as_obj, as_ply, tetrahedron

VERTICES, FACES = tetrahedron()
OBJ, PLY, BINARY = as_obj(VERTICES, FACES), as_ply(VERTICES, FACES), as_binary_ply(VERTICES, FACES)
HEADER_END = BINARY.index(b"end_header\n") + len(b"end_header\n")


def with_more(*names: bytes) -> bytes:
    """A binary PLY file with more properties of every vertex, all nines."""
    more = b"".join(b"property double %s\n" % name for name in names)
    head = BINARY[:HEADER_END].replace(b"property double z\n", b"property double z\n" + more)
    rows = np.concatenate([VERTICES, np.full((4, len(names)), 9.0)], axis=1)
    return head + rows.astype("<f8").tobytes() + BINARY[HEADER_END + VERTICES.nbytes :]


FILES: dict[str, bytes] = {
    "comment.obj": b"# from C:\\models\\\n" + OBJ,
    "comment crlf.obj": (b"# from C:\\models\\\n" + OBJ).replace(b"\n", b"\r\n"),
    "comment cr.obj": (b"# from C:\\models\\\n" + OBJ).replace(b"\n", b"\r"),
    "library.obj": b"mtllib C:\\models\\\n" + OBJ,
    "material.obj": OBJ.replace(b"\nf 1 3 2", b"\nusemtl wood\\\nf 1 3 2"),
    "group.obj": OBJ.replace(b"\nf 1 3 2", b"\ng a\\\no b\\\ns \\\nf 1 3 2"),
    "comment behind a face.obj": OBJ.replace(b"f 1 3 2\n", b"f 1 3 2 # D:\\\n"),
    "blank comment.obj": OBJ.replace(b"\nf 1 3 2", b"\n  # \\\nf 1 3 2"),
    "continued.obj": OBJ.replace(b"f 1 3 2", b"f 1 \\\n3 \\\n2").replace(b"v 2 0 0", b"v 2\\\r\n0\\\r\n0"),
    "continued, then a name.obj": OBJ.replace(b"f 1 3 2", b"f 1 \\\n3 2\nusemtl a\\"),
    "capitals.obj": OBJ.replace(b"v ", b"V ").replace(b"f ", b"F "),
    "fortran.obj": OBJ.replace(b"v 2 0 0", b"v 0.2D+01 0.D0 0d-3"),
    "fortran.ply": PLY.replace(b"2 0 0", b"2.0D0 0 0"),
    "chinese.ply": BINARY.replace(b"made for a test", "TextureFile \u5168\u8eab.png \u0085 \u2028".encode()),
    "chinese text.ply": PLY.replace(b"made for a test", "\u5168\u8eab".encode()),
    "latin.ply": BINARY.replace(b"made for a test", b"caf\xe9 \x85 \xa0 \x0b \x1c"),
    "blank of its own.ply": PLY.replace(b"made for a test", "\u3000a".encode()),
    "carriage returns.ply": PLY.replace(b"\n", b"\r"),
    "binary with carriage returns.ply": BINARY[:HEADER_END].replace(b"\n", b"\r") + BINARY[HEADER_END:],
    "both line ends.ply": BINARY[:HEADER_END].replace(b"\n", b"\r\n") + BINARY[HEADER_END:],
    "a comment on the end.ply": BINARY.replace(b"made for a test", b"before end_header"),
    "quality twice.ply": with_more(b"quality", b"quality"),
    "red three times.ply": with_more(b"red", b"nx", b"red", b"red"),
}


@pytest.mark.parametrize("name", FILES)
def test_the_same_tetrahedron(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(FILES[name])
    vertices, faces = read_geometry(tmp_path / name)
    np.testing.assert_array_equal(vertices, VERTICES)
    np.testing.assert_array_equal(faces, FACES)
    assert load_mesh(tmp_path / name).notes == ()


def test_a_line_feed_is_a_byte_after_carriage_returns(tmp_path: Path) -> None:
    """The first number's lowest byte is that of a line feed: it belongs to the number."""
    first = np.frombuffer(b"\n" + bytes(5) + b"\xf0\x3f", "<f8")[0]
    moved = VERTICES.copy()
    moved[0, 0] = first
    data = as_binary_ply(moved, FACES)
    (tmp_path / "a.ply").write_bytes(data[:HEADER_END].replace(b"\n", b"\r") + data[HEADER_END:])
    np.testing.assert_array_equal(read_geometry(tmp_path / "a.ply")[0], moved)


@pytest.mark.parametrize("text", [True, False])
def test_of_a_coordinate_twice_the_first_is_read(text: bool, tmp_path: Path) -> None:
    data = with_more(b"x")
    if text:
        rows = "\n".join(f"{x} {y} {z} 9" for x, y, z in VERTICES.tolist()) + "\n"
        faces = "\n".join(f"3 {a} {b} {c}" for a, b, c in FACES.tolist())
        head = data[: data.index(b"end_header\n") + 11].replace(b"binary_little_endian", b"ascii")
        data = head + rows.encode() + faces.encode()
    (tmp_path / "a.ply").write_bytes(data)
    np.testing.assert_array_equal(read_geometry(tmp_path / "a.ply")[0], VERTICES)
    assert load_mesh(tmp_path / "a.ply").notes == ("property 'x' is there twice: the first is read",)


def test_an_element_twice_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.ply").write_bytes(PLY.replace(b"end_header", b"element face 1\nend_header"))
    with pytest.raises(MeshError, match="element 'face' twice"):
        read_geometry(tmp_path / "a.ply")


POINTS = np.array([[1.5, 0.25, -3], [2.5, 0, 1e-3], [-7, 8, 9]])
CLOUDS: dict[str, str] = {
    "plain": "1.5 0.25 -3\n2.5 0 1e-3\n-7 8 9\n",
    "names": "X Y Z R G B\n1.5 0.25 -3 1 2 3\n2.5 0 1e-3 1 2 3\n-7 8 9 1 2 3\n",
    "names behind slashes": "//X Y Z\n1.5 0.25 -3\n2.5 0 1e-3\n-7 8 9\n",
    "other order": "id,z,y,x\n1,-3,0.25,1.5\n2,1e-3,0,2.5\n3,9,8,-7\n",
    "count": "3\n1.5 0.25 -3\n2.5 0 1e-3\n-7 8 9\n",
    "count and remark": "3\na scan of 2020\n1.5 0.25 -3\n2.5 0 1e-3\n-7 8 9\n",
    "names and count": "x y z\r\n3\r\n1.5 0.25 -3\r\n2.5 0 1e-3\r\n-7 8 9\r\n",
    "commas": "1.5,0.25,-3\n2.5,0,1e-3\n-7,8,9\n",
    "commas and blanks": "1.5, 0.25, -3\n2.5, 0, 1e-3\n-7, 8, 9",
    "semicolons": '"x";"y";"z"\n1.5;0.25;-3\n2.5;0;1e-3\n-7;8;9\n',
    "decimal commas": "1,5 0,25 -3\n2,5 0 1e-3\n-7 8 9\n",
    "decimal commas and semicolons": "1,5;0,25;-3\n2,5;0;1e-3\n-7;8;9\n",
    "remarks": "# a cloud\n1.5 0.25 -3 # first\n2.5 0 1e-3\n\n-7 8 9\n",
}


@pytest.mark.parametrize("name", CLOUDS)
def test_points_of_any_table(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_text(CLOUDS[name], newline="")
    np.testing.assert_array_equal(read_geometry(tmp_path / "a.xyz")[0], POINTS)


def test_what_windows_wrote_for_no_number(tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_text("1 2 3\n-1.#IND 1.#QNAN0 1.#INF # none\n4 5 6\n7.5 8 9 #end\nnan -nan(ind) nan\n")
    points = read_geometry(tmp_path / "a.xyz")[0]
    np.testing.assert_array_equal(points, [[1, 2, 3], [np.nan] * 3, [4, 5, 6], [7.5, 8, 9], [np.nan] * 3])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("4\n1 2 3\n4 5 6\n", "2 of 4 points are there"),
        ("3\nwater\nO 0 0 0\nH 1 0 0\nH 0 1 0\n", "'O' among the numbers"),
        ("x y z\n1 2 three\n", "'three' among the numbers"),
    ],
)
def test_tables_that_are_no_points(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_text(text)
    with pytest.raises(MeshError, match=message):
        read_geometry(tmp_path / "a.xyz")


def test_points_that_were_not_measured_are_left_out(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(600, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    rows = "\n".join("{} {} {}".format(*row) for row in [*points.tolist(), [np.nan] * 3, [np.inf, 0, 0]])
    header = (
        "ply\nformat ascii 1.0\nelement vertex 602\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    )
    (tmp_path / "a.ply").write_text(header + rows)
    mesh = load_mesh(tmp_path / "a.ply")
    assert mesh.notes[0] == "left out 2 points whose coordinates aren't numbers"
    assert mesh.notes[1].startswith("reconstructed")
    assert np.isfinite(mesh.vertices).all()
