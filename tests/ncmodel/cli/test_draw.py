"""`ncontours draw`: files, folders, JSON, and one clear line for what can't be done."""

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import cv2
import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.cli.draw_job import THUMBNAIL
from ncmodel.cli.main import main
from tests.helpers import analytic
from tests.helpers.mesh_files import write_obj

FAMILIES = "contours,boundaries,creases,suggestive,ridges,valleys,apparent"


@pytest.fixture
def mesh(tmp_path: Path) -> Path:
    return write_obj(tmp_path / "torus.obj", analytic.torus(40, 20))


def run(*arguments: object) -> int:
    return main(["draw", *map(str, arguments)])


@pytest.mark.parametrize("suffix", ["svg", "png", "pdf", "SVG"])
def test_one_mesh_to_a_file(suffix: str, mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(mesh, "-o", tmp_path / f"out.{suffix}", "--size", "200x120") == 0
    assert capsys.readouterr().out == ""
    data = (tmp_path / f"out.{suffix}").read_bytes()
    start = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}[suffix.lower()]
    assert data.startswith(start)


def test_json_says_what_was_done(mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--lines", FAMILIES, "--thresholds", "suggestive=0.002,valleys=off", "--size", "150", "--json")
    assert run(mesh, "-o", tmp_path / "a.svg", *options) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["families"] == [f for f in FAMILIES.split(",") if f != "valleys"]
    assert record["thresholds"] == {"suggestive": 0.002, "ridges": 0.1, "apparent": 0.1}
    assert (record["threshold_unit"], record["score"], record["score_evaluations"]) == ("rtsc", None, 0)
    assert {"load", "normals", "curvature", "visible_contours", "strokes", "write"} <= record["seconds"].keys()
    assert set(record["computed"]) == set(record["seconds"])
    assert record["seconds_total"] >= sum(record["seconds"].values()) * 0.99
    groups = ET.parse(tmp_path / "a.svg").getroot().findall("{http://www.w3.org/2000/svg}g")
    assert {group.attrib["id"] for group in groups} == set(record["strokes"])
    assert record["camera"]["width"] == 150


def test_contours_alone_compute_no_curvature(mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(mesh, "-o", tmp_path / "a.png", "--lines", "contours", "--json") == 0
    computed = set(json.loads(capsys.readouterr().out)["computed"])
    assert computed >= {"load", "normals", "n_dot_v", "scene", "visible_contours", "strokes", "write"}
    curvature = {"curvature", "dcurv", "radial_curvature", "sc_num", "view_curvature", "view_derivative"}
    assert not computed & (curvature | {"feature_size", "creases", "buffers"})


def test_a_threshold_asks_for_its_family(mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(mesh, "-o", tmp_path / "a.svg", "--thresholds", "ridges=0.05", "--json") == 0
    assert "ridges" in json.loads(capsys.readouterr().out)["families"]
    assert run(mesh, "-o", tmp_path / "a.svg", "--lines", "contours", "--thresholds", "ridges=0.05", "--json") == 0
    assert json.loads(capsys.readouterr().out)["families"] == ["contours"]


def test_camera_file_and_size(mesh: Path, tmp_path: Path) -> None:
    camera = Camera((1.0, 2.0, 2.0), width=90, height=60, focal_pixels=100.0)
    (tmp_path / "c.json").write_text(camera.to_json(), encoding="utf-8")
    for size, expected in (((), (60, 90)), (("--size", "180x120"), (120, 180))):
        assert run(mesh, "-o", tmp_path / "a.png", "--camera", tmp_path / "c.json", *size) == 0
        assert np.asarray(cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_GRAYSCALE)).shape == expected


@pytest.mark.parametrize("suffix", ["svg", "png", "pdf"])
def test_less_detail_draws_less(suffix: str, mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lengths, whole, lines = [], tmp_path / f"whole.{suffix}", ("--lines", "contours,apparent")
    assert run(mesh, "-o", whole, *lines) == 0
    for options in (("--detail", "0"), ("--detail", "0.4"), ("--min-length", "40"), ("--detail", "1")):
        assert run(mesh, "-o", tmp_path / f"a.{suffix}", *lines, *options, "--json") == 0
        record = json.loads(capsys.readouterr().out)
        assert record[options[0][2:].replace("-", "_")] == float(options[1])
        assert run(mesh, "-o", tmp_path / "a.json", *lines, *options) == 0
        drawn = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
        steps = [np.diff(np.array(stroke["points"])[:, :2], axis=0) for stroke in drawn["strokes"]]
        lengths.append(float(np.linalg.norm(np.concatenate(steps), axis=1).sum()))
    assert (tmp_path / f"a.{suffix}").read_bytes() == whole.read_bytes()
    assert lengths[0] < lengths[1] < lengths[3]
    assert lengths[2] < lengths[3]


def test_a_folder_of_drawings_of_less_detail(mesh: Path, tmp_path: Path) -> None:
    other = write_obj(tmp_path / "other.obj", analytic.torus(30, 15))
    for name, detail in (("less", "0"), ("more", "1")):
        assert run(mesh, other, "-o", tmp_path / name, "--detail", detail) == 0
    for file in ("torus.svg", "other.svg"):
        assert len((tmp_path / "less" / file).read_bytes()) < len((tmp_path / "more" / file).read_bytes())


@pytest.mark.parametrize("options", [("--detail", "2"), ("--detail", "nan"), ("--min-length", "-1")])
def test_detail_out_of_range_is_refused(
    options: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(tmp_path / "absent.obj", "-o", tmp_path / "a.svg", *options) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"ncontours: {options[0]}: found ")
    assert error.count("\n") == 1


def test_style_options(mesh: Path, tmp_path: Path) -> None:
    out = tmp_path / "a.svg"
    options = ("--width", "4", "--background", "#fff8e0", "--sort", "--tolerance", "1", "--lines", "contours")
    assert run(mesh, "-o", out, *options) == 0
    text = out.read_text(encoding="utf-8")
    assert 'fill="#fff8e0"' in text
    assert 'stroke-width="4"' in text
    points = text.count(" ")
    assert run(mesh, "-o", out, *options[:-4], "--tolerance", "0", "--lines", "contours") == 0
    assert out.read_text(encoding="utf-8").count(" ") > 2 * points


def test_z_up(tmp_path: Path) -> None:
    vertices, faces = analytic.torus(24, 12)
    write_obj(tmp_path / "y.obj", (vertices, faces))
    write_obj(tmp_path / "z.obj", (vertices[:, [0, 2, 1]] * [1, -1, 1], faces))
    for name, up in (("y", "y"), ("z", "z")):
        assert run(tmp_path / f"{name}.obj", "-o", tmp_path / f"{name}.png", "--up", up, "--size", "90") == 0
    images = [np.asarray(cv2.imread(str(tmp_path / f"{n}.png"), cv2.IMREAD_GRAYSCALE), dtype=int) for n in "yz"]
    assert np.abs(images[0] - images[1]).mean() < 1.0


def test_many_meshes_to_a_folder_with_a_contact_sheet(
    mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "other").mkdir()
    twin = write_obj(tmp_path / "other" / "torus.obj", analytic.cube())
    assert run(mesh, twin, "-o", tmp_path / "out", "--format", "png", "--size", "64", "--json") == 0
    record = json.loads(capsys.readouterr().out)
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["contact-sheet.png", "torus-2.png", "torus.png"]
    assert [Path(d["output"]).name for d in record["drawings"]] == ["torus.png", "torus-2.png"]
    assert record["failed"] == []
    sheet = np.asarray(cv2.imread(record["contact_sheet"], cv2.IMREAD_GRAYSCALE))
    height, width = sheet.shape
    assert width > 2 * THUMBNAIL
    assert height > THUMBNAIL
    assert (sheet[20:THUMBNAIL, 20 : width // 2 - 20] < 200).any()
    assert (sheet[20:THUMBNAIL, width // 2 + 20 : -20] < 200).any()
    assert (sheet[THUMBNAIL + 16 :] < 128).any()  # names


def test_one_mesh_to_a_folder(mesh: Path, tmp_path: Path) -> None:
    assert run(mesh, "-o", tmp_path / "new", "--format", "png", "--size", "64") == 0
    assert run(mesh, "-o", tmp_path / "new", "--size", "64") == 0
    assert {p.name for p in (tmp_path / "new").iterdir()} == {"torus.png", "torus.svg", "contact-sheet.png"}


def test_infinite_threshold_is_no_number_in_json(
    mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(mesh, "-o", tmp_path / "a.svg", "--thresholds", "apparent=inf", "--json") == 0
    record = json.loads(capsys.readouterr().out)
    assert record["thresholds"]["apparent"] is None
    assert "apparent" not in record["strokes"]


def test_one_bad_mesh_does_not_stop_the_others(mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = tmp_path / "bad.obj"
    bad.write_text("nothing\n", encoding="utf-8")
    assert run(bad, mesh, "-o", tmp_path / "out", "--size", "64", "--json") == 1
    streams = capsys.readouterr()
    record = json.loads(streams.out)
    assert [Path(f["mesh"]).name for f in record["failed"]] == ["bad.obj"]
    assert (tmp_path / "out" / "torus.svg").is_file()
    assert "1 of 2 meshes failed" in streams.err.splitlines()[-1]
    assert str(bad) in streams.err.splitlines()[-1]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--thresholds", "contours=1"), "--thresholds: found 'contours', expected FAMILY=VALUE"),
        (("--thresholds", "ridges"), "--thresholds: found 'ridges'"),
        (("--thresholds", "ridges=much"), "--thresholds: found ridges=much, expected a number or off"),
        (("--thresholds", "ridges=-1"), "--thresholds: found ridges=-1.0, expected a number >= 0"),
        (("--thresholds", "ridges=nan"), "--thresholds: found ridges=nan, expected a number >= 0"),
        (("--lines", ","), "--lines: found no family"),
        (("--lines", "hatching"), "--lines: found 'hatching'"),
        (("--size", "0"), "size 0 x 0"),
        (("--size", "big"), "--size: found 'big'"),
        (("--width", "0"), "--width: found 0.0"),
        (("--background", "mauve"), "--background: found 'mauve'"),
        (("--tolerance", "-1"), "tolerance: found -1.0"),
        (("--crease-angle", "0"), "crease angle: found 0.0"),
        (("--preset", "best"), "preset: found 'best'"),
        (("--up", "x"), "--up: found 'x'"),
        (("--camera", "nowhere.json"), "nowhere.json"),
        (("--camera", "nowhere.json", "--azimuth", "3"), "--camera: found --azimuth or --elevation beside it"),
        (("--azimuth", "nan"), "azimuth"),
        (("--model", "nowhere.ckpt"), "nowhere.ckpt"),
    ],
)
def test_bad_options_are_one_line(
    options: tuple[str, ...], message: str, mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(mesh, "-o", tmp_path / "a.svg", *options) == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert message in streams.err
    assert len(streams.err.splitlines()) == 1
    assert not (tmp_path / "a.svg").exists()


def test_bad_output(mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for output, message in (("a.gif", "suffix"), ("a", "suffix"), ("none/a.svg", "there is no folder")):
        assert run(mesh, "-o", tmp_path / output) == 2
        assert message in capsys.readouterr().err
    assert run(mesh, mesh, "-o", mesh) == 2
    assert "is a file, expected a folder" in capsys.readouterr().err
    for arguments in ((mesh, mesh, "-o", tmp_path / "two.svg"), (mesh, "-o", tmp_path / "one.png", "--format", "png")):
        assert run(*arguments) == 2
        assert "is named like a file, expected a folder" in capsys.readouterr().err
    assert run(mesh, "-o", tmp_path / "f", "--format", "") == 2
    assert "--format: found ''" in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {mesh.name}
    assert run(mesh, mesh, "-o", tmp_path / "f", "--format", "gif") == 2
    assert "--format: found 'gif'" in capsys.readouterr().err


def test_many_meshes_keep_their_notes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points = np.random.default_rng(0).normal(size=(400, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    for name in ("one", "two"):
        np.savetxt(tmp_path / f"{name}.xyz", points)
    meshes = [str(tmp_path / f"{name}.xyz") for name in ("one", "two")]
    assert main(["draw", *meshes, "-o", str(tmp_path / "drawings"), "--size", "64"]) == 0
    told = capsys.readouterr().err
    assert all(f"{mesh}: reconstructed" in told for mesh in meshes)


NAMES = ["two\nlines", "\x01\x1b[31m", "\udcff", "\u202eback", "tab\t", "<&>\"'", "日本 ü", " "]


@pytest.mark.parametrize("name", NAMES)
def test_any_file_name_beside_others(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Drawn under its name; in what is said of it, letters that can't be seen are written out."""
    good, bad = write_obj(tmp_path / f"{name}.obj", analytic.torus(40)), tmp_path / f"bad{name}.obj"
    bad.write_bytes(b"f 1 2 3")
    assert run(good, bad, "-o", tmp_path / "out", "--size", "64", "--lines", "contours") == 1
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == sorted(["contact-sheet.png", f"{name}.svg"])
    *_, last = capsys.readouterr().err.rstrip("\n").split("\n")
    assert last.startswith("ncontours: 1 of 2 meshes failed: ")
    assert last.isprintable()


def test_names_that_some_systems_hold_for_the_same(tmp_path: Path) -> None:
    """Capitals, and an accent beside its letter: none of the drawings replaces another."""
    names = ["a/st\u00fchl", "a/Stuhl", "b/stuhl", "b/stu\u0308hl"]
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        write_obj(tmp_path / f"{name}.obj", analytic.torus(40))
    meshes = [tmp_path / f"{name}.obj" for name in names]
    assert run(*meshes, "-o", tmp_path / "out", "--size", "64", "--lines", "contours") == 0
    written = {path.stem for path in (tmp_path / "out").glob("*.svg")}
    assert written == {"st\u00fchl", "Stuhl", "stuhl-2", "stu\u0308hl-2"}
