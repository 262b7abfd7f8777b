"""The `ncontours dataset` commands: what they write, and one clear line for bad input."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from dataset_tools.build.costs import BuildCost
from ncmodel.cli.main import main
from ncmodel.mesh.load import load_mesh
from ncmodel.readers.ply import ply_bytes
from ncmodel.types import Mesh
from tests.helpers import dirty
from tests.helpers.commands import complaint, printed


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cli") / "meshes"
    folder.mkdir()
    vertices, faces = dirty.sphere(fineness=3)
    vertices = vertices * (1 + 0.2 * np.sin(4 * vertices[:, :1]) * np.cos(3 * vertices[:, 2:]))
    (folder / "lump.ply").write_bytes(ply_bytes(Mesh(vertices, faces[:, ::-1].copy())))
    return folder


@pytest.fixture(scope="module")
def data(meshes: Path) -> Path:
    folder = meshes.parent / "data"
    options = ["--workers", "0", "--size", "64x48", "--views", "1", "--min-faces", "100"]
    assert main(["dataset", "build", str(meshes), str(folder), *options]) == 0
    return folder


def test_build_goes_on_with_the_settings_of_the_folder(
    data: Path, meshes: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = printed(capsys, "dataset", "build", meshes, data, "--workers", 0)
    assert (record["done"], record["made"], record["failed"]) == (1, 0, 0)


def test_status_counts(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = printed(capsys, "dataset", "status", data, "--verify")
    assert (record["done"], record["pending"], record["views"]) == (1, 0, 1)


def test_clean_reports_and_writes(meshes: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "clean.ply"
    record = printed(capsys, "dataset", "clean", meshes / "lump.ply", "-o", output)
    assert record["done"] == [{"step": "faces turned to face outwards", "count": 1280}]
    mesh = load_mesh(output)
    assert dirty.signed_volume(mesh.vertices, mesh.faces) > 0


def test_export_and_import_are_a_round_trip(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = printed(capsys, "dataset", "export", data / "views" / "lump_0", tmp_path / "out", "--size", "80x60")
    assert isinstance(record["files"], list)
    assert len(record["files"]) == 22
    printed(capsys, "dataset", "import", tmp_path / "out", tmp_path / "maps.npz")
    with np.load(tmp_path / "maps.npz") as arrays:
        assert arrays["lines"].shape == (4, 60, 80)
        assert arrays["maps"].shape == (7, 60, 80)


def test_a_sheet_shows_every_picture(data: Path, tmp_path: Path) -> None:
    assert main(["dataset", "sheet", str(data), "-o", str(tmp_path / "sheet.png")]) == 0
    picture = np.asarray(cv2.imread(str(tmp_path / "sheet.png")))
    assert picture.shape[1] > 11 * 170


def test_levels_are_measured(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = printed(capsys, "dataset", "levels", data)
    assert record["views"] == 1
    assert isinstance(record["kept"], list)
    assert len(record["kept"]) == 12


def test_costs_are_measured(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("dataset_tools.build.costs.VIEW_FACES", 1_000)
    monkeypatch.setattr(
        "dataset_tools.build.costs.measure_builds", lambda meshes, workers, advance: [BuildCost(1, 2, 3.0)]
    )
    record = printed(capsys, "dataset", "bench")
    assert set(record) == {"view", "distances", "builds"}
    assert record["builds"] == [{"workers": 1, "shapes": 2, "seconds": 3.0}]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["build", "NOWHERE", "OUT"], "no such folder"),
        (["build", "MESHES", "DATA", "--size", "32"], "width is 64"),
        (["build", "MESHES", "OUT", "--views", "0"], "views 0"),
        (["build", "MESHES", "OUT", "--up", "x"], "expected y or z"),
        (["build", "MESHES", "OUT", "--up-table", "NOWHERE"], "can't be read"),
        (["build", "MESHES", "OUT", "--size", "wide"], "--size"),
        (["build", "MESHES", "OUT", "--config", "NOWHERE"], "can't be read"),
        (["build", "MESHES", "OUT", "--scheduler", "tcp://127.0.0.1:9"], "no Dask scheduler answers"),
        (["clean", "NOWHERE.obj", "-o", "OUT.ply"], "no such file"),
        (["clean", "MESHES/lump.ply", "-o", "OUT.obj"], "expected a file *.ply"),
        (["clean", "MESHES/lump.ply", "-o", "OUT.ply", "--weld", "2"], "weld"),
        (["status", "NOWHERE"], "no config.toml"),
        (["export", "NOWHERE", "OUT"], "SHAPE_VIEW"),
        (["export", "DATA/views/lump_0", "OUT", "--format", "other"], "expected neuralcontours"),
        (["import", "NOWHERE", "OUT.npz"], "no such folder"),
        (["import", "NOWHERE", "OUT.txt"], "expected a file *.npz"),
        (["sheet", "NOWHERE", "-o", "OUT.png"], "no such folder"),
        (["levels", "NOWHERE"], "no such folder"),
    ],
)
def test_bad_input_is_one_clear_line(
    arguments: list[str], message: str, data: Path, meshes: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    places = {
        "MESHES": str(meshes),
        "DATA": str(data),
        "NOWHERE": str(tmp_path / "nowhere"),
        "OUT": str(tmp_path / "o"),
    }
    for name, place in places.items():
        arguments = [argument.replace(name, place) for argument in arguments]
    assert message in complaint(capsys, "dataset", *arguments)


def test_failed_views_end_a_build_with_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "broken.ply").write_text("not a mesh")
    arguments = [str(tmp_path / "meshes"), str(tmp_path / "data"), "--workers", "0"]
    assert main(["dataset", "build", *arguments]) == 1
    assert "2 views failed" in capsys.readouterr().err
    assert main(["dataset", "status", str(tmp_path / "data")]) == 1
