"""Whole builds: what they leave, and what a later run makes of changed settings and mesh files."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from dataset_tools.build.build import Summary, build_dataset, folder_status
from dataset_tools.build.config import TaskLimits
from dataset_tools.build.mesh_files import find_sources, read_up_table
from dataset_tools.build.runners import HereRunner
from ncmodel.camera import Camera
from ncmodel.drawing.settings import INK_LEVEL
from ncmodel.errors import InputError
from ncmodel.mesh.load import load_mesh
from ncmodel.readers.ply import ply_bytes
from ncmodel.types import Mesh
from tests.helpers import analytic, dirty
from tests.helpers.builds import CONFIG, build, contents, make_meshes, state


def picture(path: Path) -> Any:
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


def test_every_view_is_done_or_has_its_reason(reference: tuple[Path, Summary]) -> None:
    folder, summary = reference
    assert (summary.made, summary.count("done"), summary.count("failed"), summary.count("skipped")) == (4, 4, 2, 2)
    reasons = {row.shape: row.reason for row in folder_status(folder) if row.status != "done"}
    assert reasons["cube"] == "low resolution: 12 faces, expected at least 100"
    assert "loose triangles" in reasons["soup"]
    listed = (folder / "index.csv").read_text().splitlines()
    assert listed[0] == "shape,view,status,reason,seconds"
    assert len(listed) == 1 + 2 * 4
    assert listed[1].startswith("ball,0,done,,")


def test_a_view_folder_holds_what_the_formats_say(reference: tuple[Path, Summary]) -> None:
    view = reference[0] / "views" / "odd_bumpy_1"
    expected = {"camera.json", "candidates.json", "candidates.npz", "depth.png", "manifest.json", "selection.json"}
    expected |= {f"shaded_{level}.png" for level in range(6)} | {f"drawings/{number}.png" for number in range(8)}
    expected |= {f"renders/{number}.png" for number in range(3)}
    assert set(contents(view)) == expected
    camera = Camera.load(view / "camera.json")
    assert (camera.width, camera.height) == (64, 48)
    for name in ("depth.png", *(f"shaded_{level}.png" for level in range(6))):
        image = picture(view / name)
        assert (image.dtype, image.shape) == (np.uint16, (48, 64))
        assert image[0, 0] == 65535
        assert image.min() < 65535


def test_candidates_selection_and_drawings_belong_together(reference: tuple[Path, Summary]) -> None:
    view = reference[0] / "views" / "odd_bumpy_0"
    with np.load(view / "candidates.npz") as archive:
        assert archive["shape"].tolist() == [264, 48, 64]
        ink = np.unpackbits(archive["ink"], axis=-1, count=64).astype(bool)
    specs = json.loads((view / "candidates.json").read_text())
    assert [spec["index"] for spec in specs] == list(range(264))
    selection = json.loads((view / "selection.json").read_text())
    assert len(selection["medoids"]) == 8
    assert len(selection["labels"]) == 264
    assert "symmetric Chamfer distance in pixels" in selection["distance"]
    for place, index in enumerate(selection["medoids"]):
        drawing = picture(view / "drawings" / f"{place}.png")
        assert np.array_equal(1 - drawing / 255 > INK_LEVEL, ink[index])


def test_the_cleaned_mesh_is_in_object_space(reference: tuple[Path, Summary]) -> None:
    shape = reference[0] / "shapes" / "odd_bumpy"
    mesh = load_mesh(shape / "mesh.ply")
    assert mesh.notes == ()
    assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(1.0)
    assert dirty.signed_volume(mesh.vertices, mesh.faces) > 0
    report = json.loads((shape / "clean.json").read_text())
    assert report["status"] == "done"
    assert {"found", "done", "left"} <= set(report)
    assert report["done"] == [{"step": "faces turned to face outwards", "count": 320}]


def test_a_second_run_makes_nothing(reference: tuple[Path, Summary], meshes: Path) -> None:
    folder, _ = reference
    before = {path: path.stat().st_mtime_ns for path in (folder / "views").rglob("*")}
    assert build(meshes, folder).made == 0
    assert {path: path.stat().st_mtime_ns for path in (folder / "views").rglob("*")} == before
    assert (folder / "index.csv").read_text().splitlines()[1].split(",")[-1] != "", "times are kept"


def test_a_folder_of_other_settings_is_not_mixed(copy: Path, meshes: Path) -> None:
    with pytest.raises(InputError, match=r"config.toml: views is 2; expected 3"):
        build_dataset(find_sources(meshes), copy, replace(CONFIG, views=3), HereRunner())


def test_limits_may_differ_between_runs(copy: Path, meshes: Path) -> None:
    settings = replace(CONFIG, limits=TaskLimits(view_seconds=7.0))
    assert build_dataset(find_sources(meshes), copy, settings, HereRunner()).made == 0
    assert "view_seconds = 7.0" in (copy / "config.toml").read_text()


def test_a_mesh_file_with_other_content_is_made_again(copy: Path, tmp_path: Path) -> None:
    folder = make_meshes(tmp_path / "meshes")
    ball, bumpy = (folder / name for name in ("ball.ply", "odd/bumpy.ply"))
    swapped = ball.read_bytes(), bumpy.read_bytes()
    ball.write_bytes(swapped[1])
    bumpy.write_bytes(swapped[0])
    assert build(folder, copy).made == 4
    fresh = tmp_path / "fresh"
    build(folder, fresh)
    assert contents(copy) == contents(fresh)


def test_a_mesh_file_that_came_to_nothing_leaves_no_old_view(copy: Path, tmp_path: Path) -> None:
    folder = make_meshes(tmp_path / "meshes")
    (folder / "ball.ply").write_bytes(b"no mesh")
    assert build(folder, copy).made == 0
    assert not (copy / "views" / "ball_0").exists()
    assert state(copy)["ball", 0] == "failed"


def test_a_renamed_mesh_file_is_another_shape(copy: Path, tmp_path: Path) -> None:
    folder = make_meshes(tmp_path / "meshes")
    (folder / "cube.ply").rename(folder / "dice.ply")
    assert build(folder, copy).made == 0
    assert state(copy)["dice", 0] == "skipped"
    (folder / "soup.ply").rename(folder / "cube.ply")
    build(folder, copy)
    assert state(copy)["cube", 0] == "failed", "another file under an old name"


def test_each_file_has_its_own_upward_axis(tmp_path: Path) -> None:
    ball = dirty.sphere(fineness=2)
    folder = tmp_path / "meshes"
    (folder / "cad").mkdir(parents=True)
    for name, tall in (("cad/part.ply", [1, 1, 2]), ("pot.ply", [1, 2, 1])):
        (folder / name).write_bytes(ply_bytes(Mesh(ball[0] * tall, ball[1])))
    (tmp_path / "up.csv").write_text("file,up\ncad/*,z\n")
    config = replace(CONFIG, views=1, up_rules=read_up_table(tmp_path / "up.csv"), duplicate_distance=0.0)
    build_dataset(find_sources(folder), tmp_path / "data", config, HereRunner())
    for shape in ("cad_part", "pot"):
        extent = np.ptp(load_mesh(tmp_path / "data" / "shapes" / shape / "mesh.ply").vertices, axis=0)
        assert extent == pytest.approx([0.5, 1.0, 0.5]), shape
    changed = replace(config, up_rules=("*=y",))
    assert build_dataset(find_sources(folder), tmp_path / "data", changed, HereRunner()).made == 1


def test_shapes_can_be_added_later(copy: Path, meshes: Path, tmp_path: Path) -> None:
    more = tmp_path / "more"
    more.mkdir()
    (more / "extra.ply").write_bytes(ply_bytes(Mesh(*analytic.torus(24, 12))))
    assert build(more, copy).made == 2
    assert len(folder_status(copy)) == 10


def test_the_state_of_something_else_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no config.toml in it"):
        folder_status(tmp_path)
