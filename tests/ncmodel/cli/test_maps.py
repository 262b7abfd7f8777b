"""`draw --maps` and `score --maps`: a folder in the published layout in place of a mesh."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from torch import nn

from ncmodel.camera import Camera
from ncmodel.images import read_grey, write_png
from ncmodel.mesh.load import make_mesh
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import Checkpoint, save_checkpoint
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from ncmodel.published.folder import read_folder
from ncmodel.published.rendering import published_view
from ncmodel.published.weights import import_weights
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from tests.helpers import analytic
from tests.helpers import published_reference as reference
from tests.helpers.commands import complaint, printed
from tests.helpers.micro_training import MICRO
from tests.helpers.published_weights import NARROW, narrow_networks, save_weights

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture(scope="module")
def networks() -> dict[str, nn.Module]:
    """The published networks, narrow, with random weights."""
    return narrow_networks()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, networks: dict[str, nn.Module]) -> Path:
    """Maps of a torus in the published size and in a small one, and two models."""
    folder = tmp_path_factory.mktemp("maps")
    mesh = make_mesh(*analytic.torus(40, 20))
    for name, size in (("torus", (1024, 768)), ("small", (64, 48))):
        (folder / name).mkdir()
        view = published_view(View(Surface(mesh), Camera.orbit(mesh.vertices, size=size)))
        for file, content in view.files().items():
            (folder / name / file).write_bytes(content)
    official = import_weights(*save_weights(folder, networks), NARROW)
    save_checkpoint(folder / "official.safetensors", official)
    ranker, translator = RankingModule(MICRO.ranking), TranslationBranch(MICRO.translation)
    for seed, network in enumerate((ranker, translator)):
        initialise(network, torch.Generator().manual_seed(seed))
    save_checkpoint(folder / "ours.safetensors", Checkpoint(MICRO, ranker, translator))
    return folder


def test_the_image_variant_draws_the_published_pixels(
    folder: Path, networks: dict[str, nn.Module], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    maps, out = folder / "torus", tmp_path / "out.png"
    words = ["draw", "--maps", maps, "-o", out, "--model", folder / "official.safetensors", "--variant", "image"]
    record = printed(capsys, *words)
    assert (record["width"], record["height"], record["families"]) == (1024, 768, ["contours", "creases"])
    view = read_folder(maps)
    paper = networks["translator"](reference.translation_input(view.maps[1:], view.maps[0]))[0, 0].numpy()
    expected = np.maximum(reference.ridge_pixels(paper), view.base)
    assert (np.abs(1 - read_grey(out) - expected) < 0.003).mean() >= 0.999


def test_scores_are_the_published_ones_negated(
    folder: Path, networks: dict[str, nn.Module], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    view, model = read_folder(folder / "torus"), folder / "official.safetensors"
    for number, ink in enumerate((view.base, np.maximum(view.base, view.lines[3]))):
        write_png(tmp_path / f"{number}.png", np.rint(255 * (1 - ink)).astype(np.uint8))
    drawings = [tmp_path / "0.png", tmp_path / "1.png"]
    found = printed(capsys, "score", "--maps", folder / "torus", *drawings, "--model", model)["scores"]
    for number, drawing in enumerate(drawings):
        drawn = torch.from_numpy(1 - read_grey(drawing))
        expected = reference.ranking_score(networks["ranker"], drawn, view.maps[1], view.maps[0])
        assert found[str(number)] == pytest.approx(-expected.item(), rel=1e-5)


def test_both_ways_of_drawing_choose_thresholds_of_maps(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for model, maps, unit in (("official", "torus", "published"), ("ours", "small", "p90")):
        out = tmp_path / f"{model}.png"
        options = ["--model", folder / f"{model}.safetensors", "--preset", "draft", "--lines", "contours,ridges"]
        record = printed(capsys, "draw", "--maps", folder / maps, "-o", out, *options)
        assert record["threshold_unit"] == unit
        assert record["score_evaluations"] > 1
        assert set(record["families"]) <= {"contours", "creases", "ridges"}
        ink = 1 - read_grey(out)
        assert (ink >= read_folder(folder / maps).base - 0.003).all()


def test_the_model_that_ships_draws_and_scores_maps(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    maps, out = folder / "torus", tmp_path / "out.png"
    record = printed(capsys, "draw", "--maps", maps, "-o", out, "--model", "default", "--preset", "instant")
    assert record["threshold_unit"] == "rtsc"
    assert 0.003 < (1 - read_grey(out)).mean() < 0.2
    write_png(tmp_path / "all.png", np.rint(255 * (1 - read_folder(maps).lines.max(axis=0))).astype(np.uint8))
    found = printed(capsys, "score", "--maps", maps, out, tmp_path / "all.png")
    assert found["scores"]["out"] > found["scores"]["all"]
    assert found["scores"]["out"] == pytest.approx(record["score"], abs=1.0)


def test_without_a_model_thresholds_filter_the_lines_and_vector_files_are_traced(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    inks = []
    for value in ("0", "0.05", "off"):
        out = tmp_path / "out.png"
        printed(capsys, "draw", "--maps", folder / "torus", "-o", out, "--thresholds", f"apparent={value}")
        inks.append(float((1 - read_grey(out)).sum()))
    assert inks[0] > inks[1] > inks[2] > 0
    printed(capsys, "draw", "--maps", folder / "torus", "-o", tmp_path / "out.svg", "--thresholds", "apparent=off")
    assert (tmp_path / "out.svg").read_text().count("<path") >= 1


def test_what_dataset_import_writes_is_read_too(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    printed(capsys, "dataset", "import", folder / "small", tmp_path / "maps.npz")
    for maps, name in ((folder / "small", "a.png"), (tmp_path / "maps.npz", "b.png")):
        printed(capsys, "draw", "--maps", maps, "-o", tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_what_makes_no_sense_is_told_in_a_line(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    maps, out, official = folder / "torus", tmp_path / "out.png", folder / "official.safetensors"
    ours = folder / "ours.safetensors"
    assert "neither a mesh nor --maps" in complaint(capsys, "draw", "-o", out)
    assert "found a mesh beside" in complaint(capsys, "draw", "x.obj", "--maps", maps, "-o", out)
    assert "found --size beside" in complaint(capsys, "draw", "--maps", maps, "-o", out, "--size", 9)
    assert "no such folder" in complaint(capsys, "draw", "--maps", tmp_path / "none", "-o", out)
    said = complaint(
        capsys, "draw", "--maps", folder / "small", "-o", out, "--model", official, "--variant", "geometry"
    )
    assert "maps of 64 x 48 pixels, expected 1024 x 768" in said
    said = complaint(capsys, "draw", "--maps", maps, "-o", out, "--model", ours, "--mode", "published")
    assert "--mode: found 'published', expected paper" in said
    said = complaint(capsys, "draw", "--maps", maps, "-o", out, "--model", ours, "--variant", "both")
    assert "--variant: found 'both', expected one of full, geometry, image" in said
    cv2.imwrite(str(tmp_path / "tall.png"), np.full((90, 30), 255, np.uint8))
    said = complaint(capsys, "score", "--maps", maps, tmp_path / "tall.png", "--model", ours)
    assert "tall.png: 30 x 90 pixels; expected the camera's frame, 1024 x 768" in said
    assert "--camera: found none" in complaint(capsys, "score", "x.obj", tmp_path / "tall.png")
