"""Mesh files -> vertices and triangles, as they are in the file.

They are read by the project itself. trimesh, which reads all of these formats, moves quads behind triangles, fans out
polygons that aren't convex, gives a vertex for each of its textures, and takes some files that break off for empty ones
(`tests/ncmodel/mesh/test_trimesh.py` has an example for each format); and a drawing shouldn't wait for it to load.
"""

import re
from codecs import BOM_UTF8
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ncmodel.mesh.gltf import read_gltf
from ncmodel.mesh.numbers import numbers
from ncmodel.mesh.obj import read_obj
from ncmodel.mesh.ply import read_ply
from ncmodel.mesh.triangulate import triangulate
from ncmodel.types import Floats, Ints

Geometry = tuple[Floats, Ints]


def read_mesh(path: Path) -> Geometry:
    """Vertices (V, 3) and faces (F, 3) of a file whose suffix is one of `SUFFIXES`.

    Raises:
        ValueError: The file isn't what its suffix says; the text says why.
        OSError: The file can't be read.
    """
    suffix = path.suffix.lower()
    # No format starts with a mark of its encoding, but editors put one there.
    return (
        read_gltf(path) if suffix in (".gltf", ".glb") else _READERS[suffix](path.read_bytes().removeprefix(BOM_UTF8))
    )


def _stl(data: bytes) -> Geometry:
    count = int.from_bytes(data[80:84], "little")
    # Headers of binary files may begin with "solid", too, but they or the count after them have zero bytes.
    text = data.lstrip()[:5].lower() == b"solid" and b"\0" not in data[:84]
    if len(data) == 84 + 50 * count or (len(data) > 84 + 50 * count and not text):
        record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        vertices = np.frombuffer(data, record, count, 84)["corners"].reshape(-1, 3).astype(np.float64)
    elif text:
        lines = re.findall(rb"(?:^|[\r\n])\s*vertex\s+([^\r\n]*)", data, re.IGNORECASE)
        vertices = numbers(b" ".join(lines))
        if len(vertices) != 3 * len(lines):
            raise ValueError(f"{len(vertices)} coordinates for {len(lines)} vertices")
        vertices = vertices.reshape(-1, 3)
    else:
        raise ValueError(f"neither a text STL nor a binary one of {len(data)} bytes")
    if len(vertices) % 3:
        raise ValueError(f"{len(vertices)} corners, not a multiple of 3")
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def _off(data: bytes) -> Geometry:
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
    if len(lines) < vertex_count + face_count:
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
    return vertices, triangulate(vertices, corners, sizes)


def _xyz(data: bytes) -> Geometry:
    """Points alone, one a line: what follows their coordinates is passed over."""
    lines = [line for line in re.sub(rb"#[^\r\n]*", b"", data).splitlines() if line.strip()]
    width = len(lines[0].split()) if lines else 3
    points = numbers(b" ".join(lines))
    if width < 3 or len(points) != width * len(lines):
        raise ValueError(f"{len(points)} numbers in {len(lines)} lines, the first of {width}")
    return points.reshape(-1, width)[:, :3].copy(), np.zeros((0, 3), dtype=np.int64)


_READERS: dict[str, Callable[[bytes], Geometry]] = {
    ".obj": read_obj,
    ".ply": read_ply,
    ".stl": _stl,
    ".off": _off,
    ".xyz": _xyz,
}

SUFFIXES = (*_READERS, ".gltf", ".glb")
"""The file formats read."""
