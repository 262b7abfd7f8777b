"""Drawings as files: what SVG, PDF and PNG hold, and that they show the same."""

import itertools
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from ncmodel.drawing.draw import draw
from ncmodel.errors import UsageError
from ncmodel.export.page import Picture, colour
from ncmodel.export.pdf import pdf
from ncmodel.export.png import ink, png
from ncmodel.export.rasterize import draw_segments
from ncmodel.export.svg import svg
from ncmodel.export.tapers import OPACITY_STEP, OVERLAP
from ncmodel.types import Floats, Image, LineFamily, Stroke

SVG = "{http://www.w3.org/2000/svg}"


def scribbles(count: int = 30, side: float = 200.0, seed: int = 0) -> list[Stroke]:
    rng = np.random.default_rng(seed)
    made = []
    for n in range(count):
        points = rng.uniform(0.1 * side, 0.9 * side, 2) + np.cumsum(
            rng.normal(0, 0.05 * side, (rng.integers(2, 12), 2)), 0
        )
        alpha = np.ones(len(points)) if n % 3 == 0 else rng.uniform(0.1, 1.0, len(points))
        made.append(Stroke(("contours", "ridges", "apparent")[n % 3], points, alpha))
    return made


@pytest.fixture
def picture() -> Picture:
    return Picture(200, 200, scribbles(), line_width=6.0)


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


def far(one: Image, other: Image, level: float = 0.5) -> float:
    """The share of the ink of one that is more than a pixel from the other's."""
    distance = cv2.distanceTransform((other <= level).astype(np.uint8), cv2.DIST_L2, 5)
    return float((distance[one > level] > 1.01).mean())


def test_svg_is_xml_with_a_group_a_family(picture: Picture) -> None:
    root = ET.fromstring(svg(picture).encode())
    assert root.tag == f"{SVG}svg"
    assert (root.attrib["width"], root.attrib["height"], root.attrib["viewBox"]) == ("200", "200", "0 0 200 200")
    groups = root.findall(f"{SVG}g")
    assert [group.attrib["id"] for group in groups] == ["ridges", "apparent", "contours"]
    widths = [float(group.attrib["stroke-width"]) for group in groups]
    np.testing.assert_allclose(widths, np.array([4.8, 6.0, 6.0]) * 200 / 768, rtol=1e-3)
    assert {path.attrib.get("stroke") for path in groups[2]} == {None}
    assert groups[2].attrib["stroke"] == "#000000"
    assert all(re.fullmatch(r"M-?[\d.]+ -?[\d.]+( -?[\d.]+ -?[\d.]+)+", path.attrib["d"]) for g in groups for path in g)


def test_svg_shows_what_the_png_shows(picture: Picture) -> None:
    vector, raster = shown(svg(picture), (200, 200)), ink(picture)
    for level in (0.25, 0.5):
        assert far(raster, vector, level) < 0.005
        assert far(vector, raster, level) < 0.02


def test_strokes_that_cross_show_the_stronger_one() -> None:
    faint = [Stroke("ridges", np.array([[10.0, y], [190.0, 200 - y]]), np.full(2, 0.5)) for y in (40, 100, 160)]
    crossed = Picture(200, 200, [*faint, Stroke("contours", np.array([[100.0, 5], [100, 195]]), np.ones(2))], 8.0)
    vector = shown(svg(crossed), (200, 200))
    assert 0.4 < vector[100, 50:90].max() < 0.51
    assert vector[100, 100] == pytest.approx(1.0)
    np.testing.assert_allclose(vector, ink(crossed), atol=0.05)


def test_a_lone_taper_has_the_same_ink() -> None:
    points = np.linspace([10.0, 20.0], [190.0, 150.0], 4)
    taper = Picture(200, 200, [Stroke("suggestive", points, np.array([0.0, 0.9, 1.0, 0.3]))], line_width=10.0)
    vector, raster = shown(svg(taper), (200, 200)), ink(taper)
    assert vector.sum() == pytest.approx(raster.sum(), rel=0.03)
    levels = sorted({shade_of(path) for path in ET.fromstring(svg(taper)).iter(f"{SVG}path")})
    assert np.diff(levels).max() < 1.5 * OPACITY_STEP


