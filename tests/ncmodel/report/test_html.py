"""Reports, plots and pictures: self-contained, escaped, the same bytes every time."""

import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path

import cv2
import numpy as np
import pytest

from ncmodel.errors import InputError
from ncmodel.images import from_brightness, from_ink, png_bytes, read_grey, shrink
from ncmodel.report.contact_sheet import Tile, contact_sheet, data_uri
from ncmodel.report.html import Block, Cell, Facts, Fold, Grid, Links, Section, Table, Text, render, write_report
from ncmodel.report.plots import PALETTE, Axis, Plot, Series, bar_plot, line_plot, short_number

EVIL = '<script src="https://example.org/x.js">&\'"'


def a_plot() -> Plot:
    series = [Series("train", [1, 2, 3], [3, 2, 1], band=([2, 1, 0], [4, 3, 2])), Series(EVIL, [1, 3], [2, 2])]
    return line_plot(series, Axis("epoch"), Axis("loss"), caption=EVIL)


def a_report() -> str:
    tile = Tile(from_ink(np.eye(4)), EVIL, highlight=True)
    blocks: list[Block] = [
        Text(EVIL, "warning"),
        Facts([(EVIL, EVIL)]),
        Table(
            ["method", "F1"], [["ours", Cell("60.6", 60.6, best=True, note="± 2")], [EVIL, Cell("54.1", 54.1)]], EVIL
        ),
        Grid([tile, tile], EVIL, columns=8),
        a_plot(),
        Links([(EVIL, "pages/0001.html")]),
        Fold(EVIL, [Text("inside")]),
    ]
    return render(EVIL, [Section(EVIL, blocks), Section("empty"), Section("last")], EVIL)


class Tags(HTMLParser):
    """Collects start tags and checks that every element is closed in order."""

    VOID = frozenset(["meta", "img", "br"])

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def tags_of(document: str) -> list[tuple[str, dict[str, str | None]]]:
    parser = Tags()
    parser.feed(document)
    assert parser.open == []
    return parser.seen


def test_a_report_escapes_what_it_is_given() -> None:
    tags = tags_of(a_report())
    assert [attributes for tag, attributes in tags if tag == "script"] == [{}]


def test_a_report_refers_to_nothing_outside_itself() -> None:
    loaded = [
        attributes[key] or ""
        for tag, attributes in tags_of(a_report())
        for key in ("src", "href", "xlink:href", "action")
        if key in attributes
    ]
    assert any(link.startswith("data:image/png;base64,") for link in loaded)
    assert all(link.startswith(("data:", "#", "pages/")) for link in loaded)


def test_every_picture_has_a_text_and_every_identifier_is_used_once() -> None:
    tags = tags_of(a_report())
    assert all(attributes.get("alt") for tag, attributes in tags if tag == "img" and "src" in attributes)
    identifiers = [attributes["id"] for _, attributes in tags if "id" in attributes]
    assert len(identifiers) == len(set(identifiers)) > 5


def test_two_different_plots_share_no_identifier() -> None:
    first, second = a_plot(), bar_plot(["a", "b"], [1, 2], [(0.5, 1.5), (2, 3)])
    identifiers = [set(re.findall(r'\bid="([^"]+)"', plot.svg)) for plot in (first, second)]
    assert all(identifiers)
    assert not identifiers[0] & identifiers[1]


def test_the_same_report_has_the_same_bytes(tmp_path: Path) -> None:
    assert a_report() == a_report()
    write_report(tmp_path / "report.html", "title", [Section("one", [a_plot()])])
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == render("title", [Section("one", [a_plot()])])


def test_a_plot_is_an_xml_element_in_the_text_colour_of_the_page() -> None:
    svg = a_plot().svg
    element = ET.fromstring(svg)
    assert element.tag.endswith("svg")
    assert "currentColor" in svg
    assert "#010203" not in svg
    references = re.findall(r'(?:url\(|href=")#([^)"]+)', svg)
    assert references
    assert set(references) <= set(re.findall(r'\bid="([^"]+)"', svg))


def test_dollar_signs_in_a_label_are_letters() -> None:
    assert "$0.02" in bar_plot(["$0.02 and $x^2$"], [1.0]).svg


def test_log_axes_are_labelled_with_short_numbers() -> None:
    sizes = [10.0**power for power in range(-1, 8)]
    svg = line_plot([Series("a", sizes, sizes)], Axis("x", "log"), Axis("y", "log")).svg
    labels = {text for text in re.findall(r">\s*([^<>]+?)\s*</text>", svg)}
    assert {"0.1", "100k", "10M"} <= labels
    assert "mathdefault" not in svg
    assert [short_number(value) for value in (0.1, 20, 1e3, 3e6, -2e9)] == ["0.1", "20", "1k", "3M", "-2G"]


