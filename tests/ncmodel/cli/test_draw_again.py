"""`ncontours draw --again`, --colors and --curves: what files say of themselves, and how their lines are written."""

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ncmodel import draw_shape
from ncmodel.camera import Camera
from ncmodel.cli.main import main
from ncmodel.export.colours import PURE
from tests.helpers import analytic
from tests.helpers.commands import complaint, printed
from tests.helpers.mesh_files import write_obj
from tests.helpers.pictures import SVG


@pytest.fixture
def mesh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    vertices, faces = analytic.torus(40, 20)
    return write_obj(tmp_path / "torus.obj", (vertices * (1 + 0.2 * np.sin(9 * vertices[:, :1])), faces))


def draw(*words: object) -> None:
    assert main(["draw", *map(str, words)]) == 0


@pytest.mark.parametrize("suffix", ["svg", "pdf"])
@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--view", "top", "--lines", "contours,apparent", "--thresholds", "apparent=0.3", "--size", "200x100"),
        ("--views", "front,right", "--sort", "--colors", "--hidden", "dashed", "--width", "3"),
        ("--page", "A5", "--curves", "--detail", "0.4"),
        ("--camera", "camera.json", "--projection", "orthographic", "--up", "z"),
    ],
)
def test_a_file_is_drawn_again_with_the_same_bytes(suffix: str, options: tuple[str, ...], mesh: Path) -> None:
    camera = Path("camera.json")
    camera.write_text(Camera((1.0, 2.0, 2.0), width=160, height=120, focal_pixels=300.0).to_json())
    out, copy = Path(f"a.{suffix}"), Path(f"b.{suffix}")
    draw("torus.obj", "-o", out, *options)
    drawn = out.read_bytes()
    camera.unlink()  # the file knows what it held
    Path("elsewhere").mkdir()
    for other in (copy, "elsewhere" / copy):
        draw("--again", out, "-o", other)
        assert other.read_bytes() == drawn
    out.touch()
    draw("--again", out)
    assert out.read_bytes() == drawn


