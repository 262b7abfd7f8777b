"""Training on numbers: what is read of a data folder, what is learnt of pairs, and bad files in one line."""

import io
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from dataset_tools.build.tasks import view_files
from dataset_tools.candidates.viewpoints import camera_at, choose_azimuths
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, Split, write_pairs
from ncmodel.drawing.settings import Levels, draw_layers
from ncmodel.errors import InputError, UsageError
from ncmodel.mesh.load import make_mesh
from ncmodel.model.statistics import statistics
from ncmodel.nets.checkpoints import load_checkpoint
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.training.loader import Examiner, Loader
from ncmodel.training.loop import Plan, fit
from ncmodel.training.statistics import (
    DrawingNumbers,
    StatisticsObjective,
    learn_habit,
    learn_mix,
    logistic_weights,
)
from ncmodel.training.train import TrainOptions, TrainReport, run_training
from tests.helpers.builds import CONFIG
from tests.helpers.counted import COUNTING, MadeNumbers, ink_pairs
from tests.helpers.views import bumpy

pytestmark = pytest.mark.usefixtures("one_thread")

SQUARE = replace(CONFIG, width=64, height=64)
ITEM = Item("s", "0")
NOBODY = Examiner(Loader(None))
"""There are no pictures to load."""


@pytest.fixture(scope="module")
def surface() -> Surface:
    return Surface(make_mesh(*bumpy(), "s"))


def pairs_of(folder: Path, item: Item, split: Split) -> list[Pair]:
    """The first line drawing of an item is better than the others; edges aren't spoken of."""
    medoids = json.loads((folder / "selection.json").read_text())["medoids"]
    first, *others = (place for place, medoid in enumerate(medoids) if medoid < 256)
    return [Pair(item, first, other, split) for other in others]


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory, surface: Surface) -> Path:
    """A data folder of three views, one of them held out, and pairs of their lines."""
    root = tmp_path_factory.mktemp("built")
    pairs = []
    items: dict[Item, Split] = {ITEM: "train", Item("s", "1"): "train", Item("t", "0"): "validation"}
    for item, split in items.items():
        folder = root / "views" / item.name
        shape = surface if item.shape == "s" else Surface(make_mesh(*bumpy(frequency=5.0), "t"))
        for name, data in view_files(shape, int(item.view), SQUARE).items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(data)
        pairs += pairs_of(folder, item, split)
    write_pairs(root / "pairs.jsonl", pairs)
    return root


def objective_of(numbers: MadeNumbers, pairs: list[Pair], seed: int = 0) -> StatisticsObjective:
    assert COUNTING.statistics is not None
    ranker = StatisticsRanker(COUNTING.statistics)
    ranker.initialise(torch.Generator().manual_seed(seed))
    return StatisticsObjective(COUNTING, ranker, numbers, pairs)


@pytest.fixture(scope="module")
def learnt(tmp_path_factory: pytest.TempPathFactory) -> StatisticsObjective:
    numbers = MadeNumbers(12)
    objective = objective_of(numbers, ink_pairs(numbers, held_out=("0", "1", "2")))
    fit(objective, Plan(tmp_path_factory.mktemp("fit") / "state", {}, COUNTING.counting.epochs, seed=0))
    return objective


def run(data: Path, out: Path, **options: object) -> TrainReport:
    return run_training(data, data / "pairs.jsonl", out, COUNTING, TrainOptions(**options))  # type: ignore[arg-type]


def test_numbers_of_a_data_folder_are_those_of_the_view(built: Path, surface: Surface) -> None:
    numbers = DrawingNumbers(DataFolder(built))
    for number in range(2):
        item = Item("s", str(number))
        azimuth = choose_azimuths("s", number + 1, SQUARE.seed)[number]
        view = View(surface, camera_at(surface.mesh, azimuth, (64, 64)))
        levels = Levels()
        wanted = statistics(draw_layers(view, levels).masks, levels.members, view.depth, view.shaded)
        assert np.array_equal(numbers.of(item).drawings, wanted.drawings)
        np.testing.assert_allclose(numbers.of(item).view, wanted.view, atol=1e-3)  # maps have 16 bits


def test_drawings_that_are_edges_have_no_setting(built: Path, tmp_path: Path) -> None:
    shutil.copytree(built / "views" / "s_0", tmp_path / "views" / "s_0")
    path = tmp_path / "views" / "s_0" / "selection.json"
    path.write_text(json.dumps({"medoids": [0, 255, 256, 263, 1, 2, 3, 4]}))
    assert DrawingNumbers(DataFolder(tmp_path)).settings(ITEM).tolist() == [0, 255, -1, -1, 1, 2, 3, 4]


