"""Extreme input through `draw` and `ncontours`: a right result or one clear line, in every format.

What each case comes to is in docs/geometry.md, "At the edges of the definitions".
"""

import json
import re
import xml.etree.ElementTree as ET
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.cli.main import main
from ncmodel.drawing.draw import draw
from ncmodel.drawing.drawing import Drawing
from ncmodel.export.pdf import pdf
from ncmodel.mesh.load import make_mesh
from ncmodel.types import Floats, Ints, LineFamily, Thresholds
from tests.helpers import analytic
from tests.helpers.extreme_meshes import MESHES, Builder, slivers
from tests.helpers.mesh_files import write_obj
from tests.helpers.views import eyes

ALL = ",".join(LineFamily)
TORUS = analytic.torus(18, 10)


def edge_on() -> tuple[Floats, Ints]:
    """A triangle in the plane of an eye in front."""
    return np.array([[0.0, 0, 0], [0, 1, 0], [0, 0.5, 1]]), np.array([[0, 1, 2]])


DRAWN: dict[str, Builder] = {
    **MESHES,
    "slivers far away": lambda: (slivers()[0] + 1e7, slivers()[1]),
    "tiny slivers": lambda: (slivers()[0] * 1e-12, slivers()[1]),
    "nearly overflowing": lambda: (TORUS[0] * 1e308, TORUS[1]),
    "denormal": lambda: (TORUS[0] * 1e-320, TORUS[1]),
    "edge-on": edge_on,
    "beside a speck": lambda: (
        np.concatenate([TORUS[0], TORUS[0] * 1e-8 + 1]),
        np.concatenate([TORUS[1], TORUS[1] + len(TORUS[0])]),
    ),
    "twice, once inside out": lambda: (
        np.concatenate([TORUS[0]] * 2),
        np.concatenate([TORUS[1], TORUS[1][:, ::-1] + len(TORUS[0])]),
    ),
    "faces at random": lambda: (
        np.random.default_rng(1).standard_cauchy((60, 3)) ** 3,
        np.random.default_rng(2).integers(0, 60, (120, 3)),
    ),
}


def check(drawing: Drawing) -> None:
    """Raise if there is a number that isn't one anywhere."""
    for stroke in drawing.strokes:
        assert np.isfinite(stroke.points).all()
        assert ((stroke.alpha >= 0) & (stroke.alpha <= 1)).all()
    ink = drawing.ink()
    assert np.isfinite(ink).all()
    assert ((ink >= 0) & (ink <= 1)).all()
    paths = re.findall(r' d="M([^"]+)"', drawing.svg())
    numbers = np.array([float(word) for path in paths for word in path.split()])
    # Clipped to the picture and a margin of lines' width.
    assert (np.abs(numbers) < 10 * max(drawing.width, drawing.height) + 10).all()
    pdf(drawing.sorted_for_pen().picture())


@pytest.mark.parametrize("name", DRAWN)
def test_every_view_of_every_mesh_is_drawn(name: str) -> None:
    mesh = make_mesh(*DRAWN[name](), name)
    views = {**eyes(mesh), "in its plane": (0.0, 0.0, 3.0), "below": (0.0, -3.0, 0.0)}
    strokes = 0
    for eye in views.values():
        for target in ((3.0, 0.1, 0.2), (0.0, 0.0, 0.0)):
            camera = Camera(eye, target, width=64, height=40, focal_pixels=80.0)
            drawing = draw(mesh, camera, list(LineFamily))
            check(drawing)
            strokes += len(drawing.strokes)
    assert strokes > 3, "not all views are blank"


@pytest.mark.parametrize("size", [(1, 1), (1, 200), (200, 1)])
@pytest.mark.parametrize("threshold", [0.0, 1e-320, 1e308, float("inf")])
def test_sizes_and_thresholds(size: tuple[int, int], threshold: float) -> None:
    limits = Thresholds(threshold, threshold, threshold, threshold)
    for name in ("tiny", "slivers", "sphere", "single triangle"):
        drawing = draw(make_mesh(*MESHES[name]()), lines=list(LineFamily), thresholds=limits, size=size)
        check(drawing)
        if threshold > 1:
            assert {stroke.family for stroke in drawing.strokes} <= {"contours", "boundaries", "creases"}
        elif size != (1, 1):
            assert drawing.strokes, name


