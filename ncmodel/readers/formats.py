"""Mesh files -> vertices and triangles, as they are in the file.

They are read by the project itself, but for CAD. trimesh, which reads all of these formats, moves quads behind
triangles, fans out polygons that aren't convex, gives a vertex for each of its textures, takes all meshes of another
part of a 3MF package for each component, leaves out COLLADA's strips and upward axis, and takes some files that break
off for empty ones (`tests/ncmodel/readers/test_trimesh.py` has examples); and a drawing shouldn't wait for it to load.
"""

import re
from codecs import BOM_UTF8
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ncmodel.readers import cad
from ncmodel.readers.collada import read_collada
from ncmodel.readers.content import Content, check_kind
from ncmodel.readers.gltf import read_gltf
from ncmodel.readers.numbers import numbers
from ncmodel.readers.obj import read_obj
from ncmodel.readers.ply import read_ply
from ncmodel.readers.stl import read_stl
from ncmodel.readers.threemf import read_3mf
from ncmodel.readers.triangulate import triangulate

_HEADER_LINES = 2
"""Of points: how many there are, and the names of the columns or a remark."""


def read_mesh(path: Path) -> Content:
    """What a file holds whose suffix is one of `SUFFIXES`.

    Raises:
        NotAMeshError: The file is something else, or holds no surface and no points of one.
        ValueError: The file isn't what its suffix says; the text says why.
        OSError: The file can't be read.
    """
    suffix = path.suffix.lower()
    # No format starts with a mark of its encoding, but editors put one there.
    data = path.read_bytes().removeprefix(BOM_UTF8)
    check_kind(data, suffix)
    reader = _READERS.get(suffix)
    return reader(data) if reader else _SCENE_READERS[suffix](path, data)


def _off(data: bytes) -> Content:
    lines = [line for line in re.sub(rb"#[^\r\n]*", b"", data).splitlines() if line.strip()]
    # The keyword may be absent, and the counts may follow it without a space, as in ModelNet's files.
    header = re.match(rb"\s*(?:(?:ST)?C?N?OFF(?![A-Z])|(?=\d))", lines[0]) if lines else None
    if header is None:
        raise ValueError("no OFF header")
    lines[0] = lines[0][header.end() :]
    counts, *lines = [line for line in lines if line.strip()] or [b""]
    if not re.match(rb"\s*\d+\s+\d+(?:\s|$)", counts):
        raise ValueError(f"{counts[:40].decode('utf-8', 'replace')!r} for counts of vertices and faces")
    vertex_count, face_count = (int(count) for count in counts.split()[:2])
    if (behind := len(lines) - vertex_count - face_count) < 0:
        raise ValueError(f"{len(lines)} lines for {vertex_count} vertices and {face_count} faces")
    width = len(lines[0].split()) if vertex_count else 3
    vertices = numbers(b" ".join(lines[:vertex_count]))
    if len(vertices) != vertex_count * width or width < 3:
        raise ValueError(f"{len(vertices)} coordinates for {vertex_count} vertices")
    vertices = vertices.reshape(-1, width)[:, :3].copy()
    words = [line.split() for line in lines[vertex_count : vertex_count + face_count]]
    polygons = [[int(word) for word in row[1 : 1 + int(row[0])]] for row in words]
    sizes = np.array([int(row[0]) for row in words], dtype=np.int64)
    corners = np.array([corner for polygon in polygons for corner in polygon], dtype=np.int64)
    if sizes.sum() != len(corners):
        raise ValueError("a face with fewer corners than it says")
    notes = (f"{behind} lines behind the last of {face_count} faces are passed over",) if behind else ()
    return Content(vertices, triangulate(vertices, corners, sizes), notes)


def _xyz(data: bytes) -> Content:
    """Points alone, one a line: what follows their coordinates is passed over."""
    # "-1.#IND" is no remark, but how Windows wrote what is no number.
    lines = [line for line in re.sub(rb"(?<!\d\.)#[^\r\n]*", b"", data).splitlines() if line.strip()]
    counted, names = None, b""
    for _ in range(_HEADER_LINES):
        if lines and re.fullmatch(rb"\s*\d+\s*", lines[0]):
            counted = int(lines.pop(0))
        elif lines and not _begins_with_number(lines[0]):
            names = lines.pop(0)
    if counted not in (None, len(lines)):
        raise ValueError(f"{len(lines)} of {counted} points are there")
    text = _with_blanks(b"\n".join(lines), lines[0] if lines else b"")
    width = len(text.split(b"\n", 1)[0].split()) if lines else 3
    points = numbers(text)
    if width < 3 or len(points) != width * len(lines):
        raise ValueError(f"{len(points)} numbers in {len(lines)} lines, the first of {width}")
    columns = re.findall(rb"[^\s,;/\"']+", names.lower())
    named = len(columns) == width and {b"x", b"y", b"z"} <= set(columns)
    places = [columns.index(axis) for axis in (b"x", b"y", b"z")] if named else [0, 1, 2]
    return Content(points.reshape(-1, width)[:, places], np.zeros((0, 3), dtype=np.int64))


def _begins_with_number(line: bytes) -> bool:
    return re.match(rb"\s*[-+]?(?:\.?\d|nan\b|inf)", line, re.IGNORECASE) is not None


def _with_blanks(text: bytes, first: bytes) -> bytes:
    """Numbers with blanks between them, and points in them, where a table has commas for either."""
    if b";" in first:
        return text.replace(b",", b".").replace(b";", b" ")
    # "1,5 2,5 3,5" are three numbers; "1, 2, 3" and "1,2,3" have commas between them.
    inside = re.search(rb"\d,\d", first) and not re.search(rb",\s|,\S*,", first) and len(first.split()) >= 3
    return text.replace(b",", b"." if inside else b" ")


_READERS: dict[str, Callable[[bytes], Content]] = {
    ".obj": read_obj,
    ".ply": read_ply,
    ".stl": read_stl,
    ".off": _off,
    ".xyz": _xyz,
    ".3mf": read_3mf,
    ".dae": read_collada,
}
_SCENE_READERS: dict[str, Callable[[Path, bytes], Content]] = {
    ".gltf": read_gltf,
    ".glb": read_gltf,
    **dict.fromkeys(cad.SUFFIXES, cad.read_cad),
}
"""Those that need the file's name, too."""

Y_UP_SUFFIXES = (".gltf", ".glb", ".3mf", ".dae")
"""Formats that say which axis is up, by definition or in the file."""
SUFFIXES = (*_READERS, *_SCENE_READERS)
"""The file formats read."""
