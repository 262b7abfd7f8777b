"""Votes on held-out shapes are kept in the checkpoint as a temperature."""

import json
from pathlib import Path

import pytest

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.pairs import read_pairs
from ncmodel.model.calibration import RECORD, calibrate, calibrate_file, preference_of
from ncmodel.nets.checkpoints import load_checkpoint
from ncmodel.training.dataset import ViewImages
from ncmodel.training.loader import Examiner, Loader
from ncmodel.training.objectives import judge_pairs
from tests.helpers.micro_training import run
from tests.helpers.training_data import make_data

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A made data folder with a model of it."""
    root = tmp_path_factory.mktemp("calibration")
    make_data(root, shapes=6, held_out=2)
    run(root, root / "model.safetensors", epochs=2)
    return root


def test_a_calibrated_checkpoint_knows_its_temperature(root: Path) -> None:
    path = root / "model.safetensors"
    assert preference_of(load_checkpoint(path)) is None
    found = calibrate_file(path, root, root / "pairs.jsonl")
    assert found is not None
    assert set(found) == {"temperature", "error", "bins", "pairs", "shapes"}
    assert (found["pairs"], found["shapes"]) == (28, 2)
    assert 0.0 <= found["error"] <= 1.0
    known = preference_of(load_checkpoint(path))
    assert known is not None
    assert known.temperature == found["temperature"] > 0.0


def test_calibrated_again_the_file_stays_as_it_is(root: Path) -> None:
    path = root / "model.safetensors"
    calibrate_file(path, root, root / "pairs.jsonl")
    before = path.stat().st_mtime_ns, path.read_bytes()
    calibrate_file(path, root, root / "pairs.jsonl")
    assert (path.stat().st_mtime_ns, path.read_bytes()) == before


def test_without_held_out_votes_nothing_is_kept(root: Path, tmp_path: Path) -> None:
    path = tmp_path / "model.safetensors"
    path.write_bytes((root / "model.safetensors").read_bytes())
    calibrate_file(path, root, root / "pairs.jsonl")
    lines = (root / "pairs.jsonl").read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if json.loads(line)["split"] == "train"]
    (tmp_path / "pairs.jsonl").write_text("\n".join(kept), encoding="utf-8")
    assert calibrate_file(path, root, tmp_path / "pairs.jsonl") is None
    assert RECORD not in load_checkpoint(path).training


def test_pictures_are_scored_as_in_training(root: Path) -> None:
    """All predicted winners win as often as training's own judgement says that pairs are in the right order."""
    ranker = load_checkpoint(root / "model.safetensors").ranker
    assert ranker is not None
    pairs = [pair for pair in read_pairs(root / "pairs.jsonl") if pair.split == "validation"]
    judged = judge_pairs(ranker, pairs, 16, Examiner(Loader(ViewImages(DataFolder(root), [ranker.dims.size]))))
    found = calibrate(ranker, DataFolder(root), pairs)
    votes = sum(part["votes"] for part in found["bins"])
    share = sum(part["observed"] * part["votes"] for part in found["bins"]) / votes
    # A pair has 2 votes for its better drawing, and a seventh of one for the other.
    wins, losses = 2 / (2 + 1 / 7), (1 / 7) / (2 + 1 / 7)
    expected = judged["accuracy"] * wins + (1 - judged["accuracy"]) * losses
    assert share == pytest.approx(expected, abs=1e-6)
