"""Collections of people's drawings, a small one made in each layout, read as references."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from eval.people.poses import Pose
from ncmodel.camera import Camera
from ncmodel.geometry.raycast import RayScene
from ncmodel.images import from_ink, read_grey, write_png
from ncmodel.mesh.load import load_mesh, read_geometry
from tests.helpers import analytic
from tests.helpers.commands import complaint, printed
from tests.helpers.mesh_files import write_obj

SQUARE = [[20, 20], [80, 20], [80, 80], [20, 80], [20, 20]]


def scan(path: Path, size: tuple[int, int] = (1024, 768)) -> None:
    """A picture with a drawn rectangle."""
    path.parent.mkdir(parents=True, exist_ok=True)
    ink = np.zeros(size[::-1])
    ink[100:600, 200:203] = ink[100:600, 700:703] = ink[100:103, 200:700] = ink[597:600, 200:700] = 1.0
    write_png(path, from_ink(ink))


def as_json(path: Path, record: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(record), encoding="utf-8")


def box_mesh(folder: Path, name: str) -> Path:
    """A box off the origin and larger than 1, as collections have them."""
    folder.mkdir(parents=True, exist_ok=True)
    vertices, faces = analytic.cube()
    return write_obj(folder / f"{name}.obj", (vertices * [4.0, 2.0, 3.0] + [7.0, 1.0, -2.0], faces))


def drawn(path: Path) -> int:
    """Pixels that count as drawn."""
    return int((read_grey(path) < 0.5).sum())


def test_scans_of_cole_with_cameras_become_references_that_evaluate_reads(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("box_a_ann", "box_a_ben", "box_b_ann"):
        scan(tmp_path / "cole" / f"{name}.png")
    mesh = load_mesh(box_mesh(tmp_path / "models", "box"))
    (tmp_path / "cams").mkdir()
    for view, azimuth in (("a", 20.0), ("b", 70.0)):
        camera = Camera.orbit(mesh.used_vertices, azimuth, 30.0, size=(1024, 768))
        (tmp_path / "cams" / f"box_{view}.json").write_text(camera.to_json())
    out = tmp_path / "people"
    command = ["references", tmp_path / "cole", "cole2008", "-o", out, "--names", "{shape}_{view}_{artist}"]
    record = printed(capsys, *command, "--meshes", tmp_path / "models", "--cameras", tmp_path / "cams")
    assert (record["drawings"], record["views"], record["cameras"]) == (3, 2, 2)
    files = {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}
    assert files == {
        "references.json", "references/box_a/ann.png", "references/box_a/ben.png", "references/box_b/ann.png",
        "meshes/box.obj", "cameras/box_a.json", "cameras/box_b.json", "silhouettes/box_a.png", "silhouettes/box_b.png",
    }  # fmt: skip
    kept = json.loads((out / "references.json").read_text())
    assert kept["layout"] == "cole2008"
    assert "ask its authors" in kept["licence"]
    assert [drawing["source"] for drawing in kept["drawings"]] == ["box_a_ann.png", "box_a_ben.png", "box_b_ann.png"]
    seen = RayScene(mesh).render(Camera.load(out / "cameras" / "box_a.json")).hit
    np.testing.assert_array_equal(read_grey(out / "silhouettes" / "box_a.png") < 0.5, seen)
    scan(tmp_path / "drawings" / "box_a.png")
    evaluated = ["evaluate", "--drawings", tmp_path / "drawings", "--references", out]
    with pytest.raises(AssertionError):  # box_b has no drawing: exit status 1
        printed(capsys, *evaluated, "-o", tmp_path / "r")
    report = json.loads((tmp_path / "r" / "report.json").read_text())
    assert [row["reference"] for row in report["drawings"]] == [f"references/box_a/{who}.png" for who in ("ann", "ben")]
    assert report["mean"]["f1"] == 1.0


def test_what_cant_be_known_is_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scan(tmp_path / "cole" / "box_a_ann.png")
    command = ["references", tmp_path / "cole", "cole2008", "-o", tmp_path / "out"]
    assert "--names: found none, and no public page tells what is in its files' names" in complaint(capsys, *command)
    said = complaint(capsys, *command, "--names", "{shape}-{artist}")
    assert "box_a_ann.png: the name 'box_a_ann'; expected {shape}-{artist}, as was said of names" in said
    scan(tmp_path / "small" / "box_a_ann.png", (800, 700))
    small = ["references", tmp_path / "small", "cole2008", "-o", tmp_path / "out", "--names", "{shape}_{view}_{artist}"]
    assert "800 x 700 pixels; expected 1024 x 768" in complaint(capsys, *small)
    assert "--layout: found 'colle', expected one of cole2008" in complaint(
        capsys, "references", tmp_path / "cole", "colle", "-o", tmp_path / "out"
    )
    assert "--cameras: found fit and no meshes" in complaint(capsys, *command, "--names", "x", "--cameras", "fit")


def test_strokes_of_differsketching(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    strokes = [
        {"id": 1, "draw_type": 0, "path": SQUARE, "width": 4},
        {"id": 2, "draw_type": 1, "path": [[0, 400], [799, 400]], "width": 4},
    ]
    as_json(tmp_path / "data" / "Animal" / "reg_json" / "P021_8_1_SAH_210.json", {"strokes": strokes})
    out = tmp_path / "out"
    record = printed(
        capsys, "references", tmp_path / "data", "differsketching", "-o", out, "--names", "{artist}_{}_{view}_{shape}"
    )
    assert record["drawings"] == 1
    path = out / "references" / "Animal-SAH_210_1" / "P021.png"
    assert read_grey(path).shape == (800, 800)
    assert drawn(path) == pytest.approx(4 * 60 * 2, rel=0.1)
    assert read_grey(path)[395:405].min() > 0.9, "what was erased isn't drawn"


def test_tracings_and_freehand_drawings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = ",".join(f"{time},{x},{y}" for time, (x, y) in enumerate(SQUARE))
    data = {"fossil.png": {"u7": [{"path": text, "pressure": "", "color": "#000000", "width": 2, "opacity": 1.0}]}}
    as_json(tmp_path / "json" / "drawings_registered.json", data)
    scan(tmp_path / "png" / "png" / "tracings" / "fossil&u1.png", (800, 800))
    points = "L".join(f"{x},{y}" for x, y in SQUARE)
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" width="800" height="800"><path d="M{points}"/></svg>'
    (tmp_path / "svg" / "svg" / "drawings_registered").mkdir(parents=True)
    (tmp_path / "svg" / "svg" / "drawings_registered" / "fossil&u9.svg").write_text(svg)
    counts = []
    for folder, who, more in (("json", "u7", ()), ("svg", "u9", ()), ("png", "u1", ("--group", "tracings"))):
        out = tmp_path / f"out-{folder}"
        printed(capsys, "references", tmp_path / folder, "tracing-freehand", "-o", out, *more)
        counts.append(drawn(out / "references" / "fossil_0" / f"{who}.png"))
        assert "CC BY-NC-SA 4.0" in json.loads((out / "references.json").read_text())["licence"]
    assert counts[0] == counts[1] == pytest.approx(4 * 60 * 2, rel=0.1)
    assert counts[2] > 0
    (tmp_path / "svg" / "svg" / "drawings_registered" / "fossil&u9.svg").write_text(svg.replace("L", "C"))
    said = complaint(capsys, "references", tmp_path / "svg", "tracing-freehand", "-o", tmp_path / "x")
    assert "a path with other pieces" in said


def opensketch(root: Path, up: float = 1.0) -> tuple[Camera, np.ndarray]:
    """A sketch of a box by one designer, its camera off the canvas's middle; and where the corners are sketched."""
    path = box_mesh(root / "objects_obj_files", "house")
    mesh, raw = load_mesh(path), read_geometry(path)[0]
    low, high = raw.min(axis=0), raw.max(axis=0)
    centre, size = (low + high) / 2, float((high - low).max())
    camera = Camera.orbit(mesh.used_vertices, 40.0, 25.0, size=(600, 600))
    u, v = 0.1, -0.2
    view = np.eye(4)
    view[:3, :3] = camera.rotation
    view[:3, 3] = -camera.rotation @ (np.asarray(camera.eye) * size + centre)
    found = {
        "C": (np.asarray(camera.eye) * size + centre).tolist(), "f": camera.focal_pixels / 300,
        "u": u, "v": up * v, "skew": 0.0, "mvMatrix": view.T.tolist(),
    }  # fmt: skip
    as_json(root / "camera_parameters" / "Student9_house_view1_camparam.json", {"width": 600, "restricted": found})
    sketched = camera.project(mesh.vertices)[:, :2] + [300 * u, -300 * v]
    marks = {"points_2D_sketch": sketched.tolist(), "points_3D_object": raw.tolist()}
    as_json(root / "correspondanciesJSON" / "student9_house_v1_points.json", marks)
    strokes = [
        {"is_removed": False, "points": [{"x": x, "y": y, "p": 0.5, "t": 0} for x, y in sketched[[0, 1]].tolist()]},
        {"is_removed": True, "points": [{"x": 0, "y": 0, "p": 1, "t": 0}, {"x": 599, "y": 599, "p": 1, "t": 1}]},
    ]
    record = {"canvas": {"width": 600, "height": 600, "pen_width": 1.5}, "strokes": strokes}
    as_json(root / "sketches_json_first_viewpoint" / "student9" / "house" / "view1_presentation.json", record)
    return camera, sketched


