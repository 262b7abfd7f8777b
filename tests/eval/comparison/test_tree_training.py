"""A decision tree is trained on voters' choices of training views, the same whoever is first."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from dataset_tools.build.runners import HereRunner, Outcome
from dataset_tools.build.worker_process import Limits
from eval.baselines.decision_tree import Tree
from eval.comparison.tree_training import train_tree
from ncmodel.errors import ArgumentError, InputError
from tests.helpers.commands import complaint, printed
from tests.helpers.training_data import add_meshes, make_data

pytestmark = pytest.mark.usefixtures("one_thread")


class Backwards:
    """Runs tasks here, the last one first."""

    def __init__(self) -> None:
        self.done: list[str] = []

    def run(self, function: Callable[[Any], Any], tasks: Sequence[Any], limits: Limits) -> Iterator[Outcome[Any, Any]]:
        """See `Runner.run`."""
        for task in reversed(tasks):
            self.done.append(task.item.shape)
            yield Outcome(task, function(task))


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A made-up data folder with meshes and pairs: of three shapes one is held out."""
    root = tmp_path_factory.mktemp("tree")
    make_data(root, shapes=3, views=1, held_out=1)
    add_meshes(root)
    return root


def test_the_command_writes_a_tree(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cubist")
    out = root / "tree.json"
    words = ["decision-tree", root, root / "pairs.jsonl", "-o", out, "--pixels", "800", "--workers", "0"]
    record = printed(capsys, *words)
    assert (record["shapes"], record["views"], record["lines_chosen_on_views"]) == (1, 1, 1)
    assert 0 < record["pixels"] <= 800
    assert len(Tree.load(out).rules) == record["rules"] > 0


def test_who_is_first_makes_no_difference(root: Path) -> None:
    pytest.importorskip("cubist")
    backwards = Backwards()
    trees = [train_tree(root, root / "pairs.jsonl", runner, 400) for runner in (HereRunner(), backwards)]
    assert trees[0] == trees[1]
    # The leaves are learnt on one shape, and what counts as a line on the other; none is held out.
    assert backwards.done == ["s001", "s002"]


def test_too_little_to_learn_from_is_refused(root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pairs = root / "pairs.jsonl"
    one = tmp_path / "one.jsonl"
    lines = pairs.read_text(encoding="utf-8").splitlines(keepends=True)
    one.write_text("".join(line for line in lines if "s001" in line), encoding="utf-8")
    with pytest.raises(InputError, match=r'1 training shapes; expected pairs with "split": "train" of two'):
        train_tree(root, one, HereRunner())
    with pytest.raises(ArgumentError, match="pixels"):
        train_tree(root, pairs, HereRunner(), pixels=10)
    found = complaint(capsys, "decision-tree", root, pairs, "-o", root / "none" / "tree.json")
    assert "its folder doesn't exist" in found
