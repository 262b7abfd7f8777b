"""Wavefront OBJ: positions and polygons as they are in the file; everything else is passed over."""

import numpy as np
from numpy.typing import NDArray

from ncmodel.jit import kernel
from ncmodel.mesh.numbers import numbers
from ncmodel.mesh.triangulate import triangulate
from ncmodel.types import Floats, Ints

Bytes = NDArray[np.uint8]

_NEWLINE, _SPACE, _TAB, _RETURN, _HASH, _MINUS, _SLASH, _ZERO, _NINE = 10, 32, 9, 13, 35, 45, 47, 48, 57
_V, _F = 118, 102


def read_obj(data: bytes) -> tuple[Floats, Ints]:
    """Vertices (V, 3) and faces (F, 3).

    Raises:
        ValueError: A vertex has fewer than three coordinates, or a face a corner that isn't a vertex's number.
    """
    if b"\r" in data and b"\n" not in data:
        data = data.replace(b"\r", b"\n")  # lines as old Macintosh programs end them
    if b"\\" in data:
        data = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")  # lines that go on
    text = np.frombuffer(data + b"\n", dtype=np.uint8)
    coordinates, count, corners, sizes, wrong = _parse(text)
    if wrong:
        line = data.splitlines()[wrong - 1][:60].decode("utf-8", "replace")
        raise ValueError(f"line {wrong} is {line!r}")
    vertices = numbers(coordinates.tobytes())
    if len(vertices) != 3 * count:
        raise ValueError(f"{len(vertices)} coordinates for {count} vertices")
    return vertices.reshape(-1, 3), triangulate(vertices.reshape(-1, 3), corners, sizes)


@kernel
def _parse(text: Bytes) -> tuple[Bytes, int, Ints, Ints, int]:
    """The text of all coordinates, the number of vertices, corners and sizes of polygons, and the first wrong line."""
    # Upper bounds; memory that isn't written to costs nothing.
    coordinates = np.empty(len(text) + 1, dtype=np.uint8)
    corners = np.empty(len(text) // 2 + 1, dtype=np.int64)
    sizes = np.empty(len(text) // 2 + 1, dtype=np.int64)
    copied = vertices = used = polygons = at = 0
    line = 1
    while at < len(text):
        at = _past_blanks(text, at)
        keyword = text[at] if at + 1 < len(text) and _blank(text[at + 1]) else 0
        if keyword == _V:
            at += 1
            for _ in range(3):
                at = _past_blanks(text, at)
                start = at
                while not _ends(text[at]):
                    coordinates[copied] = text[at]
                    copied += 1
                    at += 1
                coordinates[copied] = _SPACE
                copied += 1
                if at == start:
                    return coordinates[:0], 0, corners[:0], sizes[:0], line
            vertices += 1
        elif keyword == _F:
            at = _past_blanks(text, at + 1)
            first = used
            while not _ends(text[at]):
                index, at = _integer(text, at)
                if index == 0 or not (text[at] == _SLASH or _ends(text[at])):
                    return coordinates[:0], 0, corners[:0], sizes[:0], line
                # Negative numbers count back from the last vertex so far.
                corners[used] = index - 1 if index > 0 else vertices + index
                used += 1
                while not _ends(text[at]):
                    at += 1
                at = _past_blanks(text, at)
            sizes[polygons] = used - first
            polygons += 1
        while text[at] != _NEWLINE:
            at += 1
        at += 1
        line += 1
    return coordinates[:copied], vertices, corners[:used], sizes[:polygons], 0


@kernel
def _blank(character: int) -> bool:
    return character in (_SPACE, _TAB)


@kernel
def _ends(character: int) -> bool:
    """Whether a word ends before this character."""
    return _blank(character) or character in (_NEWLINE, _RETURN, _HASH)


@kernel
def _past_blanks(text: Bytes, at: int) -> int:
    while at < len(text) - 1 and _blank(text[at]):
        at += 1
    return at


@kernel
def _integer(text: Bytes, at: int) -> tuple[int, int]:
    """The integer at a place, 0 where there is none, and where it ends."""
    negative = text[at] == _MINUS
    at += int(negative)
    value = 0
    while _ZERO <= text[at] <= _NINE and value < 10**12:
        value = 10 * value + text[at] - _ZERO
        at += 1
    return -value if negative else value, at