def test_sketches_of_opensketch_keep_their_cameras(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hidden, sketched = opensketch(tmp_path / "os")
    out = tmp_path / "out"
    command = ["references", tmp_path / "os", "opensketch", "--meshes", tmp_path / "os" / "objects_obj_files"]
    printed(capsys, *command, "--cameras", "given", "-o", out)
    found = Camera.load(out / "cameras" / "house_student9-view1.json")
    assert Pose.of(found).angle_to(Pose.of(hidden)) < 1e-6
    assert found.focal_pixels == pytest.approx(hidden.focal_pixels)
    # The principal point, 30 px right of and 60 px below the canvas's middle, is the middle of a wider one.
    assert (found.width, found.height) == (660, 720)
    corners = found.project(load_mesh(out / "meshes" / "house.obj").vertices)[:, :2]
    shift = np.array([660, 720]) / 2 - np.array([330, 360])
    np.testing.assert_allclose(corners, sketched + shift, atol=1e-6)
    picture = read_grey(out / "references" / "house_student9-view1" / "student9.png")
    middle = (corners[0] + corners[1]) / 2
    assert picture.shape == (720, 660)
    assert picture[int(middle[1]) - 1 : int(middle[1]) + 2, int(middle[0]) - 1 : int(middle[0]) + 2].min() < 0.3
    opensketch(tmp_path / "other", up=-1.0)
    command = ["references", tmp_path / "other", "opensketch", "--meshes", tmp_path / "other" / "objects_obj_files"]
    said = complaint(capsys, *command, "--cameras", "given", "-o", tmp_path / "x")
    assert "marked points are 120 pixels off in the mean; expected at most 60: another convention; fit them" in said
