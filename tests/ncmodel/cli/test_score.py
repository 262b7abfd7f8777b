"""The command `ncontours score`."""

from pathlib import Path

import pytest
import torch

from ncmodel.camera import Camera
from ncmodel.cli.main import main
from ncmodel.drawing.draw import draw
from ncmodel.mesh.load import load_mesh
from ncmodel.model.calibration import RECORD
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import Checkpoint, save_checkpoint
from ncmodel.nets.ranking import RankingModule
from ncmodel.readers.ply import ply_bytes
from ncmodel.types import Mesh
from tests.helpers import analytic
from tests.helpers.commands import complaint, printed
from tests.helpers.micro_training import MICRO

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A mesh, a camera, two drawings, a model that knows its temperature and one that doesn't."""
    folder = tmp_path_factory.mktemp("score")
    (folder / "torus.ply").write_bytes(ply_bytes(Mesh(*analytic.torus(60, 30))))
    mesh = load_mesh(folder / "torus.ply")
    camera = Camera.orbit(mesh.vertices, size=(256, 256))
    (folder / "camera.json").write_text(camera.to_json())
    for name, lines in (("plain", "contours"), ("rich", "contours,ridges,valleys")):
        draw(folder / "torus.ply", camera, lines).save(folder / f"{name}.png")
    ranker = RankingModule(MICRO.ranking)
    initialise(ranker, torch.Generator().manual_seed(0))
    save_checkpoint(folder / "guess.safetensors", Checkpoint(MICRO, ranker=ranker))
    training = {RECORD: {"temperature": 0.5}}
    save_checkpoint(folder / "model.safetensors", Checkpoint(MICRO, ranker=ranker, training=training))
    return folder


def words(folder: Path, *drawings: object, model: str = "model.safetensors") -> list[object]:
    return ["score", folder / "torus.ply", *drawings, "--camera", folder / "camera.json", "--model", folder / model]


def test_scores_and_shares_are_printed_by_name(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = printed(capsys, *words(folder, folder / "plain.png", folder / "rich.png"))
    assert set(found["scores"]) == {"plain", "rich"}
    assert set(found["probability"]) == {"plain", "rich"}
    share = found["probability"]["plain"]["rich"]
    assert share + found["probability"]["rich"]["plain"] == pytest.approx(1.0)
    assert (share > 0.5) == (found["scores"]["plain"] > found["scores"]["rich"])
    assert (found["temperature"], found["calibrated"]) == (0.5, True)


def test_people_read_a_table_the_best_first(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scores = printed(capsys, *words(folder, folder / "plain.png", folder / "rich.png"))["scores"]
    assert main([str(word) for word in words(folder, folder / "plain.png", folder / "rich.png")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1:]] == sorted(scores, key=lambda name: -scores[name])
    assert "%" in lines[1]


def test_drawings_of_one_name_are_told_by_their_paths(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "other").mkdir()
    other = folder / "other" / "plain.png"
    other.write_bytes((folder / "rich.png").read_bytes())
    found = printed(capsys, *words(folder, folder / "plain.png", other))
    assert set(found["scores"]) == {str(folder / "plain.png"), str(other)}


def test_a_guess_is_called_one(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    guess = words(folder, folder / "plain.png", model="guess.safetensors")
    assert printed(capsys, *guess)["calibrated"] is False
    assert main([str(word) for word in guess]) == 0
    assert "is a guess" in capsys.readouterr().err


def test_bad_input_is_one_line(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = folder / "plain.png"
    assert "none.png: can't be read" in complaint(capsys, *words(folder, tmp_path / "none.png"))
    assert "none.safetensors: no such file" in complaint(capsys, *words(folder, good, model="none.safetensors"))
    camera = Camera.load(folder / "camera.json").resized(300, 200)
    (tmp_path / "wide.json").write_text(camera.to_json())
    wide = [tmp_path / "wide.json" if word == folder / "camera.json" else word for word in words(folder, good)]
    assert "plain.png: 256 x 256 pixels; expected the camera's frame, 300 x 200" in complaint(capsys, *wide)
