"""Pages: colours, widths, titles, and what all formats have in common."""

import xml.etree.ElementTree as ET

import cv2
import numpy as np
import pytest

from ncmodel.errors import UsageError
from ncmodel.export.colours import colour
from ncmodel.export.page import Picture
from ncmodel.export.pdf import pdf
from ncmodel.export.png import ink, png
from ncmodel.export.svg import svg
from ncmodel.types import Stroke
from tests.helpers.pictures import SVG, scribbles


def pixel_of(data: bytes, column: int, row: int) -> list[int]:
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    return [int(c) for c in image[row, column]]


def test_lines_are_white_on_dark_paper() -> None:
    page = Picture(20, 20, [Stroke("ridges", np.array([[0.0, 10], [20, 10]]), np.full(2, 0.5))], 99.0, "black")
    assert "lighten" in svg(page)
    assert 'stroke="#808080"' in svg(page)
    assert pixel_of(png(page), 10, 10) == [128, 128, 128]
    assert pixel_of(png(page), 10, 1) == [0, 0, 0]
    assert b"/BM /Lighten" in pdf(page)


@pytest.mark.parametrize("title", ['<cow> & "bull"', "a\x00b\x1bc", "Kuh \N{COW}", "]]>", "-->"])
def test_any_name_makes_valid_files(title: str) -> None:
    page = Picture(20, 20, scribbles(3, 20.0), title=title)
    found = ET.fromstring(svg(page).encode()).find(f"{SVG}title")
    assert found is not None
    assert found.text is not None
    assert found.text.isprintable()
    assert pdf(page).startswith(b"%PDF-1.5")


@pytest.mark.parametrize("strokes", [[], [Stroke("image", np.array([[1.0, 1.0], [5.0, 5.0]]), np.ones(2))]])
def test_empty_and_unknown_families(strokes: list[Stroke]) -> None:
    page = Picture(1, 1, strokes)
    assert len(ET.fromstring(svg(page)).findall(f"{SVG}g")) == len(strokes)
    assert ink(page).shape == (1, 1)
    assert pdf(page)
    assert png(page)


def test_lines_grow_with_the_picture() -> None:
    assert Picture(768, 900, ()).width_of("contours") == 2.5
    assert Picture(768, 900, ()).width_of("valleys") == 2.0
    assert Picture(1536, 3000, (), 1.0).width_of("suggestive") == 2.0


@pytest.mark.parametrize("name", ["", "#12345", "#12345g", "123456", "pink", "#-12345"])
def test_wrong_colours(name: str) -> None:
    with pytest.raises(UsageError, match="background: found"):
        colour(name)


@pytest.mark.parametrize("width", [0.0, -1.0, float("nan"), float("inf")])
def test_wrong_widths(width: float) -> None:
    with pytest.raises(UsageError, match="width: found"):
        Picture(10, 10, (), width)


def test_same_strokes_same_bytes(picture: Picture) -> None:
    again = Picture(200, 200, scribbles(), line_width=6.0)
    assert (svg(picture), pdf(picture), png(picture)) == (svg(again), pdf(again), png(again))
