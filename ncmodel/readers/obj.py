"""Wavefront OBJ: positions and polygons as they are in the file; everything else is passed over."""

import re

import numpy as np
from numpy.typing import NDArray

from ncmodel.jit import kernel
from ncmodel.readers.content import Content, NotAMeshError
from ncmodel.readers.numbers import numbers
from ncmodel.readers.triangulate import triangulate
from ncmodel.types import Ints

Bytes = NDArray[np.uint8]

_NEWLINE, _SPACE, _TAB, _RETURN, _HASH, _MINUS, _SLASH, _ZERO, _NINE = 10, 32, 9, 13, 35, 45, 47, 48, 57
_SMALL = 32
"""What makes a capital letter small."""
_V, _F, _L = 118, 102, 108
_SURF = np.frombuffer(b"surf", dtype=np.uint8)
_CURV = np.frombuffer(b"curv", dtype=np.uint8)


def read_obj(data: bytes) -> Content:
    """Vertices and faces.

    Raises:
        NotAMeshError: It holds lines, or surfaces and curves of splines, and no polygon.
        ValueError: A vertex has fewer than three coordinates, or a face a corner that isn't a vertex's number.
    """
    if b"\r" in data and b"\n" not in data:
        data = data.replace(b"\r", b"\n")  # lines as old Macintosh programs end them
    data = _joined(data)
    text = np.frombuffer(data + b"\n", dtype=np.uint8)
    coordinates, count, corners, sizes, others, wrong = _parse(text)
    if wrong:
        line = data.splitlines()[wrong - 1][:60].decode("utf-8", "replace")
        raise ValueError(f"line {wrong} is {line!r}")
    vertices = numbers(coordinates.tobytes())
    if len(vertices) != 3 * count:
        raise ValueError(f"{len(vertices)} coordinates for {count} vertices")
    lines, surfaces, curves = (int(number) for number in others)
    splines = f"{surfaces} surfaces and {curves} curves of splines"
    if len(sizes) == 0 and surfaces + curves > 0:
        raise NotAMeshError(f"{splines} and no polygons: they are to be made polygons where they come from")
    if len(sizes) == 0 and lines > 0:
        raise NotAMeshError(f"{lines} lines and no faces")
    notes = (f"{splines} are passed over, only polygons are read",) if surfaces > 0 else ()
    return Content(vertices.reshape(-1, 3), triangulate(vertices.reshape(-1, 3), corners, sizes), notes)


def _joined(data: bytes) -> bytes:
    """Vertices and faces that a backslash continues on the next line, in one line.

    In a comment or a name, such as that of a folder, a backslash is a letter like any other.
    """
    parts, done, continued = [], 0, 0
    for mark in re.finditer(rb"\\\r?\n", data):
        start = data.rfind(b"\n", 0, mark.start()) + 1
        line = data[start : mark.start()]
        goes_on = start == continued > 0 or re.match(rb"\s*[vf]\s", line, re.IGNORECASE)
        if goes_on and b"#" not in line:
            parts += [data[done : mark.start()], b" "]
            done = continued = mark.end()
    return b"".join([*parts, data[done:]])


@kernel
def _parse(text: Bytes) -> tuple[Bytes, int, Ints, Ints, Ints, int]:
    """The text of all coordinates, the number of vertices, corners and sizes of polygons, and the first wrong line.

    Before the last: how many lines, surfaces and curves of splines there are besides.
    """
    # Upper bounds; memory that isn't written to costs nothing.
    coordinates = np.empty(len(text) + 1, dtype=np.uint8)
    corners = np.empty(len(text) // 2 + 1, dtype=np.int64)
    sizes = np.empty(len(text) // 2 + 1, dtype=np.int64)
    others = np.zeros(3, dtype=np.int64)
    copied = vertices = used = polygons = at = 0
    line = 1
    while at < len(text):
        at = _past_blanks(text, at)
        keyword = text[at] | _SMALL if at + 1 < len(text) and _blank(text[at + 1]) else 0
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
                    return coordinates[:0], 0, corners[:0], sizes[:0], others, line
            vertices += 1
        elif keyword == _F:
            at = _past_blanks(text, at + 1)
            first = used
            while not _ends(text[at]):
                index, at = _integer(text, at)
                if index == 0 or not (text[at] == _SLASH or _ends(text[at])):
                    return coordinates[:0], 0, corners[:0], sizes[:0], others, line
                # Negative numbers count back from the last vertex so far.
                corners[used] = index - 1 if index > 0 else vertices + index
                used += 1
                while not _ends(text[at]):
                    at += 1
                at = _past_blanks(text, at)
            sizes[polygons] = used - first
            polygons += 1
        elif keyword == _L:
            others[0] += 1
        else:
            others[1] += _is_word(text, at, _SURF)
            others[2] += _is_word(text, at, _CURV)
        while text[at] != _NEWLINE:
            at += 1
        at += 1
        line += 1
    return coordinates[:copied], vertices, corners[:used], sizes[:polygons], others, 0


@kernel
def _is_word(text: Bytes, at: int, word: Bytes) -> int:
    """Whether a word stands at a place, 1 or 0."""
    for n in range(len(word)):
        if at + n >= len(text) or text[at + n] | _SMALL != word[n]:
            return 0
    return int(at + len(word) < len(text) and _ends(text[at + len(word)]))


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
