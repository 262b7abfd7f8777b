"""glTF records, and the bytes of .glb files."""

import copy
import json
import struct
from collections.abc import Callable
from typing import Any

from tests.helpers.mesh_files import tetrahedron

VERTICES, FACES = tetrahedron()
POSITIONS, INDICES = VERTICES.astype("<f4").tobytes(), FACES.astype("<u2").tobytes()
RECORD: dict[str, Any] = {
    "asset": {"version": "2.0"},
    "scene": 0,
    "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
    ],
    "bufferViews": [
        {"buffer": 0, "byteLength": 48},
        {"buffer": 0, "byteOffset": 48, "byteLength": 24},
    ],
    "buffers": [{"uri": "a.bin", "byteLength": 72}],
}
"""A tetrahedron, whose buffer is its positions and then its indices."""


def scene(changes: Callable[[dict[str, Any]], object] | None = None) -> dict[str, Any]:
    """A copy of the record, changed."""
    record = copy.deepcopy(RECORD)
    if changes is not None:
        changes(record)
    return record


def as_glb(record: dict[str, Any], data: bytes) -> bytes:
    """A .glb file of a record and its one buffer."""
    text = json.dumps(record).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
