"""Mesh files as programs really write them: legal or common, and unlike what the format's examples show."""

import contextlib
from pathlib import Path

import numpy as np
import pytest

from ncmodel.errors import MeshError
from ncmodel.mesh.load import load_mesh, make_mesh, read_geometry
from tests.helpers.gltf_files import INDICES, POSITIONS, as_glb, scene
from tests.helpers.mesh_files import as_big_endian_ply, as_binary_ply, as_obj, as_off, as_ply, tetrahedron

BOM = b"\xef\xbb\xbf"
VERTICES, FACES = tetrahedron()
CORNERS = VERTICES[FACES]
OBJ_LINES = as_obj(VERTICES, FACES).split(b"\n")


def binary_stl(header: bytes) -> bytes:
    records = np.zeros(4, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records["corners"] = CORNERS
    return header.ljust(80, b" ") + (4).to_bytes(4, "little") + records.tobytes()


def text_stl(name: str) -> str:
    text = f"solid {name}\n"
    for corners in CORNERS.tolist():
        text += "facet normal 0 0 0\n  outer loop\n"
        text += "".join("    vertex {} {} {}\n".format(*corner) for corner in corners)
        text += "  endloop\nendfacet\n"
    return text + f"endsolid {name}\n"


def off_with(header: str, per_vertex: str = "", per_face: str = "") -> str:
    rows = [f"{x} {y} {z}{per_vertex}" for x, y, z in VERTICES.tolist()]
    rows += [f"3 {a} {b} {c}{per_face}" for a, b, c in FACES.tolist()]
    return header + "\n".join(rows)


FILES: dict[str, bytes | str] = {
    "encoding mark.obj": BOM + as_obj(VERTICES, FACES),
    "encoding mark.ply": BOM + as_ply(VERTICES, FACES),
    "encoding mark.off": BOM + as_off(VERTICES, FACES),
    "encoding mark.stl": BOM + text_stl("a").encode(),
    "line ends.obj": as_obj(VERTICES, FACES).replace(b"\n", b"\r\n"),
    "old line ends.obj": as_obj(VERTICES, FACES).replace(b"\n", b"\r"),
    "faces first.obj": b"\n".join(OBJ_LINES[4:] + OBJ_LINES[:4]),
    "NAME.OBJ": as_obj(VERTICES, FACES),
    "ünï code 日本.obj": as_obj(VERTICES, FACES),
    "binary that says solid.stl": binary_stl(b"solid facet normal"),
    "more after it.stl": binary_stl(b"solid facet normal") + b"colours",
    "capitals.stl": text_stl("A").upper(),
    "named vertex.stl": text_stl("a vertex b"),
    "two solids.stl": text_stl("a").replace("endsolid a\n", "endsolid a\nsolid b\n") + "endsolid b\n",
    "counts beside.off": off_with("OFF 4 4 0\n"),
    "counts glued.off": off_with("OFF4 4 0\n"),
    "no keyword.off": off_with("4 4 0\n"),
    "no edges.off": off_with("OFF\n\n# counts\n4 4 # two\n\n"),
    "colours.off": off_with("COFF\n4 4 0\n", " 255 0 0 255", " 0.5 0.5 0.5"),
    "normals.off": off_with("NOFF\n4 4 0\n", " 0 0 1"),
    "line ends.off": off_with("OFF\r\n4 4 0\r\n").replace("\n", "\r\n"),
}


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_any_dialect_is_the_same_tetrahedron(name: str, tmp_path: Path) -> None:
    content = FILES[name]
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    mesh = load_mesh(tmp_path / name)
    assert mesh.name == Path(name).stem
    np.testing.assert_allclose(mesh.vertices[mesh.faces], (CORNERS - [1, 0.5, 0.5]) / 2, atol=1e-7)


def embedded() -> bytes:
    return as_glb(scene(lambda record: record["buffers"][0].pop("uri")), POSITIONS + INDICES)


BINARY_PLY, OFF = as_binary_ply(VERTICES, FACES), as_off(VERTICES, FACES)


@pytest.mark.parametrize(
    ("suffix", "content", "behind", "note"),
    [
        (".ply", BINARY_PLY, BINARY_PLY, f"{len(BINARY_PLY)} bytes behind what the header counts are passed over"),
        (".ply", as_ply(VERTICES, FACES), b"\n7 8\n", "2 numbers behind what the header counts are passed over"),
        (".ply", BINARY_PLY, b"\r\n\0\x1a", None),
        (".off", OFF + b"\n", OFF, "10 lines behind the last of 4 faces are passed over"),
        (".glb", embedded(), embedded(), f"a second file in it, of {len(embedded())} bytes, is passed over"),
        (".glb", embedded(), bytes(8), None),
    ],
)  # fmt: skip
def test_what_lies_behind_the_data_is_told(
    suffix: str, content: bytes, behind: bytes, note: str | None, tmp_path: Path
) -> None:
    """Two files in one, as a cache that went wrong leaves them, aren't halved without a word."""
    (tmp_path / f"a{suffix}").write_bytes(content + behind)
    mesh = load_mesh(tmp_path / f"a{suffix}")
    assert len(mesh.faces) == 4
    assert [text for text in mesh.notes if "passed over" in text] == ([note] if note else [])


@pytest.mark.parametrize(
    ("suffix", "content"),
    [
        (".obj", as_obj(VERTICES, FACES)),
        (".obj", b"v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 .5 0\nv 0 2 0\nf 1 2 3 4 5\nf -1/1/1 -2//2 \\\n 3 2\n"),
        (".ply", as_ply(VERTICES, FACES)),
        (".ply", as_binary_ply(VERTICES, FACES)),
        (".ply", as_big_endian_ply(VERTICES, FACES)),
        (".off", as_off(VERTICES, FACES)),
        (".stl", text_stl("a").encode()),
        (".stl", binary_stl(b"solid")),
        (".glb", embedded()),
        (".xyz", b"0 0 0\n1 2 3\n"),
    ],
)
def test_damaged_files_are_read_or_refused(suffix: str, content: bytes, tmp_path: Path) -> None:
    """Bytes changed, cut out, put in, the end missing: a mesh or bad input, mostly both, and never anything else."""
    rng = np.random.default_rng(len(content))
    strange = [b"-1", b" nan ", b" 1e999 ", b"\0\0", b" 99999999999999999999 ", b"\n", b"null", b"{}", b"f ", b"\\"]
    path, read = tmp_path / f"damaged{suffix}", 0
    for _ in range(300):
        data = content
        for _ in range(rng.integers(1, 4)):
            at, length = int(rng.integers(len(data) + 1)), int(rng.integers(1, 20))
            put = [b"", strange[rng.integers(len(strange))], rng.bytes(1), data[at : at + 2 * length]][rng.integers(4)]
            data = data[:at] + put + (data[at + length :] if rng.random() < 0.9 else b"")
        path.write_bytes(data)
        with contextlib.suppress(MeshError):
            mesh = make_mesh(*read_geometry(path))
            assert np.isfinite(mesh.vertices).all()
            read += 1
    assert read < 300
    assert read > 0 or suffix == ".xyz", "only two points make no surface, however they are read"