def test_pieces_are_few_where_opacity_trembles_and_no_shorter_than_wide() -> None:
    rng = np.random.default_rng(2)
    points = np.stack([np.linspace(5, 195, 400), np.full(400, 50.0)], axis=1)
    still = Stroke("ridges", points, 0.5 + 0.4 * OPACITY_STEP * rng.choice([-1, 1], 400))
    wild = Stroke("ridges", points, rng.random(400))
    assert svg(Picture(768, 768, [still])).count("<path") == 1
    drawn = [np.array(d.split(), dtype=float) for d in re.findall(r'd="M([^"]+)"', svg(Picture(768, 768, [wild])))]
    assert min(d[-2] - d[0] for d in drawn[:-1]) > 1.98


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


def test_pieces_of_a_taper_run_on_from_each_other() -> None:
    rng = np.random.default_rng(1)
    points, alpha = np.cumsum(rng.normal(0, 9, (40, 2)), axis=0) + 100, rng.uniform(0.2, 1.0, 40)
    document = svg(Picture(200, 200, [Stroke("ridges", points, alpha)]))
    paths = [np.array(d.split(), dtype=float).reshape(-1, 2) for d in re.findall(r'd="M([^"]+)"', document)]
    for one, following in itertools.pairwise(paths):
        assert np.linalg.norm(one[-1] - following[0]) == pytest.approx(2 * OVERLAP, abs=0.02)
    length = sum(np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in paths)
    overlaps = 2 * OVERLAP * (len(paths) - 1)
    assert length == pytest.approx(np.linalg.norm(np.diff(points, axis=0), axis=1).sum() + overlaps, rel=2e-3)


def test_invisible_parts_leave_a_gap() -> None:
    line = Stroke("ridges", np.array([[0.0, 5], [40, 5], [60, 5], [100, 5]]), np.array([1.0, 0.0, 0.0, 1.0]))
    document = svg(Picture(100, 10, [line]))
    ends = [[float(x) for x in d.split()] for d in re.findall(r'd="M([^"]+)"', document)]
    covered = np.array([[e[0], e[-2]] for e in ends])
    assert not ((covered[:, 0] < 45) & (covered[:, 1] > 55)).any()
    assert svg(Picture(100, 10, [Stroke("ridges", line.points, np.zeros(3))])).count("<path") == 0


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


def decoded(picture: Picture) -> Floats:
    return np.asarray(cv2.imdecode(np.frombuffer(png(picture), np.uint8), cv2.IMREAD_UNCHANGED), dtype=np.float64)


def test_png_is_black_on_white_coloured_or_transparent(picture: Picture) -> None:
    cover = ink(picture)
    np.testing.assert_allclose(decoded(picture), 255 * (1 - cover), atol=0.51)
    grey = decoded(Picture(200, 200, picture.strokes, 6.0, "#808080"))
    np.testing.assert_allclose(grey, 128 * (1 - cover), atol=0.51)
    red = decoded(Picture(200, 200, picture.strokes, 6.0, "#ff8000"))
    np.testing.assert_allclose(red, (1 - cover)[..., None] * [0, 128, 255], atol=0.51)
    clear = decoded(Picture(200, 200, picture.strokes, 6.0, "transparent"))
    np.testing.assert_allclose(clear[..., 3], 255 * cover, atol=0.51)
    assert (clear[..., :3] == 0).all()


def test_backgrounds_in_vector_files(picture: Picture) -> None:
    assert "<rect" not in svg(picture)
    assert '<rect width="100%" height="100%" fill="#ffeedd"/>' in svg(Picture(9, 9, (), background="#FFEEDD"))
    content = objects_of(pdf(Picture(9, 8, (), background="white")))[4].split(b"stream\n", 1)[1].rsplit(b"\nend", 1)[0]
    assert b"1 1 1 rg 0 0 9 8 re f" in zlib.decompress(content)


def test_lines_grow_with_the_picture() -> None:
    assert Picture(768, 900, ()).width_of("contours") == 2.5
    assert Picture(768, 900, ()).width_of("valleys") == 2.0
    assert Picture(1536, 3000, (), 1.0).width_of("suggestive") == 2.0


