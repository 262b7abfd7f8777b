"""Files that are long where no program makes them long are read, or refused, in time that grows as they do."""

import time
from collections.abc import Iterator

import numpy as np
import pytest

from ncmodel.readers.ply import read_ply
from ncmodel.readers.stl import read_stl

SECONDS = 20
"""Of processor time: a hundred times what is needed, and a small part of what quadratic reading took."""

HEADER = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
FACE = b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"


@pytest.fixture(autouse=True)
def _bounded() -> Iterator[None]:
    begin = time.process_time()
    yield
    assert time.process_time() - begin < SECONDS


def test_ply_of_many_properties() -> None:
    count = 50_000
    properties = b"".join(b"property float p%d\n" % n for n in range(count))
    rows = b"".join(b"%d %d 0" % (n, n % 2) + b" 1" * count + b"\n" for n in range(3))
    content = read_ply(HEADER + properties + FACE + rows + b"3 0 1 2\n")
    np.testing.assert_array_equal(content.vertices, [[0, 0, 0], [1, 1, 0], [2, 0, 0]])


def test_ply_of_many_elements() -> None:
    elements = b"".join(b"element e%d 0\n" % n for n in range(50_000))
    assert len(read_ply(HEADER + elements + FACE + b"0 0 0\n1 1 0\n2 0 0\n3 0 1 2\n").faces) == 1


def test_ply_with_one_property_again_and_again() -> None:
    with pytest.raises(ValueError, match="property 'p' more than"):
        read_ply(HEADER + b"property float p\n" * 50_000 + FACE)


def test_ply_of_blank_lines() -> None:
    with pytest.raises(ValueError, match="no PLY header"):
        read_ply(b"ply\n" + b"\n" * 9_000_000)


def test_stl_of_blank_lines() -> None:
    face = b"facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n"
    for before, after in ((b"\n" * 9_000_000, b""), (b"", b"\n" * 9_000_000)):
        assert len(read_stl(before + b"solid a\n" + face + b"endsolid a\n" + after).faces) == 1


def test_stl_of_many_files_in_one() -> None:
    one = bytes(80) + (1).to_bytes(4, "little") + bytes(50)
    content = read_stl(one * 20_000)
    assert len(content.faces) == 20_000
    assert content.notes == ("20000 STL files in one: all are read",)
