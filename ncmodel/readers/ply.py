"""PLY, text and binary: positions, polygons and triangle strips; other elements and properties are passed over."""

import re
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncmodel.readers.content import Content, NotAMeshError
from ncmodel.readers.numbers import numbers
from ncmodel.readers.triangulate import triangulate
from ncmodel.types import Floats, Ints, Mesh

_TYPES = {
    "char": "i1", "uchar": "u1", "int8": "i1", "uint8": "u1", "short": "i2", "ushort": "u2", "int16": "i2",
    "uint16": "u2", "int": "i4", "uint": "u4", "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
_CORNERS = ("vertex_indices", "vertex_index")
_READ = ("x", "y", "z", *_CORNERS)
_SPLATS = ({"scale_0", "rot_0", "opacity"}, {"packed_position", "packed_rotation", "packed_scale"})
"""What the points of Gaussian splats have, plain and compressed."""
_AGAIN = " again"
"""Behind the name of a property that an element has already; no name has a blank of its own."""

_FILLING = b"\0\x1a \t\r\n"
"""What may stand behind the data of a binary file."""

_MOST_AGAIN = 100
"""Times that a property may be there once more; files in use have it at most twice."""


@dataclass(frozen=True)
class _Property:
    """A number, or (with `count_type`) a list of numbers that starts with its length."""

    name: str
    kind: str
    count_type: str = ""


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: tuple[_Property, ...]


def read_ply(data: bytes) -> Content:
    """Vertices and faces; no faces for a point cloud.

    Raises:
        NotAMeshError: It holds edges or Gaussian splats, and no faces.
        ValueError: The header isn't one of a PLY file, or the data end too early.
    """
    order, elements, body = _header(data)
    _check_surface(elements)
    reader = _Text(numbers(body)) if order == "" else _Binary(body, order)
    vertices, strips = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    corners, sizes = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    for element in elements:
        columns = reader.read(element)
        if element.name == "vertex":
            if not all(axis in columns for axis in "xyz"):
                raise ValueError("vertices without x, y and z")
            vertices = np.stack([columns[axis][0] for axis in "xyz"], axis=1).astype(np.float64)
        for name in _CORNERS:
            if name in columns and element.name == "face":
                corners, sizes = map(_whole, columns[name])
            elif name in columns and element.name == "tristrips":
                strips = _strips(*map(_whole, columns[name]))
    faces = triangulate(vertices, corners, sizes)
    if len(strips):
        faces = np.concatenate([faces, triangulate(vertices, strips.ravel(), np.full(len(strips), 3))])
    notes = [
        f"property {p.name.split()[0]!r} is there twice: the first is read"
        for element in elements
        for p in element.properties
        if p.name.split()[0] in _READ and p.name.endswith(_AGAIN)
    ]
    if reader.left:
        notes.append(f"{reader.left} behind what the header counts are passed over")
    return Content(vertices, faces, tuple(notes))


def _check_surface(elements: list[_Element]) -> None:
    """Refuse what has no faces and is no cloud of points of a surface.

    Raises:
        NotAMeshError: It says what is there instead.
    """
    counts = {element.name: element.count for element in elements}
    names = {p.name for element in elements if element.name == "vertex" for p in element.properties}
    if counts.get("face", 0) + counts.get("tristrips", 0) > 0:
        return
    if any(splat <= names for splat in _SPLATS):
        raise NotAMeshError(f"{counts['vertex']} Gaussian splats and no faces")
    if counts.get("edge", 0) > 0:
        raise NotAMeshError(f"{counts['edge']} lines and no faces")


def _whole(values: NDArray[Any]) -> Ints:
    """Numbers of vertices; text files hold them as any others."""
    if values.dtype.kind == "f" and not (values == np.floor(values)).all():
        raise ValueError("numbers of vertices that aren't whole")
    return values.astype(np.int64)


def _strips(corners: Ints, sizes: Ints) -> Ints:
    """(F, 3) the triangles of strips: three corners in a row, every other one turned; -1 starts a new strip.

    Triangles with a corner twice, by which strips turn round a corner, are left out.
    """
    # A break after each list, so that triangles across a break are told by the -1 in them.
    corners = np.insert(corners, np.cumsum(sizes), -1)
    starts = np.flatnonzero(np.concatenate([[-1], corners]) == -1)
    place = np.arange(len(corners)) - np.repeat(starts, np.diff(np.append(starts, len(corners))))
    faces = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    turned = place[:-2] % 2 == 1
    faces[turned] = faces[turned][:, [1, 0, 2]]
    i, j, k = faces.T
    return np.asarray(faces[(faces != -1).all(axis=1) & (i != j) & (j != k) & (k != i)])


def _header(data: bytes) -> tuple[str, list[_Element], bytes]:
    """The byte order, the elements, and what follows the header."""
    # Lines end as the first does: in a file of carriage returns, a line feed after the last is a number's byte.
    first = re.match(rb"ply[^\S\r\n]*(\r?\n|\r)", data)
    end = b"[^\\S\r]*\r" if first and first.group(1) == b"\r" else b"[^\\S\n]*\n"
    header = re.match(rb"ply\s++((?:.*?[\r\n])??)end_header" + end, data, re.DOTALL)
    if header is None:
        raise ValueError("no PLY header")
    order: str | None = None
    elements: dict[str, tuple[int, dict[str, _Property]]] = {}
    properties: dict[str, _Property] = {}  # of the last element
    # Bytes end lines and words where ASCII does; as text, a comment in UTF-8 may hold what Python takes for line ends.
    for line in header.group(1).splitlines():
        words = [word.decode("utf-8", "replace") for word in line.split()]
        match words:
            case ["format", name, _] if name in _ORDERS:
                order = _ORDERS[name]
            case ["element", name, _] if name in elements:
                raise ValueError(f"element {name!r} twice")
            case ["element", name, count] if count.isdigit():
                properties = {}
                elements[name] = int(count), properties
            case ["property", "list", count_type, kind, name] if elements:
                _add(properties, _Property(name, _TYPES.get(kind, ""), _TYPES.get(count_type, "")))
            case ["property", kind, name] if elements:
                _add(properties, _Property(name, _TYPES.get(kind, "")))
            case [] | ["comment", *_] | ["obj_info", *_]:
                pass
            case _:
                raise ValueError(f"header line {' '.join(words)!r}")
    if order is None:
        raise ValueError("a header without a format")
    listed = [_Element(name, count, tuple(added.values())) for name, (count, added) in elements.items()]
    return order, listed, data[header.end() :]


def _add(properties: dict[str, _Property], added: _Property) -> None:
    if not added.kind:
        raise ValueError(f"property {added.name!r} of an unknown type")
    name = added.name
    while name in properties:
        name += _AGAIN
    if name.count(_AGAIN) > _MOST_AGAIN:
        raise ValueError(f"property {added.name!r} more than {_MOST_AGAIN} times")
    properties[name] = replace(added, name=name)


_Columns = dict[str, tuple[NDArray[Any], Ints]]
"""Values and, for lists, lengths by property."""


class _Text:
    """The numbers of a text file, element after element."""

    def __init__(self, values: Floats) -> None:
        self.values, self.at = values, 0

    @property
    def left(self) -> str:
        """What hasn't been read, in words; "" where nothing is left."""
        count = len(self.values) - self.at
        return f"{count} numbers" if count else ""

    def read(self, element: _Element) -> _Columns:
        """The columns of one element."""
        lists = [bool(p.count_type) for p in element.properties]
        if not any(lists):
            table = self._take(element.count * len(lists)).reshape(element.count, len(lists))
            return {p.name: (table[:, n], np.zeros(0, dtype=np.int64)) for n, p in enumerate(element.properties)}
        values: dict[str, list[Floats]] = {p.name: [] for p in element.properties}
        if lists == [True] and (fixed := self._same_length(element.count)) is not None:
            return {element.properties[0].name: fixed}
        for _ in range(element.count):
            for p in element.properties:
                values[p.name].append(self._take(int(self._take(1)[0]) if p.count_type else 1))
        return {name: _joined(parts) for name, parts in values.items()}

    def _same_length(self, count: int) -> tuple[Floats, Ints] | None:
        """Lists all as long as the first, read at once; None where they aren't."""
        if count == 0 or self.at >= len(self.values):
            return None
        length = int(self.values[self.at])
        table = self.values[self.at : self.at + count * (length + 1)]
        if length < 0 or len(table) != count * (length + 1) or (table[:: length + 1] != length).any():
            return None
        self.at += len(table)
        return table.reshape(count, length + 1)[:, 1:].ravel(), np.full(count, length)

    def _take(self, count: int) -> Floats:
        if count < 0 or self.at + count > len(self.values):
            raise ValueError(f"the data end after {len(self.values)} numbers")
        self.at += count
        return self.values[self.at - count : self.at]


class _Binary:
    """The bytes of a binary file, element after element."""

    def __init__(self, data: bytes, order: str) -> None:
        self.data, self.order, self.at = data, order, 0

    @property
    def left(self) -> str:
        """What hasn't been read, in words; "" where nothing but filling is left."""
        return f"{len(self.data) - self.at} bytes" if self.data[self.at :].strip(_FILLING) else ""

    def read(self, element: _Element) -> _Columns:
        """The columns of one element."""
        if element.count == 0:
            return {p.name: (np.zeros(0), np.zeros(0, dtype=np.int64)) for p in element.properties}
        start = self.at
        lengths = [len(values) for values in self._record(element)]
        self.at = start
        record = np.dtype(
            [field for p, n in zip(element.properties, lengths, strict=True) for field in self._fields(p, n)]
        )
        if start + element.count * record.itemsize <= len(self.data):
            table = np.frombuffer(self.data, record, element.count, start)
            named = list(zip(element.properties, lengths, strict=True))
            if all((table[f"{p.name} length"] == n).all() for p, n in named if p.count_type):
                self.at += element.count * record.itemsize
                return {p.name: (table[p.name].ravel(), np.full(element.count, n)) for p, n in named}
        records = [self._record(element) for _ in range(element.count)]
        return {p.name: _joined([r[n] for r in records]) for n, p in enumerate(element.properties)}

    def _fields(self, p: _Property, length: int) -> list[tuple[Any, ...]]:
        """The fields of a record in which a property has `length` values."""
        if not p.count_type:
            return [(p.name, self.order + p.kind)]
        return [(f"{p.name} length", self.order + p.count_type), (p.name, self.order + p.kind, (length,))]

    def _record(self, element: _Element) -> list[NDArray[Any]]:
        """The values of one record."""
        values = []
        for p in element.properties:
            count = int(self._take(p.count_type, 1)[0]) if p.count_type else 1
            values.append(self._take(p.kind, count))
        return values

    def _take(self, kind: str, count: int) -> NDArray[Any]:
        width = np.dtype(kind).itemsize
        if count < 0 or self.at + count * width > len(self.data):
            raise ValueError(f"the data end after {len(self.data)} bytes")
        values = np.frombuffer(self.data, self.order + kind, count, self.at)
        self.at += count * width
        return values


def _joined(parts: list[NDArray[Any]]) -> tuple[NDArray[Any], Ints]:
    lengths = np.array([len(part) for part in parts], dtype=np.int64)
    return (np.concatenate(parts) if parts else np.zeros(0)), lengths


def ply_bytes(mesh: Mesh) -> bytes:
    """A mesh as a binary PLY file in double precision, so that it is read back exactly."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(mesh.vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(mesh.faces), dtype=[("corners", "u1"), ("vertices", "<i4", 3)])
    faces["corners"], faces["vertices"] = 3, mesh.faces
    return header.encode() + mesh.vertices.astype("<f8").tobytes() + faces.tobytes()
