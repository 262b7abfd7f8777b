"""What a mesh file holds, and what is no mesh at all whatever its name says."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ncmodel.types import Floats, Ints

Geometry = tuple[Floats, Ints]
"""(V, 3) vertices and (F, 3) faces of a part."""

_PACKED = {
    b"\x1f\x8b": "gzip",
    b"PK\x03\x04": "zip",
    b"BZh": "bzip2",
    b"\xfd7zXZ\0": "xz",
    b"\x28\xb5\x2f\xfd": "zstd",
    b"7z\xbc\xaf\x27\x1c": "7-Zip",
}
METRE = 1000.0
"""Millimetres."""
_UTF16_LETTERS = 8
"""So many letters with a zero byte before or behind each are text in UTF-16 without a mark."""


@dataclass(frozen=True)
class Content:
    """What was read of a mesh file.

    Attributes:
        vertices: (V, 3).
        faces: (F, 3); none in a point cloud.
        notes: What a user should know of the file, a sentence each.
        millimetres: In a unit of its coordinates; files that tell none, as STL and OBJ, count in millimetres.
    """

    vertices: Floats
    faces: Ints
    notes: tuple[str, ...] = ()
    millimetres: float = 1.0


class NotAMeshError(ValueError):
    """The file is sound, but no mesh and no point cloud; the text says what it is."""


def placed(part: Geometry, place: Floats) -> Geometry:
    """A part where a scene puts it; its faces stay counter-clockwise seen from outside.

    Args:
        part: Vertices and faces.
        place: (4, 4) affine, of columns.
    """
    vertices, faces = part
    mirrored = np.linalg.det(place[:3, :3]) < 0
    return vertices @ place[:3, :3].T + place[:3, 3], faces[:, ::-1] if mirrored else faces


def joined(parts: Sequence[Geometry]) -> Geometry:
    """The vertices and faces of all parts, part after part."""
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    vertices = [np.zeros((0, 3)), *(vertices for vertices, _ in parts)]
    faces = [faces + offset for (_, faces), offset in zip(parts, offsets, strict=False)]
    return np.concatenate(vertices), np.concatenate([np.zeros((0, 3), dtype=np.int64), *faces])


def check_kind(data: bytes, suffix: str = "") -> None:
    """Name what stands in place of a mesh file where a download or a checkout went wrong.

    Args:
        data: The file's bytes.
        suffix: Its suffix: COLLADA is XML, and 3MF a packed folder.

    Raises:
        NotAMeshError: The bytes are those of a pointer, a web page, an archive or UTF-16.
    """
    head = data[:512].lstrip().lower()
    if head.startswith(b"version https://git-lfs.github.com/"):
        raise NotAMeshError("a Git LFS pointer in place of the file (git lfs pull fetches it)")
    if re.match(rb"[./]*(?:\.git)?/annex/objects/", head):
        raise NotAMeshError("a git-annex pointer in place of the file (git annex get fetches it)")
    if head.startswith((b"<!doctype html", b"<html")) or (head.startswith(b"<") and b"<html" in head):
        raise NotAMeshError("a web page (HTML), as a download that failed leaves it")
    if suffix != ".dae" and head.startswith((b"<?xml", b"<!--", b"<error")):
        raise NotAMeshError("an XML document")
    for mark, packer in _PACKED.items():
        if data.startswith(mark) and not (packer == "zip" and suffix == ".3mf"):
            raise NotAMeshError(f"a file packed by {packer}, which is to be unpacked first")
    letters = rb"(?:[\t\n\r -~]\0){%d}|(?:\0[\t\n\r -~]){%d}" % (_UTF16_LETTERS, _UTF16_LETTERS)
    if data.startswith((b"\xff\xfe", b"\xfe\xff")) or re.match(letters, data):
        raise NotAMeshError("text in UTF-16, where UTF-8 is read")
