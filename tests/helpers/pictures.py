"""Scribbled pages, and what SVG and PDF files of ours show."""

import re
import xml.etree.ElementTree as ET

import cv2
import numpy as np

from ncmodel.export.rasterize import draw_segments
from ncmodel.types import Image, Stroke

SVG = "{http://www.w3.org/2000/svg}"


def scribbles(count: int = 30, side: float = 200.0, seed: int = 0) -> list[Stroke]:
    """Random walks on a square page, of three families, two of them with changing opacity."""
    rng = np.random.default_rng(seed)
    made = []
    for n in range(count):
        points = rng.uniform(0.1 * side, 0.9 * side, 2) + np.cumsum(
            rng.normal(0, 0.05 * side, (rng.integers(2, 12), 2)), 0
        )
        alpha = np.ones(len(points)) if n % 3 == 0 else rng.uniform(0.1, 1.0, len(points))
        made.append(Stroke(("contours", "ridges", "apparent")[n % 3], points, alpha))
    return made


def shade_of(path: ET.Element) -> float:
    """The opacity that the grey of a path stands for."""
    return 1 - int(path.attrib.get("stroke", "#000000")[1:3], 16) / 255


def shown(document: str, shape: tuple[int, int]) -> Image:
    """An SVG of ours, read back and drawn: where a path covers, the darker shade shows.

    Pieces of a taper, which overlap a little, are taken to abut: the ends drawn here are round, theirs are not.
    """
    image = np.zeros(shape, dtype=np.float32)
    for group in ET.fromstring(document).iter(f"{SVG}g"):
        for path in group.iter(f"{SVG}path"):
            points = np.array(re.findall(r"-?[\d.]+", path.attrib["d"]), dtype=float).reshape(-1, 2)
            segments = np.stack([points[:-1], points[1:]], axis=1)
            cover = draw_segments(segments, np.ones((len(segments), 2)), float(group.attrib["stroke-width"]), shape)
            shade = np.float32(shade_of(path))
            if "stroke-linecap:butt" in path.attrib.get("style", ""):
                image = np.maximum(image, cover * shade)
            else:
                image = (1 - cover) * image + cover * np.maximum(image, shade)
    return image


def objects_of(data: bytes) -> dict[int, bytes]:
    """A PDF's objects, found through its cross-reference table."""
    start = int(re.findall(rb"startxref\n(\d+)\n%%EOF", data)[-1])
    assert data[start : start + 4] == b"xref"
    count = int(data[start:].split(b"\n")[1].split()[1])
    rows = data[start:].split(b"\n")[2 : 2 + count]
    assert all(len(row) == 19 for row in rows)
    offsets = [int(row[:10]) for row in rows]
    for number, offset in enumerate(offsets[1:], 1):
        assert data[offset:].startswith(b"%d 0 obj\n" % number)
    return {number: data[offset : data.index(b"\nendobj", offset)] for number, offset in enumerate(offsets) if number}


def near(one: Image, other: Image, pixels: float, level: float) -> float:
    """The share of the ink of one, of `level` and more, that is within some pixels of the other's."""
    distance = cv2.distanceTransform((other <= level).astype(np.uint8), cv2.DIST_L2, 5)
    return float((distance[one > level] <= pixels).mean())


def far(one: Image, other: Image, level: float = 0.5) -> float:
    """The share of the ink of one that is more than a pixel from the other's."""
    return 1 - near(one, other, 1.01, level)
