"""Drawings as SVG: what is in it, and that it shows what the PNG shows."""

import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import cv2
import numpy as np
import pytest

from ncmodel.drawing.draw import draw
from ncmodel.export.page import Picture
from ncmodel.export.png import ink
from ncmodel.export.svg import svg
from ncmodel.types import Image, LineFamily, Stroke
from tests.helpers.pictures import SVG, far, shown


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
