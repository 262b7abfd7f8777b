"""Views on one sheet: aligned, at one scale, where the angle of projection has them; and sizes on paper."""

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from ncmodel.cli.main import main
from ncmodel.errors import ArgumentError
from ncmodel.export.page import MILLIMETRES
from ncmodel.sheets.arrangement import names_of, places
from ncmodel.sheets.paper import Paper
from ncmodel.sheets.sheet import Layout, Sheet, draw_sheet
from ncmodel.types import Floats
from tests.helpers.commands import complaint, printed
from tests.helpers.dirty import box
from tests.helpers.mesh_files import write_obj
from tests.helpers.pictures import SVG

SIDES = (100.0, 60.0, 40.0)
"""Of a block, in millimetres: width, height, depth."""
NAMES = ("front", "top", "right", "iso")


@pytest.fixture(scope="module")
def block(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_obj(tmp_path_factory.mktemp("block") / "block.obj", box((0.0, 0.0, 0.0), SIDES))


def extents(sheet: Sheet) -> dict[str, Floats]:
    """View -> (2, 2) the least and the largest u, v of its lines on the sheet."""
    found = {}
    for label, drawing, corner in zip(sheet.labels, sheet.drawings, sheet.corners, strict=True):
        points = np.concatenate([stroke.points for stroke in drawing.strokes]) + corner
        found[label.text] = np.array([points.min(axis=0), points.max(axis=0)])
    return found


@pytest.mark.parametrize("angle", ["third", "first"])
def test_views_are_aligned_at_one_scale(angle: str, block: Path) -> None:
    sheet = draw_sheet(block, Layout(NAMES, angle))
    found = extents(sheet)
    front, top, right = (found[name] for name in ("front", "top", "right"))
    scale = np.ptp(front[:, 0]) / SIDES[0]
    for view, sides in ((front, (0, 1)), (top, (0, 2)), (right, (2, 1))):
        assert np.ptp(view, axis=0) == pytest.approx([scale * SIDES[side] for side in sides], abs=0.5)
    assert top[:, 0] == pytest.approx(front[:, 0], abs=0.5)
    assert right[:, 1] == pytest.approx(front[:, 1], abs=0.5)
    above, after = top[1, 1] < front[0, 1], right[0, 0] > front[1, 0]
    assert (above, after) == ((True, True) if angle == "third" else (False, False))
    assert found["iso"][:, 0].mean() == pytest.approx(right[:, 0].mean(), abs=60.0)
    for view in found.values():
        assert (view[0] > 0).all()
        assert (view[1] < (sheet.width, sheet.height)).all()


def test_what_does_not_depend_on_the_view_is_computed_once(block: Path) -> None:
    stages = [timing.stage for timing in draw_sheet(block, Layout(NAMES)).trace.timings]
    assert stages.count("load") == stages.count("parted") == 1
    assert stages.count("write") == 0


def test_places_leave_no_empty_columns() -> None:
    assert places(("front", "left"), "third") == {"front": (1, 0), "left": (0, 0)}
    assert places(("front", "left"), "first") == {"front": (0, 0), "left": (1, 0)}
    assert places(("top", "bottom", "back"), "third") == {"top": (0, 0), "bottom": (0, 2), "back": (1, 1)}
    assert names_of(" front,top,front") == ("front", "top")


def test_a_sheet_is_as_large_as_asked_for(block: Path) -> None:
    sheet = draw_sheet(block, Layout(NAMES, size=(400, 300)))
    assert (sheet.width, sheet.height) == (400, 300)
    assert sheet.ink().shape == (300, 400)
    assert all(view.min() > 0 and (view[1] < (400, 300)).all() for view in extents(sheet).values())


def test_sizes_on_paper_are_real(block: Path, tmp_path: Path) -> None:
    """A block 100 mm wide is 50 mm wide at 1:2, in the middle of the page."""
    out = tmp_path / "a.svg"
    options = ("--view", "front", "--projection", "orthographic", "--page", "A4", "--scale", "1:2")
    assert main(["draw", str(block), "-o", str(out), *options]) == 0
    root = ET.parse(out).getroot()
    assert (root.get("width"), root.get("height")) == ("210mm", "297mm")
    sides = [float(word) for word in str(root.get("viewBox")).split()[2:]]
    assert [side * MILLIMETRES for side in sides] == pytest.approx([210.0, 297.0], abs=1e-3)
    numbers = [re.findall(r"-?[\d.]+", path.attrib["d"]) for path in root.iter(f"{SVG}path")]
    points = np.concatenate([np.array(found, dtype=float).reshape(-1, 2) for found in numbers]) * MILLIMETRES
    assert np.ptp(points, axis=0) == pytest.approx(SIDES[:2] * np.array(0.5), abs=0.1)
    assert points.min(axis=0) + np.ptp(points, axis=0) / 2 == pytest.approx([105.0, 148.5], abs=0.1)


def test_a_pdf_and_a_dxf_have_the_same_size(block: Path, tmp_path: Path) -> None:
    ezdxf = pytest.importorskip("ezdxf")
    options = ("--views", "front,top", "--page", "A5-landscape", "--scale", "1:1", "--margin", "5mm")
    for suffix in ("pdf", "dxf"):
        assert main(["draw", str(block), "-o", str(tmp_path / f"a.{suffix}"), *options]) == 0
    box_of = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", (tmp_path / "a.pdf").read_bytes())
    assert box_of is not None
    assert [float(box_of[n]) * 25.4 / 72 for n in (1, 2)] == pytest.approx([210.0, 148.0], abs=1e-3)
    space = ezdxf.readfile(tmp_path / "a.dxf").modelspace()
    corners = np.concatenate([[point[:2] for point in line.get_points()] for line in space.query("LWPOLYLINE")])
    assert np.ptp(corners[:, 0]) == pytest.approx(SIDES[0], abs=0.1)
    assert {text.dxf.text for text in space.query("TEXT")} == {"front", "top"}


def test_a_page_is_filled_without_a_scale(block: Path) -> None:
    sheet = draw_sheet(block, Layout(("front",), paper=Paper(100.0, 100.0, 10.0)))
    assert np.ptp(extents(sheet)["front"][:, 0]) * MILLIMETRES == pytest.approx(80.0, abs=0.2)


def test_what_does_not_fit_is_told(block: Path) -> None:
    with pytest.raises(ArgumentError, match=r"scale: found a drawing of 200 x .* mm, expected at most 190 x 277 mm"):
        draw_sheet(block, Layout(("front",), paper=Paper(210.0, 297.0, 10.0), scale=2.0))
    with pytest.raises(ArgumentError, match="a perspective view"):
        draw_sheet(block, Layout(paper=Paper(210.0, 297.0, 10.0), scale=0.1))


@pytest.mark.parametrize("suffix", ["svg", "png", "pdf", "dxf"])
def test_sheets_are_written(suffix: str, block: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = printed(capsys, "draw", block, "-o", tmp_path / f"a.{suffix}", "--views", ",".join(NAMES), "--size", 300)
    assert tuple(record["views"]) == NAMES
    assert {camera["projection"] for camera in record["views"].values()} == {"orthographic"}
    assert (record["width"], record["height"]) == (300, 300)
    assert (tmp_path / f"a.{suffix}").stat().st_size > 500
    if suffix == "svg":
        words = [text.text for text in ET.parse(tmp_path / "a.svg").iter(f"{SVG}text")]
        assert words == list(NAMES)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--views", "front,side"), "--views: found 'side', expected some of front,back"),
        (("--views", ","), "--views: found no view"),
        (("--views", "front", "--view", "top"), "--views: found --view beside it"),
        (("--views", "front", "--angle", "second"), "--angle: found 'second', expected one of third, first"),
        (("--angle", "first"), "--angle: found no --views beside it, expected both"),
        (("--scale", "1:2"), "--scale: found no --page beside it, expected both"),
        (("--page", "A4", "--size", "90"), "--page: found --size beside it"),
        (("--page", "B9"), "--page: found 'B9'"),
        (("--page", "A4", "--scale", "1:2"), "--scale: found a perspective view"),
    ],
)
def test_bad_sheets_are_one_line(
    options: tuple[str, ...], message: str, block: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert message in complaint(capsys, "draw", block, "-o", tmp_path / "a.svg", *options)


def test_formats_that_a_sheet_has_not(block: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = complaint(capsys, "draw", block, "-o", tmp_path / "a.json", "--views", "front")
    assert "--views: found a file .json, expected .svg, .png, .pdf, .dxf" in said
    said = complaint(capsys, "draw", block, "-o", tmp_path / "a.png", "--page", "A4")
    assert "--page: found a file .png, expected .svg, .pdf, .dxf" in said


def test_a_cameras_frame_goes_onto_paper(block: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flat = printed(capsys, "draw", block, "-o", tmp_path / "a.svg", "--projection", "orthographic")["camera"]
    (tmp_path / "c.json").write_text(json.dumps(flat))
    options = ("--camera", tmp_path / "c.json", "--page", "A4")
    record = printed(capsys, "draw", block, "-o", tmp_path / "b.svg", *options)
    assert record["camera"]["pixels_per_unit"] == pytest.approx(flat["pixels_per_unit"] * 190 / MILLIMETRES / 768)