def test_many_lines_stay_apart() -> None:
    series = [Series(f"line {n}", [0, 1], [n, n + 1], style="line+points") for n in range(2 * len(PALETTE))]
    svg = line_plot(series).svg
    assert all(f"line {n}" in svg for n in range(len(series)))
    strokes = re.findall(r'xlink:href="#[^"]+" x="[^"]+" y="[^"]+" style="fill: (#[0-9a-f]+)', svg)
    assert set(strokes) == set(PALETTE)


def test_mismatched_lengths_are_refused() -> None:
    with pytest.raises(ValueError, match="2 x and 1 y"):
        Series("a", [1, 2], [1])
    with pytest.raises(ValueError, match="1 labels for 2 values"):
        bar_plot(["a"], [1, 2])
    with pytest.raises(ValueError, match="row 1 has 1 cells for 2 columns"):
        Table(["a", "b"], [["1", "2"], ["1"]])
    with pytest.raises(ValueError, match="expected uint8"):
        Tile(np.zeros((2, 2)))  # type: ignore[arg-type]


def test_ink_is_black_on_white_and_out_of_range_values_are_clipped() -> None:
    np.testing.assert_array_equal(from_ink([[1.0, 0.0, 0.5]]), [[0, 255, 128]])
    np.testing.assert_array_equal(from_ink(np.array([[True, False]])), [[0, 255]])
    np.testing.assert_array_equal(from_brightness([[2.0, -1.0, np.nan]]), [[255, 0, 0]])


def test_shrinking_keeps_the_ratio_and_never_enlarges() -> None:
    picture = np.zeros((100, 200, 3), np.uint8)
    assert shrink(picture, 50).shape == (25, 50, 3)
    assert shrink(picture, 1000) is picture
    assert shrink(np.zeros((1, 4000), np.uint8), 10).shape == (1, 10)
    assert data_uri(picture, 50).startswith("data:image/png;base64,")


@pytest.mark.parametrize(
    ("stored", "brightness"),
    [
        (np.array([[0, 51, 255]], np.uint8), [[0.0, 0.2, 1.0]]),
        (np.array([[0, 13107, 65535]], np.uint16), [[0.0, 0.2, 1.0]]),
        (np.array([[[0, 0, 0], [255, 255, 255], [0, 0, 255]]], np.uint8), [[0.0, 1.0, 0.299]]),
        (np.array([[[0, 0, 0, 0], [0, 0, 0, 255], [0, 0, 0, 51]]], np.uint8), [[1.0, 0.0, 0.8]]),
    ],
    ids=["grey", "16 bit", "colour", "transparent"],
)
def test_pictures_of_every_kind_are_read_as_brightness(
    tmp_path: Path, stored: np.ndarray, brightness: list[list[float]]
) -> None:
    path = tmp_path / "picture.png"
    assert cv2.imwrite(str(path), stored)
    np.testing.assert_allclose(read_grey(path), brightness, atol=1e-6)


def test_a_written_picture_reads_back(tmp_path: Path) -> None:
    path = tmp_path / "x.png"
    path.write_bytes(png_bytes(from_ink(np.eye(3))))
    np.testing.assert_array_equal(read_grey(path), 1.0 - np.eye(3))


@pytest.mark.parametrize("content", [None, b"", b"hello", b"\x89PNG\r\n\x1a\n123"])
def test_what_is_no_picture_is_refused_by_name(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], content: bytes | None
) -> None:
    path = tmp_path / "broken.png"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"broken\.png: .*expected a picture"):
        read_grey(path)
    assert capfd.readouterr().err == ""


def test_a_contact_sheet_shows_every_tile_in_reading_order() -> None:
    tiles = [Tile(np.full((20, 10 + 10 * number), 60 * number, np.uint8), f"number {number}") for number in range(4)]
    sheet = contact_sheet(tiles, columns=3, thumb=64)
    cell = (64 + 12, 64 + 15 + 8 + 12)
    centres = [(12 + 32 + (n // 3) * cell[1], 12 + 32 + (n % 3) * cell[0]) for n in range(4)]
    assert [int(sheet[row, column, 0]) for row, column in centres] == [0, 60, 120, 180]
    assert contact_sheet([]).shape[2] == 3


def test_a_long_caption_stays_inside_its_cell() -> None:
    long = contact_sheet([Tile(np.zeros((8, 8), np.uint8), "w" * 200)], thumb=64)
    assert (long[-20:, -12:] == 255).all()
