"""Exchange with the published code: what is read back is what was written, within its quantisation."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.errors import InputError
from ncmodel.mesh.load import make_mesh
from ncmodel.model.maps import line_maps
from ncmodel.published.folder import NAMES, PublishedView, read_folder
from ncmodel.published.rendering import framed, published_view
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import LineFamily
from tests.helpers import dirty

SIZE = (80, 60)
STEP_8, STEP_16 = 0.5 / 255 + 1e-6, 0.5 / 65535 + 1e-6


@pytest.fixture(scope="module", params=[SIZE, (61, 97), (128, 128)], ids=["landscape", "portrait", "square"])
def view(request: pytest.FixtureRequest) -> View:
    vertices, faces = dirty.sphere(fineness=4)
    vertices = vertices * (1 + 0.15 * np.sin(6 * vertices[:, :1]) * np.cos(5 * vertices[:, 2:]))
    mesh = make_mesh(vertices, faces)
    return View(Surface(mesh), Camera.orbit(mesh.vertices, 40.0, size=request.param))


def write(view: PublishedView, folder: Path) -> Path:
    folder.mkdir(exist_ok=True)
    for name, data in view.files().items():
        (folder / name).write_bytes(data)
    return folder


def test_a_round_trip_keeps_everything_within_quantisation(view: View, tmp_path: Path) -> None:
    ours = published_view(view)
    back = read_folder(write(ours, tmp_path / "view"))
    assert back.lines == pytest.approx(ours.lines, abs=STEP_8)
    assert back.base == pytest.approx(ours.base, abs=STEP_8)
    assert back.boundaries == pytest.approx(ours.boundaries, abs=STEP_8)
    assert back.features == pytest.approx(ours.features, abs=STEP_16)
    assert back.maps == pytest.approx(ours.maps, abs=STEP_16)
    assert back.n_dot_v == pytest.approx(ours.n_dot_v, abs=STEP_16)
    assert back.p90.tolist() == ours.p90.tolist()
    assert back.feature_size == ours.feature_size


def test_the_folder_holds_the_files_that_the_published_scripts_read(view: View, tmp_path: Path) -> None:
    folder = write(published_view(view), tmp_path / "view")
    expected = {"base.png", "boundaries.png", "nv.png", "depth.png", *(f"smooth_{level}.png" for level in range(6))}
    expected |= {f"{name}{end}" for name in NAMES for end in (".png", "_feature.png", "_info.txt")}
    assert {path.name for path in folder.iterdir()} == expected
    feature: Any = np.asarray(cv2.imread(str(folder / "ridge_feature.png"), cv2.IMREAD_UNCHANGED))
    assert (feature.dtype, feature.shape) == (np.uint16, (view.camera.height, view.camera.width))
    assert feature[0, 0] == 65535
    line: Any = np.asarray(cv2.imread(str(folder / "ridge.png"), cv2.IMREAD_UNCHANGED))
    assert (line.dtype, line[0, 0]) == (np.uint8, 255)


def test_our_model_finds_its_line_maps_in_what_it_imports(view: View, tmp_path: Path) -> None:
    imported = read_folder(write(published_view(view), tmp_path / "view")).line_maps()
    ours = line_maps(view, percentile="mesh")
    assert imported.lines == pytest.approx(ours.lines, abs=STEP_8)
    assert imported.p90 == pytest.approx(ours.p90)
    assert imported.lines.shape == imported.features.shape == (4, view.camera.height, view.camera.width)


def test_units_are_those_of_the_mesh_s_vertices_and_of_rtsc(view: View) -> None:
    surface, ours = view.surface, published_view(view)
    values = (view.sc_num, surface.k1, -surface.k1, view.q1)
    assert ours.p90.tolist() == [float(np.percentile(v[v > 0], 90)) for v in values]
    assert ours.feature_size == Surface(view.mesh, sizing="sampled").feature_size


def test_boundaries_have_a_file_of_their_own_that_may_be_missing(tmp_path: Path) -> None:
    vertices, faces = dirty.sphere(fineness=3)
    mesh = make_mesh(vertices, faces[vertices[faces].mean(axis=1)[:, 1] < 0.5])
    ours = published_view(View(Surface(mesh), Camera.orbit(mesh.vertices, size=SIZE)))
    assert ours.boundaries.max() > 0.1
    folder = write(ours, tmp_path / "view")
    assert np.abs(read_folder(folder).line_maps().boundaries - ours.boundaries).max() < STEP_8
    (folder / "boundaries.png").unlink()
    assert not read_folder(folder).boundaries.any()


def test_another_camera_s_view_lies_in_the_middle_of_the_published_frame() -> None:
    for size in ((768, 768), (500, 900), (1600, 300), (1024, 768)):
        camera = Camera((1.0, 2.0, 3.0), width=size[0], height=size[1], focal_pixels=900.0)
        points = np.random.default_rng(0).normal(size=(9, 3)) * 0.1
        scale = min(1024 / size[0], 768 / size[1])
        expected = (camera.project(points)[:, :2] - np.array(size) / 2) * scale + np.array([512, 384])
        assert framed(camera).project(points)[:, :2] == pytest.approx(expected)
        assert (framed(camera).width, framed(camera).height) == (1024, 768)


def test_a_missing_picture_is_named(view: View, tmp_path: Path) -> None:
    folder = write(published_view(view), tmp_path / "view")
    (folder / "valley.png").unlink()
    with pytest.raises(InputError, match=r"valley\.png: can't be read"):
        read_folder(folder)


@pytest.mark.parametrize("text", ["", "1", "one two", "0 0.1", "nan 0.1"])
def test_an_info_file_without_its_numbers_is_named(view: View, tmp_path: Path, text: str) -> None:
    folder = write(published_view(view), tmp_path / "view")
    (folder / "ridge_info.txt").write_text(text)
    with pytest.raises(InputError, match=r"ridge_info\.txt"):
        read_folder(folder)


def test_what_follows_the_numbers_of_an_info_file_does_not_matter(view: View, tmp_path: Path) -> None:
    folder = write(published_view(view), tmp_path / "view")
    info = folder / "suggestive_contour_info.txt"
    before = read_folder(folder)
    info.write_text(info.read_text().strip() + " 7\nmore\n")
    assert read_folder(folder).p90.tolist() == before.p90.tolist()


def test_the_published_filters_keep_what_rtsc_s_thresholds_keep(view: View, tmp_path: Path) -> None:
    # The published scripts multiply a feature by p90 and by the feature size to the power of its dimension.
    folder = write(published_view(view), tmp_path / "view")
    for name, family, power in (("ridge", LineFamily.RIDGES, 1), ("suggestive_contour", LineFamily.SUGGESTIVE, 2)):
        stored: Any = cv2.imread(str(folder / f"{name}_feature.png"), cv2.IMREAD_UNCHANGED)
        p90, size = (float(word) for word in (folder / f"{name}_info.txt").read_text().split())
        ours = view.feature_map(family) * size**power
        unclipped = view.buffers.hit & (ours > 0) & (stored < 65535)
        assert unclipped.any()
        assert stored[unclipped] / 65535 * p90 * size**power == pytest.approx(
            ours[unclipped], abs=p90 * size**power / 65535
        )


def test_pictures_of_different_sizes_are_refused(view: View, tmp_path: Path) -> None:
    folder = write(published_view(view), tmp_path / "view")
    cv2.imwrite(str(folder / "nv.png"), np.zeros((5, 5), np.uint16))
    with pytest.raises(InputError, match="sizes"):
        read_folder(folder)
