"""Drawings as PDF."""

import re
import xml.etree.ElementTree as ET
import zlib

import numpy as np
import pytest

from ncmodel.export.page import Picture
from ncmodel.export.pdf import pdf
from ncmodel.export.svg import svg
from ncmodel.types import Stroke
from tests.helpers.pictures import SVG, objects_of


def test_pdf_holds_the_same_paths(picture: Picture) -> None:
    found = objects_of(pdf(picture))
    content = zlib.decompress(found[4].split(b"stream\n", 1)[1].rsplit(b"\nendstream", 1)[0]).decode()
    assert (
        f"/Length {len(found[4].split(b'stream' + bytes([10]), 1)[1].rsplit(bytes([10]) + b'endstream', 1)[0])}"
        in found[4].decode("latin-1")
    )
    assert b"/MediaBox [0 0 150 150]" in found[3]
    drawn = [np.array(re.findall(r"-?[\d.]+", p), dtype=float) for p in re.findall(r"RG ([^G]+) S", content)]
    paths = [np.array(re.findall(r"-?[\d.]+", d), dtype=float) for d in re.findall(r' d="M([^"]+)"', svg(picture))]
    assert len(drawn) == len(paths) > 50
    for one, other in zip(drawn, paths, strict=True):
        np.testing.assert_array_equal(one, other)
    greys = [round(255 * float(g)) for g in re.findall(r"([\d.]+) RG", content)]
    assert greys == [
        int(path.attrib.get("stroke", "#000000")[1:3], 16) for path in ET.fromstring(svg(picture)).iter(f"{SVG}path")
    ]
    assert b"/BM /Darken" in found[3]
    names = [found[n].split(b"(")[1].split(b")")[0] for n in range(6, 9)]
    assert names == [b"ridges", b"apparent", b"contours"]
    assert content.count("BDC") == content.count("EMC") == 3


def test_backgrounds_in_vector_files(picture: Picture) -> None:
    assert "<rect" not in svg(picture)
    assert '<rect width="100%" height="100%" fill="#ffeedd"/>' in svg(Picture(9, 9, (), background="#FFEEDD"))
    content = objects_of(pdf(Picture(9, 8, (), background="white")))[4].split(b"stream\n", 1)[1].rsplit(b"\nend", 1)[0]
    assert b"1 1 1 rg 0 0 9 8 re f" in zlib.decompress(content)


@pytest.mark.parametrize("width", [1e-5, 1e9])
def test_numbers_have_no_exponents(width: float) -> None:
    """PDF knows none. Coordinates keep their hundredths in the largest pictures."""
    page = Picture(16384, 768, [Stroke("contours", np.array([[12345.67, 1], [16383.99, 5]]), np.ones(2))], width)
    assert 'd="M12345.67 1 16383.99 5"' in svg(page)
    content = zlib.decompress(objects_of(pdf(page))[4].split(b"stream\n", 1)[1].rsplit(b"\nendstream", 1)[0]).decode()
    assert "12345.67 1 m 16383.99 5 l" in content
    assert not re.search(r"\de", content + svg(page).split("stroke-width=")[1].split()[0])
