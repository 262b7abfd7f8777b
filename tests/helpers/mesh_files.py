"""A tetrahedron, and meshes as the bytes of files."""

import struct
from pathlib import Path

import numpy as np

from ncmodel.types import Floats, Ints

PLY_HEADER = (
    "ply\nformat {format} 1.0\ncomment made for a test\nelement vertex {v}\nproperty double x\nproperty double y\n"
    "property double z\nelement face {f}\nproperty list uchar int vertex_indices\nend_header\n"
)


def tetrahedron() -> tuple[Floats, Ints]:
    """Four vertices and four faces, a corner at the origin."""
    vertices = np.array([[0.0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1]])
    return vertices, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def as_obj(vertices: Floats, faces: Ints) -> bytes:
    """OBJ, coordinates exact."""
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return "\n".join(lines).encode()


def as_off(vertices: Floats, faces: Ints) -> bytes:
    """OFF with a comment."""
    lines = ["OFF # a comment", f"{len(vertices)} {len(faces)} 0"]
    lines += [f"{x:.17g} {y:.17g} {z:.17g}" for x, y, z in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
    return "\n".join(lines).encode()


def as_ply(vertices: Floats, faces: Ints) -> bytes:
    """Text PLY."""
    lines = [f"{x:.17g} {y:.17g} {z:.17g}" for x, y, z in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
    return (PLY_HEADER.format(format="ascii", v=len(vertices), f=len(faces)) + "\n".join(lines)).encode()


def as_binary_ply(vertices: Floats, faces: Ints, order: str = "<") -> bytes:
    """Binary PLY of either byte order."""
    name = "binary_little_endian" if order == "<" else "binary_big_endian"
    body = vertices.astype(order + "f8").tobytes()
    body += b"".join(struct.pack(order + "B3i", 3, *face) for face in faces)
    return PLY_HEADER.format(format=name, v=len(vertices), f=len(faces)).encode() + body


def as_big_endian_ply(vertices: Floats, faces: Ints) -> bytes:
    """Binary PLY, most significant byte first."""
    return as_binary_ply(vertices, faces, ">")


def write_obj(path: Path, geometry: tuple[Floats, Ints]) -> Path:
    """Write an OBJ file; its path again."""
    path.write_bytes(as_obj(*geometry))
    return path
