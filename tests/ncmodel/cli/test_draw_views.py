"""`ncontours draw --view`, --hidden, and what else it writes than pictures."""

import json
from pathlib import Path

import numpy as np
import pytest

from ncmodel.camera import VIEWS, Camera
from ncmodel.cli.main import main
from tests.helpers.commands import complaint, printed
from tests.helpers.dirty import box
from tests.helpers.mesh_files import write_obj

LOOKS = {
    "front": ((0, 0, 1), (1, 0, 0)),
    "back": ((0, 0, -1), (-1, 0, 0)),
    "left": ((-1, 0, 0), (0, 0, 1)),
    "right": ((1, 0, 0), (0, 0, -1)),
    "top": ((0, 1, 0), (1, 0, 0)),
    "bottom": ((0, -1, 0), (1, 0, 0)),
}
"""View -> direction of the eye, and what is on the right."""


@pytest.fixture
def mesh(tmp_path: Path) -> Path:
    return write_obj(tmp_path / "cube.obj", box())


@pytest.mark.parametrize("view", LOOKS)
def test_named_views(view: str) -> None:
    camera = Camera.orbit(np.eye(3), *VIEWS[view])
    right, _, back = camera.rotation
    np.testing.assert_allclose(back, LOOKS[view][0], atol=1e-9)
    np.testing.assert_allclose(right, LOOKS[view][1], atol=1e-9)


def test_axes_are_equally_long_in_iso() -> None:
    camera = Camera.orbit(np.eye(3), *VIEWS["iso"])
    np.testing.assert_allclose(np.abs(camera.rotation[2]), 3**-0.5, atol=1e-9)


def test_a_view_at_the_command_line(mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = printed(capsys, "draw", mesh, "-o", tmp_path / "a.svg", "--view", "right", "--json")
    assert record["camera"]["eye"] == pytest.approx([3.0, 0.0, 0.0], abs=1e-9)
    beside = complaint(capsys, "draw", mesh, "-o", tmp_path / "b.svg", "--view", "top", "--azimuth", 3)
    assert "--view: found --azimuth beside it, expected one or the other" in beside
    odd = complaint(capsys, "draw", mesh, "-o", tmp_path / "b.svg", "--view", "side")
    assert "found 'side', expected one of front, back, left, right, top, bottom, iso" in odd


def test_a_projection_at_the_command_line(mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flat = printed(capsys, "draw", mesh, "-o", tmp_path / "a.svg", "--projection", "orthographic", "--json")["camera"]
    assert flat["projection"] == "orthographic"
    (tmp_path / "flat.json").write_text(json.dumps(flat))
    again = printed(capsys, "draw", mesh, "-o", tmp_path / "b.svg", "--camera", tmp_path / "flat.json", "--json")
    assert again["camera"] == flat
    drawn, same = ((tmp_path / f"{name}.svg").read_text().split("</metadata>")[1] for name in "ab")
    assert drawn == same
    options = ("--camera", tmp_path / "flat.json", "--projection", "perspective", "--json")
    deep = printed(capsys, "draw", mesh, "-o", tmp_path / "c.svg", *options)["camera"]
    assert deep["focal_pixels"] == pytest.approx(3.0 * flat["pixels_per_unit"])
    odd = complaint(capsys, "draw", mesh, "-o", tmp_path / "d.svg", "--projection", "fisheye")
    assert odd.endswith("--projection: found 'fisheye', expected one of perspective, orthographic")


@pytest.mark.parametrize("suffix", ["dxf", "json", "svg"])
def test_hidden_lines_are_written(suffix: str, mesh: Path, tmp_path: Path) -> None:
    for hidden in ("none", "dashed"):
        assert main(["draw", str(mesh), "-o", str(tmp_path / f"{hidden}.{suffix}"), "--hidden", hidden]) == 0
    none, dashed = (tmp_path / f"{hidden}.{suffix}" for hidden in ("none", "dashed"))
    if suffix == "json":
        counts = [sum(s["hidden"] for s in json.loads(path.read_text())["strokes"]) for path in (none, dashed)]
        assert counts[0] == 0 < counts[1]
    else:
        assert "hidden" not in none.read_text()
        assert "hidden" in dashed.read_text()


def test_an_odd_word_for_hidden(mesh: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = complaint(capsys, "draw", mesh, "-o", tmp_path / "a.svg", "--hidden", "dotted")
    assert "--hidden: found 'dotted', expected one of none, dashed, layer" in said