@pytest.mark.parametrize("width", [1e-5, 1e9])
def test_numbers_have_no_exponents(width: float) -> None:
    """PDF knows none. Coordinates keep their hundredths in the largest pictures."""
    page = Picture(16384, 768, [Stroke("contours", np.array([[12345.67, 1], [16383.99, 5]]), np.ones(2))], width)
    assert 'd="M12345.67 1 16383.99 5"' in svg(page)
    content = zlib.decompress(objects_of(pdf(page))[4].split(b"stream\n", 1)[1].rsplit(b"\nendstream", 1)[0]).decode()
    assert "12345.67 1 m 16383.99 5 l" in content
    assert not re.search(r"\de", content + svg(page).split("stroke-width=")[1].split()[0])


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


def browsed(document: str, folder: Path, shape: tuple[int, int]) -> Image:
    """(H, W) ink of an SVG as Chromium shows it."""
    from playwright.sync_api import sync_playwright

    (folder / "p.svg").write_text(document, encoding="utf-8")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": shape[1], "height": shape[0]})
        page.goto((folder / "p.svg").as_uri())
        page.screenshot(path=str(folder / "p.png"))
        browser.close()
    grey = cv2.imread(str(folder / "p.png"), cv2.IMREAD_GRAYSCALE)
    return (1 - np.asarray(grey, dtype=np.float32) / 255).astype(np.float32)


@pytest.mark.browser
def test_browser_shows_what_the_png_shows(picture: Picture, tmp_path: Path) -> None:
    seen, raster = browsed(svg(picture), tmp_path, (200, 200)), ink(picture)
    for level in (0.25, 0.5):
        assert far(raster, seen, level) < 0.005
        assert far(seen, raster, level) < 0.02
    assert np.abs(seen - shown(svg(picture), (200, 200))).mean() < 0.005


@pytest.mark.browser
@pytest.mark.parametrize("name", ["bunny.obj", "cow.obj"])
def test_browser_shows_all_families_as_the_png_does(name: str, bundled: Path, tmp_path: Path) -> None:
    page = draw(bundled / name, lines=list(LineFamily)).picture()
    seen, raster = browsed(svg(page), tmp_path, (768, 768)), ink(page)
    for level in (0.1, 0.25, 0.5, 0.75):
        assert far(raster, seen, level) < 0.005
        assert far(seen, raster, level) < 0.005


def inkscaped(document: str, folder: Path) -> tuple[Image, dict[str, list[float]]]:
    """(H, W) ink of an SVG as Inkscape shows it, and the bounding box (x, y, width, height) of each object by id."""
    (folder / "p.svg").write_text(document, encoding="utf-8")
    asked = [["--export-type=png", "-o", str(folder / "p.png")], ["--query-all"]]
    said = [
        subprocess.run(["inkscape", str(folder / "p.svg"), *a], check=True, capture_output=True, text=True, timeout=120)
        for a in asked
    ]
    shown = np.asarray(cv2.imread(str(folder / "p.png"), cv2.IMREAD_UNCHANGED), dtype=np.float32) / 255
    assert shown.shape[2] == 4, "paper that is left unpainted is transparent"
    boxes = [line.split(",") for line in said[1].stdout.splitlines()]
    ink_seen = ((1 - shown[..., 0]) * shown[..., 3]).astype(np.float32)
    return ink_seen, {name: [float(x) for x in box] for name, *box in boxes}


@pytest.mark.browser
@pytest.mark.skipif(shutil.which("inkscape") is None, reason="Inkscape isn't installed")
@pytest.mark.parametrize("name", ["bunny.obj", "cow.obj"])
def test_inkscape_shows_all_families_as_the_png_does(name: str, bundled: Path, tmp_path: Path) -> None:
    page = draw(bundled / name, lines=list(LineFamily)).picture()
    raster = ink(page)
    seen, boxes = inkscaped(svg(page), tmp_path)
    assert seen.shape == raster.shape
    for level in (0.1, 0.25, 0.5, 0.75):
        assert far(raster, seen, level) < 0.005
        assert far(seen, raster, level) < 0.005
    for family, strokes in page.groups():
        points = np.concatenate([stroke.points for stroke in strokes])
        corner, size = np.array(boxes[family][:2]), np.array(boxes[family][2:])
        np.testing.assert_allclose(corner, points.min(axis=0), atol=page.width_of(family))
        np.testing.assert_allclose(corner + size, points.max(axis=0), atol=page.width_of(family))