def packed(**arrays: object) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)  # type: ignore[arg-type]
    return file.getvalue()


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("candidates.json", b"{", r"candidates.json: can't be read"),
        ("candidates.json", b"[1]", r"candidates.json: can't be read"),
        ("candidates.json", b'[{"layers": ["contours"]}]', r"candidates.json: other candidates; expected the cand"),
        ("candidates.npz", b"", r"candidates.npz: can't be read"),
        ("candidates.npz", b"PK\3\4", r"candidates.npz: can't be read"),
        ("candidates.npz", packed(other=np.zeros(3)), r"candidates.npz: can't be read \(KeyError\)"),
        (
            "candidates.npz",
            packed(ink=np.zeros((5, 8, 1), np.uint8), shape=np.array([264, 8, 8])),
            r"candidates.npz: ink of shape \(5, 8, 1\) for 264 candidates; expected what",
        ),
        ("selection.json", b"[]", r"selection.json: can't be read"),
        ("selection.json", b'{"medoids": [1, 2]}', "selection.json: 2 medoids; expected 8"),
    ],
)
def test_damaged_files_are_named(built: Path, tmp_path: Path, name: str, content: bytes, message: str) -> None:
    folder = tmp_path / "views" / "s_0"
    shutil.copytree(built / "views" / "s_0", folder)
    (folder / name).write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        DrawingNumbers(DataFolder(tmp_path)).settings(ITEM)
    assert "\n" not in str(caught.value)
    (folder / name).unlink()
    with pytest.raises(InputError, match=f"{name}: can't be read"):
        DrawingNumbers(DataFolder(tmp_path)).settings(ITEM)


def test_that_more_ink_is_better_is_learnt_of_pairs(learnt: StatisticsObjective) -> None:
    measures = learnt.validate(NOBODY)
    assert measures["accuracy"] > 0.9
    assert learnt.loss_of(measures) < np.log(2) / 2
    assert (learnt.margins() > 0).mean() == pytest.approx(measures["accuracy"])


def test_the_habit_is_the_mean_over_training_views(learnt: StatisticsObjective) -> None:
    learn_habit(learnt)
    items = sorted({pair.item for pair in learnt.training})
    assert len(items) == 9
    with torch.no_grad():
        scores = np.array([learnt.ranker(torch.from_numpy(learnt.numbers.of(i).numbers())).numpy() for i in items])
    wanted = (scores - scores.mean(axis=1, keepdims=True)).mean(axis=0)
    np.testing.assert_allclose(learnt.ranker.habit.numpy(), wanted, atol=1e-5)


def test_the_mix_gives_held_out_votes_their_odds(learnt: StatisticsObjective) -> None:
    learn_habit(learnt)
    learn_mix(learnt, None, None)
    statistics_weight, _, picture = learnt.ranker.mix.tolist()
    assert statistics_weight > 0
    # Nobody looked at pictures: their weight is that of what says nothing.
    assert picture == pytest.approx(0.0, abs=1e-3)


def test_without_held_out_pairs_the_mix_stays() -> None:
    numbers = MadeNumbers(2)
    objective = objective_of(numbers, ink_pairs(numbers, held_out=(), each=5))
    learn_mix(objective, None, None)
    assert objective.ranker.mix.tolist() == [1.0, 0.0, 0.0]
    assert objective.validate(NOBODY) == {}


def test_logistic_weights_are_those_that_votes_were_drawn_with() -> None:
    rng = np.random.default_rng(0)
    true = np.array([2.0, 0.7, 0.0])
    differences = rng.normal(size=(20_000, 3))
    preferred = rng.random(len(differences)) < 1 / (1 + np.exp(-differences @ true))
    found = logistic_weights(np.where(preferred[:, None], differences, -differences))
    np.testing.assert_allclose(found, true, atol=0.1)
    assert (found >= 0).all()


def test_voices_that_are_wrong_get_no_weight_and_perfect_ones_no_endless_one() -> None:
    rng = np.random.default_rng(1)
    right = np.abs(rng.normal(size=400)) + 0.1
    found = logistic_weights(np.column_stack([right, -right, np.zeros(400)]))
    assert found[1] == 0.0
    assert 1.0 < found[0] < 100.0


def test_pairs_of_edges_alone_teach_nothing(built: Path, tmp_path: Path) -> None:
    shutil.copytree(built, tmp_path / "data")
    for path in (tmp_path / "data").glob("views/*/selection.json"):
        path.write_text(json.dumps({"medoids": list(range(256, 264))}))
    with pytest.raises(UsageError, match="no pair of two line drawings to train on"):
        run(tmp_path / "data", tmp_path / "m", stages=("statistics",))


def test_the_same_seed_gives_the_same_bytes_and_another_one_others(built: Path, tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        report = run(built, tmp_path / name, stages=("statistics",), seed=seed)
        assert [(stage.stage, stage.epochs) for stage in report.stages] == [("statistics", 6)]
    a, b, c = ((tmp_path / name).read_bytes() for name in "abc")
    assert a == b != c


def test_all_stages_end_with_it_and_earlier_ones_trained_again_void_it(built: Path, tmp_path: Path) -> None:
    out = tmp_path / "m"
    report = run(built, out, epochs=1)
    assert [stage.stage for stage in report.stages] == ["ranker", "translator", "finetune", "statistics"]
    assert list(load_checkpoint(out).networks) == ["ranker", "translator", "statistics"]
    files = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    run(built, out, epochs=1)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == files
    run(built, out, stages=("ranker",), epochs=2)
    checkpoint = load_checkpoint(out)
    assert set(checkpoint.training["stages"]) == {"ranker", "translator"}
    assert checkpoint.statistics is None
    assert not out.with_name("m.statistics.state").exists()
