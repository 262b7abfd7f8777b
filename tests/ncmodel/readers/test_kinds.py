"""What lies under the name of a mesh file and is none: the cause is named, and no surface is made up."""

import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ncmodel.errors import MeshError
from ncmodel.mesh.load import load_mesh
from tests.helpers.gltf_files import POSITIONS, as_glb, scene
from tests.helpers.mesh_files import as_obj, tetrahedron

OBJ = as_obj(*tetrahedron())
HELIX = b"".join(b"v %f %f %f\n" % (np.cos(t), t / 9, np.sin(t)) for t in np.linspace(0, 20, 90))
POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:2d6c72fe\nsize 123456\n"
SPLAT_NAMES = [*"xyz", "f_dc_0", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]
SPLATS = (
    b"ply\nformat binary_little_endian 1.0\nelement vertex 100\n"
    + b"".join(b"property float %s\n" % name.encode() for name in SPLAT_NAMES)
    + b"end_header\n"
    + np.random.default_rng(0).normal(size=(100, len(SPLAT_NAMES))).astype("<f4").tobytes()
)
PACKED_SPLATS = (
    b"ply\nformat binary_little_endian 1.0\nelement chunk 1\nproperty float min_x\nelement vertex 1\n"
    b"property uint packed_position\nproperty uint packed_rotation\nproperty uint packed_scale\n"
    b"property uint packed_color\nend_header\n" + bytes(20)
)
EDGES = (
    b"ply\nformat ascii 1.0\nelement vertex 90\nproperty float x\nproperty float y\nproperty float z\n"
    b"element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n" + HELIX.replace(b"v ", b"") + b"0 1\n"
)


def primitive(**changes: Any) -> bytes:
    def change(record: dict[str, Any]) -> None:
        record["buffers"][0].pop("uri")
        record["meshes"][0]["primitives"] = [{"attributes": {"POSITION": 0}, **changes}]

    return as_glb(scene(change), POSITIONS)


KINDS: dict[str, tuple[bytes, str]] = {
    "pointer.obj": (POINTER, "a Git LFS pointer in place of the file"),
    "pointer.glb": (POINTER, "a Git LFS pointer"),
    "annex.stl": (b"../.git/annex/objects/Xx/9P/SHA256E-s1--ab.stl/SHA256E-s1--ab.stl", "a git-annex pointer"),
    "annexed.ply": (b"/annex/objects/SHA256E-s1--ab.ply\n", "a git-annex pointer"),
    "page.stl": (b"<!DOCTYPE html>\n<html><body>Not found</body></html>", "a web page"),
    "page.obj": (b"\n  <HTML lang='en'>\n<head>", "a web page"),
    "page.gltf": (b'<?xml version="1.0"?>\n<html xmlns="">', "a web page"),
    "error.ply": (b'<?xml version="1.0"?>\n<Error><Code>NoSuchKey</Code></Error>', "an XML document"),
    "packed.obj": (gzip.compress(OBJ), "a file packed by gzip"),
    "packed.stl": (b"PK\x03\x04" + bytes(100), "a file packed by zip"),
    "notepad.obj": (OBJ.decode().encode("utf-16"), "text in UTF-16, where UTF-8 is read"),
    "big.off": (b"OFF 1 0\n0 0 0\n".decode().encode("utf-16-be"), "text in UTF-16"),
    "little.xyz": (b"0 0 0\n1 0 0\n".decode().encode("utf-16-le"), "text in UTF-16"),
    "helix.obj": (HELIX + b"l 1 2 3 4\nl 4 5\n", "2 lines and no faces"),
    "spline.obj": (
        HELIX + b"cstype bspline\ndeg 3 3\nsurf 0 1 0 1 1 2 3\nparm u 0 1\nend\n",
        "1 surfaces and 0 curves",
    ),
    "curve.obj": (HELIX + b"cstype bspline\ndeg 3\ncurv 0 1 1 2 3 \\\n4\nend\n", "0 surfaces and 1 curves of splines"),
    "pairs.obj": (HELIX + b"f 1 2\nf 2 3\n", "2 faces of fewer than three corners"),
    "edges.ply": (EDGES, "1 lines and no faces"),
    "splat.ply": (SPLATS, "100 Gaussian splats and no faces"),
    "packed.ply": (PACKED_SPLATS, "1 Gaussian splats and no faces"),
    "lines.glb": (primitive(mode=1), "lines and no faces"),
    "loop.glb": (primitive(mode=2), "lines and no faces"),
    "splats.glb": (primitive(mode=0, extensions={"KHR_gaussian_splatting": {}}), "Gaussian splats and no faces"),
}


@pytest.mark.parametrize("name", KINDS)
def test_the_cause_is_named_in_one_line(name: str, tmp_path: Path) -> None:
    content, message = KINDS[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshError, match=rf"{name}: {message}") as caught:
        load_mesh(tmp_path / name)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith("; expected a mesh with faces")


@pytest.mark.parametrize(
    ("extra", "notes"),
    [
        (b"l 1 2\n", ()),
        (b"surf 0 1 0 1 1 2 3\n", ("1 surfaces and 0 curves of splines are passed over, only polygons are read",)),
        (b"surface\ncurves 1\nlod 3\n", ()),
    ],
)
def test_what_lies_beside_faces_is_passed_over(extra: bytes, notes: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_bytes(OBJ + b"\n" + extra)
    mesh = load_mesh(tmp_path / "a.obj")
    assert len(mesh.faces) == 4
    assert mesh.notes == notes


@pytest.mark.parametrize("header", [b"solid", b"BZ", b"<a header>"])
def test_headers_of_binary_stl_hold_anything(header: bytes, tmp_path: Path) -> None:
    record = np.zeros(4, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    record["corners"] = tetrahedron()[0][tetrahedron()[1]]
    (tmp_path / "a.stl").write_bytes(header.ljust(80, b"\0") + (4).to_bytes(4, "little") + record.tobytes())
    assert len(load_mesh(tmp_path / "a.stl").faces) == 4
