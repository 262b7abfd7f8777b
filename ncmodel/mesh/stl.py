"""STL, text and binary, several files in one: loose triangles."""

import re

import numpy as np

from ncmodel.mesh.content import Content
from ncmodel.mesh.numbers import numbers
from ncmodel.types import Floats

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84
"""Bytes before the first face of a binary file: 80 of anything, and the number of faces."""
_FARTHEST = 1e12
"""Larger numbers, where the header's count doesn't fit, are no coordinates: the file is something else."""
_NAME = re.compile(rb"\b(?:end)?solid\b[^\r\n]*?(?=\bfacet\s+normal\b|[\r\n]|\Z)", re.IGNORECASE)
"""What stands behind `solid` is a name, of any words; in a file of one line it ends at the first face."""
_VERTEX = re.compile(rb"\bvertex\s+(\S+\s+\S+\s+\S+)", re.IGNORECASE)
_END = rb"endsolid"

_SOLID = re.compile(rb"\s*solid", re.IGNORECASE)

_Parts = tuple[list[Floats], bytes, str]
"""Corners (n, 3) of each file, the bytes that are left, and what is to be told, or nothing."""


def read_stl(data: bytes) -> Content:
    """Three vertices a face, of all the files that were written one behind the other.

    Raises:
        ValueError: It is neither text nor binary STL, or breaks off inside a face.
    """
    parts: list[Floats] = []
    notes: list[str] = []
    rest = data
    while not parts or len(rest) >= _HEADER:
        corners, rest, note = _text(rest) if _is_text(rest) else _binary(rest)
        parts += corners
        notes += [note] if note else []
    if len(parts) > 1:
        notes.append(f"{len(parts)} STL files in one: all are read")
    vertices = np.concatenate(parts)
    return Content(vertices, np.arange(len(vertices)).reshape(-1, 3), tuple(notes))


def _is_text(data: bytes, start: int = 0) -> bool:
    # Headers of binary files may begin with "solid", too, but they or the count after them have zero bytes.
    says_so = _SOLID.match(data, start) is not None and b"\0" not in data[start : start + _HEADER]
    return says_so and len(data) != _end(data, start)


def _count(data: bytes, start: int = 0) -> int:
    """Faces that the header of a binary file counts."""
    return int.from_bytes(data[start + 80 : start + _HEADER], "little")


def _end(data: bytes, start: int = 0) -> int:
    """Where a binary file ends whose count is right."""
    return start + _HEADER + _RECORD.itemsize * _count(data, start)


def _text(data: bytes) -> _Parts:
    rest = b""
    if (zero := data.find(b"\0")) >= 0:
        # A binary file behind a text one: its header may have letters before the first zero.
        last = data[:zero].lower().rfind(_END)
        end = re.compile(rb"[\r\n]+").search(data, last, zero) if last >= 0 else None
        if end is None:
            raise ValueError(f"text up to byte {zero}, then something else")
        data, rest = data[: end.end()], data[end.end() :]
    body = _NAME.sub(b"", data)
    found = _VERTEX.findall(body)
    corners = numbers(b" ".join(found))
    if len(corners) != 3 * len(found):
        raise ValueError(f"{len(corners)} coordinates for {len(found)} vertices")
    ended = _END in data[-_HEADER * 4 :].lower()
    if len(found) % 3:
        cut = "" if ended else ", and no endsolid at the end: the file is cut off"
        raise ValueError(f"{len(found)} corners, not a multiple of 3{cut}")
    return [corners.reshape(-1, 3)], rest, "" if ended else "no endsolid at the end: the file may be cut off"


def _binary(data: bytes) -> _Parts:
    held, over = divmod(len(data) - _HEADER, _RECORD.itemsize)
    if held < 0:
        raise ValueError(f"neither a text STL nor a binary one of {len(data)} bytes")
    whole, behind = _whole_files(data)
    if whole:
        return whole, behind, ""
    count, end = _count(data), _end(data)
    if np.abs(_corners(data, held)).max(initial=0) <= _FARTHEST and held:
        if over == 0 and held > count:
            return [_corners(data, held)], b"", f"the header counts {count} faces, the file holds {held}: all are read"
        if over == 0:
            return [_corners(data, held)], b"", f"{held} of {count} faces that the header counts are in the file"
        if held < count:
            raise ValueError(f"cut off, {held} of {count} faces are there")
    if not 0 < count <= held:
        raise ValueError(f"neither a text STL nor a binary one of {len(data)} bytes")
    return [_corners(data, count)], b"", f"{len(data) - end} bytes behind the last of {count} faces are passed over"


def _whole_files(data: bytes) -> tuple[list[Floats], bytes]:
    """Corners of binary files one behind the other, and what is left; none where something else is among them.

    What may be left is less than a face, behind a single file, or a file of text.
    """
    starts, end = [0], _end(data)
    while len(data) - end > _HEADER and not _is_text(data, end):
        starts.append(end)
        end = _end(data, end)
        if end == starts[-1] + _HEADER:
            return [], data
    over = len(data) - end
    fits = over == 0 or (over > _HEADER) or (len(starts) == 1 and 0 < over < _RECORD.itemsize)
    return ([_corners(data, _count(data, start), start) for start in starts], data[end:]) if fits else ([], data)


def _corners(data: bytes, count: int, start: int = 0) -> Floats:
    """(3 count, 3); what isn't a number stays so, and is told by who uses the mesh."""
    return np.frombuffer(data, _RECORD, count, start + _HEADER)["corners"].reshape(-1, 3).astype(np.float64)
