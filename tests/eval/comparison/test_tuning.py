"""Baselines are tuned on what voters chose on training views, once, whoever was interrupted."""

import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from dataset_tools.build.runners import HereRunner, Outcome
from eval.baselines import canny, grid
from eval.comparison.tuning import Tuned, tune
from eval.comparison.views import open_as_drawn, target_of
from eval.measures.evaluation import Settings
from eval.measures.thinning import read_ink
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import InputError
from ncmodel.limits import Limits
from tests.helpers import builds

LEVELS = 3
SETTINGS = Settings()


class Recorder:
    """Runs tasks here, and stops or fails after some."""

    def __init__(self, most: int = 100, reason: str = "") -> None:
        self.most, self.reason, self.done = most, reason, list[Any]()

    def run(self, function: Callable[[Any], Any], tasks: Sequence[Any], limits: Limits) -> Iterator[Outcome[Any, Any]]:
        """See `Runner.run`."""
        for task in tasks:
            if len(self.done) == self.most:
                if self.reason:
                    yield Outcome(task, None, self.reason)
                raise KeyboardInterrupt
            self.done.append(task.item)
            yield Outcome(task, function(task))


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> DataFolder:
    """A small data folder."""
    root = tmp_path_factory.mktemp("tuning")
    builds.build(builds.make_meshes(root / "meshes"), root / "data")
    return DataFolder(root / "data")


@pytest.fixture
def best(data: DataFolder) -> dict[Item, int]:
    return dict.fromkeys(data.items(), 2)


@pytest.fixture
def copy(data: DataFolder, tmp_path: Path) -> DataFolder:
    shutil.copytree(data.root, tmp_path / "data")
    return DataFolder(tmp_path / "data")


def test_the_best_thresholds_have_the_least_mean_cost(copy: DataFolder, best: dict[Item, int]) -> None:
    tuned = tune(copy, best, SETTINGS, HereRunner(), LEVELS)
    assert tuned.views == len(best) == 4
    assert list(tuned.plans) == list(grid.METHODS)
    examples = []
    for item, chosen in best.items():
        view = open_as_drawn(copy, item)
        reference = {"chosen": read_ink(copy.drawing_path(item, chosen))}
        examples.append((view, target_of(view, item.name, reference, SETTINGS, whole=False)))
    expected = grid.search(examples, LEVELS)
    assert {name: plan.filtered for name, plan in tuned.plans.items()} == {
        name: plan.filtered for name, plan in expected.methods.items()
    }
    assert tuned.canny == canny.search(examples)


def test_nothing_that_methods_are_judged_by_is_seen(copy: DataFolder, best: dict[Item, int]) -> None:
    tune(copy, best, SETTINGS, HereRunner(), LEVELS)
    assert not (copy.root / "simulated").exists()


def test_what_was_found_is_found_again(copy: DataFolder, best: dict[Item, int]) -> None:
    first, again, others = Recorder(), Recorder(), Recorder()
    tuned = tune(copy, best, SETTINGS, first, LEVELS)
    assert tune(copy, best, SETTINGS, again, LEVELS) == tuned
    assert (len(first.done), again.done) == (4, [])
    fewer = dict(list(best.items())[:1])
    assert tune(copy, fewer, SETTINGS, others, LEVELS).views == 1
    assert others.done == list(fewer)


def test_an_interrupted_search_goes_on_to_the_same_end(
    data: DataFolder, copy: DataFolder, best: dict[Item, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("eval.comparison.tuning.SAVE_EVERY", 1)
    with pytest.raises(KeyboardInterrupt):
        tune(copy, best, SETTINGS, Recorder(most=3), LEVELS)
    rest = Recorder()
    tuned = tune(copy, best, SETTINGS, rest, LEVELS)
    assert len(rest.done) == 1
    other = DataFolder(shutil.copytree(data.root, tmp_path / "other"))
    assert tuned == tune(other, best, SETTINGS, HereRunner(), LEVELS)
    assert [path.suffix for path in (copy.root / "tuned").iterdir()] == [".json"]


def test_a_view_that_can_not_be_drawn_is_named(copy: DataFolder, best: dict[Item, int]) -> None:
    with pytest.raises(InputError, match=r"odd_bumpy_0: took too long; expected a view that lines can be drawn of"):
        tune(copy, best, SETTINGS, Recorder(most=2, reason="took too long"), LEVELS)
    copy.drawing_path(next(iter(best)), 2).unlink()
    with pytest.raises(InputError, match=r"2\.png: can't be read"):
        tune(copy, best, SETTINGS, HereRunner(), LEVELS)


def test_a_record_is_what_it_was_made_of(copy: DataFolder, best: dict[Item, int]) -> None:
    tuned = tune(copy, best, SETTINGS, HereRunner(), LEVELS)
    again = Tuned.from_record(tuned.to_record())
    assert {name: (p.families, p.filtered) for name, p in again.plans.items()} == {
        name: (p.families, p.filtered) for name, p in tuned.plans.items()
    }
    assert again.canny == tuned.canny
