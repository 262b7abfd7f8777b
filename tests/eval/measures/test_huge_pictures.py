"""A picture that would fill the memory fails alone."""

import json
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from ncmodel.errors import InputError
from ncmodel.images import from_ink, read_grey, write_png
from tests.helpers.commands import complaint


def huge_png(side: int) -> bytes:
    """A grey PNG that says it has side x side pixels; there is hardly anything in it."""
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)), (b"IDAT", zlib.compress(bytes(9))))
    packed = [struct.pack(">I", len(d)) + n + d + struct.pack(">I", zlib.crc32(n + d)) for n, d in chunks]
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


def test_a_huge_png_is_refused_before_it_is_decoded(tmp_path: Path) -> None:
    (tmp_path / "huge.png").write_bytes(huge_png(32_000))
    with pytest.raises(InputError, match="32000 x 32000 pixels"):
        read_grey(tmp_path / "huge.png")


def test_evaluation_goes_on_without_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ink = np.zeros((40, 50))
    ink[20:23] = 1.0
    drawings, references, out = tmp_path / "d", tmp_path / "r", tmp_path / "out"
    for folder in (drawings, references):
        folder.mkdir()
        for name in ("a", "b"):
            write_png(folder / f"{name}.png", from_ink(ink))
    (drawings / "b.png").write_bytes(huge_png(32_000))
    asked = ("evaluate", "--drawings", drawings, "--references", references, "-o", out)
    assert "32000 x 32000 pixels" in complaint(capsys, *asked, status=1)
    assert [d["name"] for d in json.loads((out / "report.json").read_text())["drawings"]] == ["a"]
