"""Camera files: what is read, and one clear line for everything else."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ncmodel.camera import PROJECTIONS, Camera
from ncmodel.errors import InputError
from ncmodel.files import write_text

RECORD: dict[str, Any] = {
    "eye": [1, 2.5, 3], "target": [0, 0, 0], "up": [0, 1, 0], "width": 90, "height": 60.0, "focal_pixels": 100,
}  # fmt: skip
CAMERA = Camera((1.0, 2.5, 3.0), width=90, height=60, focal_pixels=100.0)


@pytest.mark.parametrize("start", ["", "\ufeff", "\n  "])
def test_a_camera_is_read_and_written(start: str, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(start + json.dumps(RECORD), encoding="utf-8")
    assert Camera.load(tmp_path / "a.json") == CAMERA
    (tmp_path / "b.json").write_text(CAMERA.to_json(), encoding="utf-8")
    assert Camera.load(tmp_path / "b.json") == CAMERA


def test_an_orthographic_camera_is_read_and_written(tmp_path: Path) -> None:
    """Its scale stands in place of the focal length, which such a file may have for others."""
    camera = Camera((1.0, 2.5, 3.0), width=90, height=60, focal_pixels=20.0, projection="orthographic")
    record = {k: v for k, v in RECORD.items() if k != "focal_pixels"}
    record |= {"projection": "orthographic", "pixels_per_unit": 20}
    assert json.loads(camera.to_json()) == record
    for there in (record, record | {"focal_pixels": 100}):
        (tmp_path / "a.json").write_text(json.dumps(there), encoding="utf-8")
        assert Camera.load(tmp_path / "a.json") == camera
    (tmp_path / "b.json").write_text(json.dumps(RECORD | {"projection": "perspective"}), encoding="utf-8")
    assert Camera.load(tmp_path / "b.json") == CAMERA


def test_without_perspective_the_target_is_as_large() -> None:
    flat = CAMERA.projected("orthographic")
    beside = 1e-3 * CAMERA.rotation[:2]
    assert flat.project(beside)[:, :2] == pytest.approx(CAMERA.project(beside)[:, :2], abs=1e-9)
    assert flat.projected("orthographic") == flat
    assert flat.projected("perspective").focal_pixels == pytest.approx(CAMERA.focal_pixels)


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_lines_of_sight_lead_to_what_is_seen_there(projection: str) -> None:
    camera = CAMERA.projected(projection)
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (50, 3))
    pixels = camera.project(points)
    assert camera.rays(pixels[:, :2]).at(pixels[:, 2]) == pytest.approx(points)
    assert camera.rays_to(points).at(np.ones(50)) == pytest.approx(points)


def test_up_along_the_line_of_sight_leaves_the_roll_open() -> None:
    camera = Camera((0.0, 3.0, 0.0))
    assert camera.project(camera.rotation[1] * 0.1)[:2].tolist() == pytest.approx([384.0, 384.0 - 47.018], abs=0.01)


WRONG: dict[str, tuple[Any, str]] = {
    "nothing": ("", "not JSON"),
    "too deep": ("[" * 100_000, "not JSON"),
    "a list": ([1], "found list; expected a JSON object with the keys eye, target, up, width, height, focal_pixels"),
    "a key missing": ({k: v for k, v in RECORD.items() if k != "up"}, r"found \['eye', 'focal_pixels', 'height'"),
    "a key too many": ({**RECORD, "fov": 30}, r"found \['eye', 'focal_pixels', 'fov'"),
    "two numbers": ({**RECORD, "eye": [1, 2]}, "eye is .*; expected 3 numbers"),
    "a text": ({**RECORD, "eye": "far"}, "eye is 'far'; expected 3 numbers"),
    "null": ({**RECORD, "up": [0, 1, None]}, "up is .*; expected 3 numbers"),
    "true": ({**RECORD, "width": True}, "width is True; expected one number"),
    "half a pixel": ({**RECORD, "width": 10.5}, "size 10.5 x 60.0; expected whole pixels"),
    "no pixel": ({**RECORD, "height": 0}, "size 90 x 0, expected sides in 1..16384 pixels"),
    "too many pixels": ({**RECORD, "height": 10**400}, "expected whole pixels"),
    "no angle": ({**RECORD, "focal_pixels": 0}, "focal_pixels is 0.0, expected a positive number"),
    "not a number": ({**RECORD, "eye": [float("nan"), 0, 0]}, "all numbers must be finite"),
    "infinite": ({**RECORD, "eye": [10**400, 0, 0]}, "all numbers must be finite"),
    "far": ({**RECORD, "eye": [1e13, 0, 0]}, r"found 1e\+13, expected numbers up to 1e\+12"),
    "nowhere to look": ({**RECORD, "eye": [0, 0, 0]}, "eye and target are both"),
    "fisheye": ({**RECORD, "projection": "fisheye"}, "projection is 'fisheye', expected one of perspective, orth"),
    "no scale": ({**RECORD, "projection": "orthographic"}, "expected a JSON object with the keys .*pixels_per_unit"),
    "no up": ({**RECORD, "up": [0, 0, 0]}, "expected a direction"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_camera_is_one_clear_line(name: str, tmp_path: Path) -> None:
    content, message = WRONG[name]
    path = tmp_path / "camera.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        Camera.load(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="can't be read"):
        Camera.load(tmp_path)
    (tmp_path / "out.json").mkdir()
    with pytest.raises(InputError, match="a folder; expected a file's name"):
        write_text(tmp_path / "out.json", "{}")
    assert [path.name for path in tmp_path.iterdir()] == ["out.json"]
