"""From measured views to a checkpoint: which shapes may be trained on, and the same bytes for the same seed."""

from pathlib import Path

import numpy as np
import pytest

from dataset_tools.collection.families import held_out_families, split_of
from dataset_tools.simulation.participants import Crowd
from eval.default_model.training import simulated_pairs, split_for, train_statistics, training_shapes
from eval.default_model.views import MeasuredView
from ncmodel.data.item import Item
from ncmodel.nets.checkpoints import load_checkpoint, save_checkpoint
from tests.helpers.counted import COUNTING, counted

pytestmark = pytest.mark.usefixtures("one_thread")


def measured(shape: str, seed: int) -> MeasuredView:
    rng = np.random.default_rng(seed)
    return MeasuredView(Item(shape, "0"), counted(rng), rng.random((4, 256)), np.arange(0, 256, 32))


def shapes_for(split: str | None, count: int) -> list[str]:
    return [name for name in (f"shape{number}" for number in range(400)) if split_for(name) == split][:count]


def test_training_shapes_are_of_training_families_and_more_of_them_go_on() -> None:
    some = training_shapes(40)
    assert len(set(some)) == 40
    assert {split_of(name) for name in some} == {"training"}
    assert training_shapes(60)[:40] == some
    assert len({name.rpartition("_")[0] for name in some}) > 5


def test_test_shapes_never_get_pairs() -> None:
    family = held_out_families()[0]
    names = [f"{family}_3", *shapes_for(None, 3)]
    assert {split_for(name) for name in names} == {None}
    assert simulated_pairs([measured(name, 0) for name in names], 5, Crowd(), seed=0) == []


def test_a_shape_is_trained_on_or_watches_never_both() -> None:
    names = [*shapes_for("train", 4), *shapes_for("validation", 2)]
    pairs = simulated_pairs([measured(name, seed) for seed, name in enumerate(names)], 4, Crowd(), seed=0)
    assert {(pair.item.shape, pair.split) for pair in pairs} <= {(name, split_for(name)) for name in names}
    assert {pair.split for pair in pairs} == {"train", "validation"}


def test_votes_on_a_view_do_not_depend_on_the_others() -> None:
    first, second = (measured(name, 0) for name in shapes_for("train", 2))
    together = simulated_pairs([first, second], 5, Crowd(), seed=1)
    alone = simulated_pairs([second], 5, Crowd(), seed=1)
    assert alone == [pair for pair in together if pair.item == second.item]
    assert alone != simulated_pairs([second], 5, Crowd(), seed=2)


def test_the_same_seed_gives_the_same_bytes_and_test_views_change_nothing(tmp_path: Path) -> None:
    names = [*shapes_for("train", 4), *shapes_for("validation", 2)]
    views = [measured(name, seed) for seed, name in enumerate(names)]
    tested = [measured(name, 9) for name in shapes_for(None, 1)]
    for name, known, seed in (("a", views, 0), ("b", views + tested, 0), ("c", views, 1)):
        pairs = simulated_pairs(known, 5, Crowd(noise=0.1), seed)
        trained = train_statistics(known, pairs, COUNTING, tmp_path / f"{name}.state", seed)
        save_checkpoint(tmp_path / name, trained)
    a, b, c = ((tmp_path / name).read_bytes() for name in "abc")
    assert a == b != c
    checkpoint = load_checkpoint(tmp_path / "a")
    record = checkpoint.training["stages"]["statistics"]
    assert record["views"] == 6
    assert record["pairs"]["train"] > record["pairs"]["validation"] > 0
    assert set(record["validation"]) == {"accuracy", "logistic"}
    assert checkpoint.statistics is not None
    assert checkpoint.statistics.habit.abs().max() > 0