def finite_numbers(path: Path) -> bool:
    """Whether a written file is whole, shows lines, and holds nothing but numbers."""
    if path.suffix == ".svg":
        document = ET.canonicalize(path.read_text(encoding="utf-8"))
        return ' d="M' in document and not re.search(r' d="[^"]*[a-z]', document)
    if path.suffix == ".png":
        image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        return image is not None and int(image.min()) < 255
    if path.suffix == ".pdf":
        content = zlib.decompress(path.read_bytes().split(b"stream\n", 1)[1].split(b"\nendstream", 1)[0])
        return b" l" in content and not re.search(rb"nan|inf|\de", content)
    with np.load(path) as arrays:
        return len(arrays) > 20 and all(bool(np.isfinite(arrays[key]).all()) for key in arrays)


def command(folder: Path, name: str, geometry: tuple[Floats, Ints], suffix: str) -> tuple[int, Path]:
    mesh, output = write_obj(folder / f"{name}.obj", geometry), folder / f"{name}.{suffix}"
    (folder / "camera.json").write_text(Camera((1.3, 1.1, 2.4)).to_json(), encoding="utf-8")
    if suffix == "npz":
        return main(["features", str(mesh), "--camera", str(folder / "camera.json"), "-o", str(output)]), output
    return main(["draw", str(mesh), "-o", str(output), "--lines", ALL, "--size", "90x70"]), output


@pytest.mark.parametrize("suffix", ["svg", "png", "pdf", "npz"])
def test_every_mesh_becomes_every_file(suffix: str, tmp_path: Path) -> None:
    for name, make in DRAWN.items():
        status, output = command(tmp_path, name, make(), suffix)
        assert status == 0, name
        assert finite_numbers(output), name


def spoilt(value: float, scale: float = 1.0) -> tuple[Floats, Ints]:
    vertices = TORUS[0] * scale
    vertices[3, 0] = value
    return vertices, TORUS[1]


REFUSED = {
    "nan": (spoilt(np.nan), "vertex 3 is [nan, "),
    "nan and tiny": (spoilt(np.nan, 1e-12), "vertex 3 is [nan, "),
    "infinite": (spoilt(np.inf), "vertex 3 is [inf, "),
    "infinite and huge": (spoilt(-np.inf, 1e12), "vertex 3 is [-inf, "),
    "nan that no face uses": ((np.concatenate([TORUS[0], [[np.nan] * 3]]), TORUS[1]), "vertex 180 is [nan, "),
    "no faces": ((TORUS[0][:9], TORUS[1][:0]), "no faces, and 9 distinct points"),
    "nothing": ((TORUS[0][:0], TORUS[1][:0]), "no vertices"),
    "one point": ((np.zeros((3, 3)), np.array([[0, 1, 2]])), "all faces lie at one point"),
}


@pytest.mark.parametrize("suffix", ["svg", "npz"])
@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_shape_is_one_clear_line(
    name: str, suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    geometry, message = REFUSED[name]
    status, output = command(tmp_path, name, geometry, suffix)
    streams = capsys.readouterr()
    assert status == 2
    assert not output.exists()
    assert len(streams.err.splitlines()) == 1
    assert message in streams.err
    assert f"{name}.obj" in streams.err


def test_the_eye_inside_and_a_large_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = write_obj(tmp_path / "torus.obj", analytic.torus(60, 30))
    camera = Camera((0.37, 0.0, 0.0), (0.3, 0.0, -1.0), width=8192, height=4096, focal_pixels=3000.0)
    (tmp_path / "camera.json").write_text(camera.to_json(), encoding="utf-8")
    options = ["--camera", str(tmp_path / "camera.json"), "--lines", ALL, "--json"]
    assert main(["draw", str(mesh), "-o", str(tmp_path / "a.png"), *options]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["width"], record["height"]) == (8192, 4096)
    assert np.asarray(cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_GRAYSCALE)).shape == (4096, 8192)
