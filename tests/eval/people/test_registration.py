"""Made scans of pages, turned, in perspective, unevenly lit and with grain: registered within a pixel at 768."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from eval.measures.thinning import thin_lines
from eval.people.elastic import bent
from eval.people.outline import drawn_outline
from eval.people.paper import pencil_ink
from eval.people.registration import NotRegisteredError, by_corners, by_rendering, turned
from ncmodel.chamfer import Lines, chamfer_distance
from ncmodel.images import from_brightness, from_ink, read_grey, write_png
from ncmodel.types import Floats, Image
from tests.helpers.commands import complaint, printed

SIDE, MARGIN, INNER = 768, 110, 1000
"""Pixels of the picture; of the page around the picture; of the picture on the page."""
MOST_OFF = 1.0


def drawing(side: int = SIDE, lean: float = 0.0) -> Image:
    """Ink of an egg with an arm, a circle inside and a free stroke."""
    ink = np.zeros((side, side), np.uint8)
    scale = side / 768
    width = max(1, round(2.5 * scale))
    for centre, axes, angle in (((350, 400), (210, 140), 20), ((560, 300), (110, 60), -50), ((300, 380), (40, 40), 0)):
        middle = tuple(round(16 * scale * c) for c in centre)
        cv2.ellipse(
            ink, middle, tuple(round(16 * scale * a) for a in axes), angle + lean, 0, 360, 255, width, cv2.LINE_AA, 4
        )
    cv2.line(
        ink, (round(400 * scale), round(480 * scale)), (round(470 * scale), round(420 * scale)), 255, width, cv2.LINE_AA
    )
    return (ink / 255).astype(np.float32)


def rendering() -> Image:
    """The same egg and arm, shaded, on white."""
    shade = np.ones((SIDE, SIDE), np.float32)
    v, u = np.mgrid[:SIDE, :SIDE]
    for centre, axes, angle in (((350, 400), (210, 140), 20), ((560, 300), (110, 60), -50)):
        mask = np.zeros((SIDE, SIDE), np.uint8)
        cv2.ellipse(mask, centre, axes, angle, 0, 360, 1, -1)
        shade = np.where(mask > 0, 0.35 + 0.5 * np.exp(-((u - centre[0]) ** 2 + (v - centre[1]) ** 2) / 2e4), shade)
    return shade.astype(np.float32)


def page(kind: str) -> tuple[Image, Floats]:
    """A page, and the homography from the picture to it."""
    inner = 1.0 - 0.5 * cv2.resize(drawing(), (INNER, INNER), interpolation=cv2.INTER_CUBIC).clip(0, 1)
    if kind == "page":
        return inner.astype(np.float32), np.diag([INNER / SIDE, INNER / SIDE, 1.0])
    left = MARGIN + (INNER if kind == "rendering" else 0)
    paper = np.ones((INNER + 2 * MARGIN, left + INNER + MARGIN), np.float32)
    paper[MARGIN : MARGIN + INNER, left : left + INNER] = inner
    if kind == "rendering":
        paper[MARGIN : MARGIN + INNER, MARGIN:left] = 0.3 + 0.7 * cv2.resize(rendering(), (INNER, INNER))
    near, far = 16 * MARGIN - 8, 16 * (MARGIN + INNER) - 8
    if kind == "marks":
        for corner in ((near, near), (far, near), (far, far), (near, far)):
            cv2.circle(paper, corner, 16 * 20, 0.1, -1, cv2.LINE_AA, 4)
    if kind == "frame":
        cv2.rectangle(paper, (near, near), (far, far), 0.25, 4, cv2.LINE_AA, 4)
    scale = INNER / SIDE
    return paper, np.array([[scale, 0.0, left], [0.0, scale, MARGIN], [0.0, 0.0, 1.0]])


def scanned(kind: str) -> tuple[Image, Floats]:
    """A photo of a page, turned, in perspective, unevenly lit, with grain; and where the picture is in it."""
    paper, onto = page(kind)
    height, width = paper.shape
    out = (round(1.25 * width), round(1.25 * height))
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    seen = np.array([[0.12, 0.08], [0.93, 0.11], [0.89, 0.93], [0.07, 0.87]], np.float32) * np.array(out, np.float32)
    camera = cv2.getPerspectiveTransform(corners, seen)
    half = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, 0.0, 1.0]])
    photo = cv2.warpPerspective(paper, np.linalg.inv(half) @ camera @ half, out, flags=cv2.INTER_AREA, borderValue=0.25)
    v, u = np.mgrid[: out[1], : out[0]]
    lit = photo * (0.6 + 0.25 * u / out[0] + 0.1 * v / out[1])
    grain = np.random.default_rng(0).normal(0.0, 0.01, lit.shape)
    return np.clip(lit + grain, 0.0, 1.0).astype(np.float32), camera @ onto


def off(found: Floats, true: Floats) -> float:
    """Pixels of the picture by which its drawn lines are out of place, at most."""
    rows, columns = np.nonzero(drawing() > 0.5)
    places = np.stack([columns + 0.5, rows + 0.5, np.ones(len(rows))])
    back = np.linalg.inv(true) @ found @ places
    return float(np.linalg.norm((back / back[2] - places)[:2], axis=0).max())


@pytest.mark.parametrize("kind", ["marks", "frame", "page", "rendering"])
def test_a_scan_is_registered_within_a_pixel_and_its_pencil_becomes_ink(kind: str) -> None:
    scan, true = scanned(kind)
    if kind == "rendering":
        # At the print itself: what is drawn beside it is as far off as its slant is, times the distance.
        found = by_rendering(scan, rendering(), (0.0, 0.0), millimetres=205.0)
        true = true @ np.array([[1.0, 0.0, -SIDE], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        assert off(found.homography, true) < MOST_OFF
        beside = by_rendering(scan, rendering(), (SIDE, 0.0))
        np.testing.assert_allclose(beside.homography[:, 2], found.homography @ [SIDE, 0.0, 1.0])
        return
    found = by_corners(scan, kind, (SIDE, SIDE), millimetres=205.0)
    assert off(found.homography, true) < MOST_OFF
    assert found.mm_per_pixel == pytest.approx(205.0 / SIDE)
    ink = found.drawing(scan)
    assert chamfer_distance(Lines.of(thin_lines(ink)), Lines.of(thin_lines(drawing()))) < 1.0


def test_a_page_without_what_it_is_registered_by_is_refused() -> None:
    blank = np.full((300, 400), 0.8, np.float32)
    for way in ("marks", "frame", "page"):
        with pytest.raises(NotRegisteredError):
            by_corners(blank, way, (SIDE, SIDE))
    with pytest.raises(NotRegisteredError, match="isn't found"):
        by_rendering(blank, rendering())
    scan, _ = scanned("marks")
    with pytest.raises(NotRegisteredError, match="times as wide"):
        by_corners(scan, "marks", (768, 384))


def test_uneven_light_and_a_pale_print_are_no_ink() -> None:
    v, u = np.mgrid[:400, :400]
    light = (0.5 + 0.4 * u / 400) * np.where((u - 200) ** 2 + (v - 200) ** 2 < 100**2, 0.85, 1.0)
    lines = drawing(400)
    ink = pencil_ink((light * (1 - 0.4 * lines)).astype(np.float32))
    assert chamfer_distance(Lines.of(thin_lines(ink)), Lines.of(thin_lines(lines))) < 0.7
    assert (ink >= 0.5).mean() < 2.5 * (lines >= 0.5).mean()


def test_turning_is_clockwise() -> None:
    scan = np.zeros((2, 3), np.float32)
    scan[0, 0] = 1.0
    assert turned(scan, 90)[0, 1] == 1.0
    np.testing.assert_array_equal(turned(scan, 360), scan)


def test_bending_brings_an_outline_onto_another() -> None:
    goal, leaning = drawing(384), drawing(384, lean=3.0)
    before = chamfer_distance(Lines.of(thin_lines(leaning)), Lines.of(thin_lines(goal)))
    moved = bent(leaning, drawn_outline(leaning), drawn_outline(goal))
    after = chamfer_distance(Lines.of(thin_lines(moved)), Lines.of(thin_lines(goal)))
    assert after < 0.6 * before


def test_the_command_registers_a_scan(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scan, _ = scanned("marks")
    write_png(tmp_path / "scan.png", from_brightness(scan))
    out = tmp_path / "ann.png"
    record = printed(capsys, "register", tmp_path / "scan.png", "-o", out, "--size", SIDE, "--millimetres", 205)
    assert record["mm_per_pixel"] == pytest.approx(205 / 768)
    ink = 1.0 - read_grey(out)
    assert chamfer_distance(Lines.of(thin_lines(ink)), Lines.of(thin_lines(drawing()))) < 1.0
    write_png(tmp_path / "blank.png", from_ink(np.zeros((64, 64))))
    said = complaint(capsys, "register", tmp_path / "blank.png", "-o", tmp_path / "x.png", "--size", 64)
    assert "blank.png: 0 filled marks, not four of one size around the drawing; expected a page with four" in said
    said = complaint(capsys, "register", tmp_path / "scan.png", "-o", out, "--size", 64, "--by", "rendering")
    assert "--by: found rendering and no rendering" in said
    assert not (tmp_path / "x.png").exists()