def test_a_file_says_how_it_was_drawn(mesh: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = printed(capsys, "draw", mesh, "-o", "a.svg", "--detail", "0.5", "--thresholds", "apparent=0.3")
    said = json.loads(ET.parse("a.svg").findtext(f"{SVG}metadata") or "")
    assert said["program"].startswith("neural-contours ")
    assert said["mesh"] == "torus.obj"
    assert said["options"] == {"detail": 0.5, "thresholds": "apparent=0.3"}
    assert said["camera"] == record["camera"]
    assert said["thresholds"] == record["thresholds"]


def test_another_mesh_is_drawn_in_the_same_way(mesh: Path) -> None:
    write_obj(Path("cube.obj"), analytic.cube())
    draw(mesh, "-o", "a.svg", "--view", "top", "--size", 100)
    draw("cube.obj", "--again", "a.svg", "-o", "b.svg")
    draw("cube.obj", "-o", "c.svg", "--view", "top", "--size", 100)
    assert Path("b.svg").read_bytes() == Path("c.svg").read_bytes()


def test_a_mesh_that_has_changed_is_told(mesh: Path, capsys: pytest.CaptureFixture[str]) -> None:
    draw(mesh, "-o", "a.svg")
    write_obj(mesh, analytic.cube())
    draw("--again", "a.svg", "-o", "b.svg")
    assert "isn't what a.svg was drawn from: it has changed" in capsys.readouterr().err


def test_what_cannot_be_drawn_again_is_one_line(mesh: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("other.svg").write_text("<svg/>")
    assert "other.svg: nothing that tells how it was drawn" in complaint(capsys, "draw", "--again", "other.svg")
    assert "gone.svg: can't be read" in complaint(capsys, "draw", "--again", "gone.svg")
    draw(mesh, "-o", "a.svg", "--size", 90)
    assert "--again: found other options" in complaint(capsys, "draw", "--again", "a.svg", "--detail", 0.5)
    assert "--again: found 2 meshes" in complaint(capsys, "draw", mesh, mesh, "--again", "a.svg")
    text = Path("a.svg").read_text()
    for before, after in (('"size"', '"colour"'), ('"90"', "90"), ('"eye"', '"nose"')):
        Path("b.svg").write_text(text.replace(before, after))
        assert "b.svg" in complaint(capsys, "draw", "--again", "b.svg")
    mesh.unlink()
    assert "torus.obj: no such file" in complaint(capsys, "draw", "--again", "a.svg")
    assert "--output" in complaint(capsys, "draw", mesh)


def test_colours_are_one_a_family(mesh: Path) -> None:
    options = ("--hidden", "dashed", "--lines", "contours,suggestive,ridges,apparent")
    draw(mesh, "-o", "a.svg", *options, "--colors")
    groups = {group.get("id"): group for group in ET.parse("a.svg").iter(f"{SVG}g")}
    assert set(groups) == {"contours", "suggestive", "ridges", "apparent", "hidden"}
    for name, group in groups.items():
        expected = "#{:02x}{:02x}{:02x}".format(*PURE.get(str(name), (0, 0, 0)))
        assert group.get("stroke") == expected
        assert {tuple(sorted(path.attrib)) for path in group} == {("d",)}
    draw(mesh, "-o", "b.svg", *options)
    faded = ET.parse("b.svg")
    assert len(list(faded.iter(f"{SVG}path"))) > sum(len(group) for group in groups.values())


@pytest.mark.parametrize("background", ["none", "transparent", "black"])
def test_pixels_have_the_colours(background: str, mesh: Path) -> None:
    import cv2

    paper = () if background == "none" else ("--background", background)
    draw(mesh, "-o", "a.png", "--colors", "--lines", "contours,ridges", *paper)
    image = cv2.imread("a.png", cv2.IMREAD_UNCHANGED)
    assert image is not None
    assert image.shape[2] == (4 if background == "transparent" else 3)
    colours = {tuple(pixel) for pixel in image[..., 2::-1].reshape(-1, 3).tolist()}
    line = (255, 255, 255) if background == "black" else (0, 0, 0)
    assert {PURE["ridges"], line} <= colours


def test_layers_have_the_colours(mesh: Path) -> None:
    ezdxf = pytest.importorskip("ezdxf")
    draw(mesh, "-o", "a.dxf", "--colors", "--lines", "contours,ridges")
    layers = ezdxf.readfile("a.dxf").layers
    assert layers.get("ridges").rgb == PURE["ridges"]
    assert layers.get("contours").rgb is None


def test_curves_take_less_room(mesh: Path) -> None:
    """About half of it in SVG; PDF is packed, so that shorter numbers save little there."""
    draw_shape(mesh, tolerance=0.25).save("a.svg")
    draw_shape(mesh, tolerance=0.025).save("b.svg", curve=0.225)
    plain, curved = (Path(f"{name}.svg").stat().st_size for name in "ab")
    assert curved < 0.6 * plain


def test_curves_show_the_same_picture(mesh: Path) -> None:
    """Where its strokes begin, the other has lines, too: its coordinates are tenths of a pixel."""
    draw(mesh, "-o", "a.svg", "--lines", "contours", "--tolerance", "0.02")
    draw(mesh, "-o", "b.svg", "--lines", "contours", "--curves")
    root = ET.parse("b.svg").getroot()
    assert (root.get("width"), root.get("viewBox")) == ("768", "0 0 7680 7680")
    starts = [path.attrib["d"].lstrip("M") for path in root.iter(f"{SVG}path")]
    begins = np.array([re.split(r"[lc]", text)[0].split() for text in starts], dtype=float) / 10
    plain = [re.findall(r"[\d.]+", path.attrib["d"]) for path in ET.parse("a.svg").iter(f"{SVG}path")]
    corners = np.concatenate([np.array(words, dtype=float).reshape(-1, 2) for words in plain])
    assert cKDTree(corners).query(begins)[0].max() < 3.0


def test_curves_that_make_no_sense_are_one_line(mesh: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = complaint(capsys, "draw", mesh, "-o", "a.dxf", "--curves")
    assert "--curves: found a file .dxf, expected .svg, .pdf" in said
    said = complaint(capsys, "draw", mesh, "-o", "a.svg", "--curves", "--tolerance", 0)
    assert "--curves: found a tolerance of 0" in said
