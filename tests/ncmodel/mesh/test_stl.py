"""STL files with a count that is wrong, without line ends, cut off, or one behind the other."""

from pathlib import Path

import numpy as np
import pytest

from ncmodel.errors import MeshError
from ncmodel.mesh.load import load_mesh
from ncmodel.mesh.stl import read_stl
from ncmodel.types import Floats
from tests.helpers.mesh_files import tetrahedron

VERTICES, FACES = tetrahedron()
CORNERS = VERTICES[FACES]


def binary(corners: Floats = CORNERS, count: int | None = None, header: bytes = b"made for a test") -> bytes:
    records = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records["corners"] = corners
    return (
        header.ljust(80, b"\0") + (len(corners) if count is None else count).to_bytes(4, "little") + records.tobytes()
    )


def text(corners: Floats = CORNERS, name: str = "a", line: str = "\n") -> bytes:
    lines = [f"solid {name}"]
    for face in corners.tolist():
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {:e} {} {}".format(*corner) for corner in face]
        lines += ["endloop", "endfacet"]
    return line.join([*lines, f"endsolid {name}", ""]).encode()


MOVED = CORNERS + [5, 0, 0]
BOTH = np.concatenate([CORNERS, MOVED])
TWO = "2 STL files in one: all are read"
READ: dict[str, tuple[bytes, Floats, tuple[str, ...]]] = {
    "too small": (binary(count=2), CORNERS, ("the header counts 2 faces, the file holds 4: all are read",)),
    "none counted": (binary(count=0), CORNERS, ("the header counts 0 faces, the file holds 4: all are read",)),
    "not known": (binary(count=2**32 - 1), CORNERS, ("4 of 4294967295 faces that the header counts are in the file",)),
    "too large": (binary(count=6), CORNERS, ("4 of 6 faces that the header counts are in the file",)),
    "a few bytes more": (binary() + b"colours", CORNERS, ()),
    "something more": (binary() + b"?" * 121, CORNERS, ("121 bytes behind the last of 4 faces are passed over",)),
    "binary twice": (binary() + binary(MOVED), BOTH, (TWO,)),
    "text twice": (text() + text(MOVED), BOTH, ()),
    "text, binary": (text() + binary(MOVED), BOTH, (TWO,)),
    "binary, text": (binary() + text(MOVED), BOTH, (TWO,)),
    "three": (
        binary() + binary(MOVED) + binary(CORNERS),
        np.concatenate([BOTH, CORNERS]),
        ("3 STL files in one: all are read",),
    ),
    "one line": (text(line=" "), CORNERS, ()),
    "one line, capitals": (text(line=" ").upper(), CORNERS, ()),
    "one line, a name with words of the format": (text(name="my vertex 1", line=" "), CORNERS, ()),
    "two solids in one line": (text(line=" ") + text(MOVED, line=" "), BOTH, ()),
    "tabs": (text(line="\t"), CORNERS, ()),
    "carriage returns": (text(line="\r"), CORNERS, ()),
    "names of several words": (text(name="a facet vertex endsolid"), CORNERS, ()),
    "no end": (text()[: text().index(b"endsolid")], CORNERS, ("no endsolid at the end: the file may be cut off",)),
}


@pytest.mark.parametrize("name", READ)
def test_every_face_is_read_and_what_was_odd_is_told(name: str, tmp_path: Path) -> None:
    data, corners, notes = READ[name]
    content = read_stl(data)
    np.testing.assert_allclose(content.vertices, corners.reshape(-1, 3))
    assert content.faces.tolist() == np.arange(3 * len(corners)).reshape(-1, 3).tolist()
    assert content.notes == notes
    (tmp_path / "a.stl").write_bytes(data)
    assert load_mesh(tmp_path / "a.stl").notes[: len(notes)] == notes


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (binary()[:-70], "not readable as .stl: cut off, 2 of 4 faces are there; expected"),
        (binary()[:-1], "cut off, 3 of 4 faces"),
        (binary()[:100], "neither a text STL nor a binary one of 100 bytes"),
        (text()[: text().index(b"endloop") - 20], "2 corners, not a multiple of 3, and no endsolid at the end: the file is cut off"),
        (text()[:-80] + b"\0\1\2", "something else"),
        (text().replace(b" 1.0 ", b" two "), "'two' among the numbers"),
    ],
)
def test_files_that_break_off(data: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_bytes(data)
    with pytest.raises(MeshError, match=message):
        load_mesh(tmp_path / "a.stl")
