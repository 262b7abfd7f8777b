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

_Part = tuple[Floats, bytes, str]
"""Corners (n, 3), the bytes that are left, and what is to be told, or nothing."""


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
        parts.append(corners)
        notes += [note] if note else []
    if len(parts) > 1:
        notes.append(f"{len(parts)} STL files in one: all are read")
    vertices = np.concatenate(parts)
    return Content(vertices, np.arange(len(vertices)).reshape(-1, 3), tuple(notes))


def _is_text(data: bytes) -> bool:
    # Headers of binary files may begin with "solid", too, but they or the count after them have zero bytes.
    says_so = data.lstrip()[:5].lower() == b"solid" and b"\0" not in data[:_HEADER]
    return says_so and len(data) != _length(data)


def _length(data: bytes) -> int:
    """Bytes of a binary file whose count is right."""
    return _HEADER + _RECORD.itemsize * int.from_bytes(data[80:_HEADER], "little")


def _text(data: bytes) -> _Part:
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
    if len(found) % 3:
        raise ValueError(f"{len(found)} corners, not a multiple of 3")
    ended = _END in data[-_HEADER * 4 :].lower()
    return corners.reshape(-1, 3), rest, "" if ended else "no endsolid at the end: the file may be cut off"


def _binary(data: bytes) -> _Part:
    held, over = divmod(len(data) - _HEADER, _RECORD.itemsize)
    if held < 0:
        raise ValueError(f"neither a text STL nor a binary one of {len(data)} bytes")
    count, end = int.from_bytes(data[80:_HEADER], "little"), _length(data)
    behind = data[end:]
    if 0 <= len(data) - end < _RECORD.itemsize or _is_stl(behind):
        return _corners(data, count), behind, ""
    if np.abs(_corners(data, held)).max(initial=0) <= _FARTHEST and held:
        if over == 0 and held > count:
            return _corners(data, held), b"", f"the header counts {count} faces, the file holds {held}: all are read"
        if over == 0:
            return _corners(data, held), b"", f"{held} of {count} faces that the header counts are in the file"
        if held < count:
            raise ValueError(f"cut off, {held} of {count} faces are there")
    if not 0 < count <= held:
        raise ValueError(f"neither a text STL nor a binary one of {len(data)} bytes")
    return _corners(data, count), b"", f"{len(behind)} bytes behind the last of {count} faces are passed over"


def _is_stl(data: bytes) -> bool:
    """Whether these bytes are one STL file or more."""
    while len(data) > _HEADER and not _is_text(data) and len(data) > _length(data) > _HEADER:
        data = data[_length(data) :]
    return len(data) > _HEADER and (_is_text(data) or len(data) == _length(data))


def _corners(data: bytes, count: int) -> Floats:
    """(3 count, 3); what isn't a number stays so, and is told by who uses the mesh."""
    return np.frombuffer(data, _RECORD, count, _HEADER)["corners"].reshape(-1, 3).astype(np.float64)
