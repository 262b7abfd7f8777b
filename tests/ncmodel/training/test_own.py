"""For people who train: a loss of their own, curves that open while training runs, a note on too few held-out views."""

import json
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from ncmodel.cli.main import main
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair
from ncmodel.nets.checkpoints import load_checkpoint
from ncmodel.nets.presets import PRESETS
from ncmodel.report.training_curves import RELOAD, Curves
from ncmodel.training import own
from ncmodel.training.dataset import ENOUGH_VIEWS, validation_notes
from ncmodel.training.own import objective_named
from tests.helpers.commands import complaint
from tests.helpers.micro_training import MICRO, run

pytestmark = pytest.mark.usefixtures("one_thread")

MODULE = """
from torch.nn.functional import softplus

from ncmodel.training.objectives import RankerObjective, score_batch


class Logistic(RankerObjective):
    def loss(self, pairs):
        scores = score_batch(self.ranker, pairs.batch)
        return softplus(scores[pairs.worse] - scores[pairs.better]).mean()


class Odd(RankerObjective):
    name = "odd"
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A user's module with a loss."""
    (tmp_path / "my_losses.py").write_text(MODULE)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "my_losses", raising=False)
    return "my_losses"


def test_a_loss_of_ones_own_trains_by_the_command_line(
    data: Path, tmp_path: Path, module: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(PRESETS, "micro", MICRO)
    out = tmp_path / "m"
    words = ["train", str(data), str(data / "pairs.jsonl"), "-o", str(out), "--preset", "micro", "--stage", "ranker"]
    mine = ["--objective", f"{module}:Logistic"]
    assert main([*words, *mine, "--micro-batch", "5", "--json"]) == 0
    history = json.loads(capsys.readouterr().out)["history"]["ranker"]
    assert 0.6 < history[0]["loss"] < 0.8  # near log 2, where the hinge loss is near 1
    assert history[-1]["loss"] < history[0]["loss"]
    assert list(load_checkpoint(out).networks) == ["ranker"]
    # Another loss doesn't go on with these weights.
    found = complaint(capsys, *words, "--epochs", "5")
    assert "an earlier training had objective my_losses:Logistic, now the preset's; expected the same" in found


def test_an_installed_package_s_loss_is_known_by_its_name(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    point = EntryPoint("logistic", f"{module}:Logistic", own.GROUP)
    found = {"logistic": [point]}
    monkeypatch.setattr(own, "entry_points", lambda group, name=None: found.get(name, []) if name else [point])
    assert objective_named("logistic").__name__ == "Logistic"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("hinge", "--objective: found 'hinge', expected pix2pixhd, MODULE:CLASS, or the name of an entry point in"),
        ("nowhere:Loss", "--objective: found 'nowhere:Loss' (ModuleNotFoundError: No module named 'nowhere')"),
        ("my_losses:None", "--objective: found 'my_losses:None' (AttributeError: "),
        (
            "my_losses:Odd",
            "'my_losses:Odd' of stage 'odd', expected a class whose name is ranker, translator, finetune",
        ),
    ],
)
def test_what_is_no_objective_is_told_in_a_line(
    data: Path, tmp_path: Path, module: str, capsys: pytest.CaptureFixture[str], name: str, message: str
) -> None:
    words = ["train", data, data / "pairs.jsonl", "-o", tmp_path / "m", "--objective", name]
    assert message in complaint(capsys, *words)


def test_curves_open_while_training_runs_and_stay_when_it_has_ended(data: Path, tmp_path: Path) -> None:
    run(data, tmp_path / "m", curves=True)
    page = (tmp_path / "m.curves.html").read_text()
    assert 'http-equiv="refresh"' not in page
    assert "Training has ended." in page
    assert [page.count(f">{stage}</h2>") for stage in ("Ranker", "Translator", "Finetune")] == [1, 1, 1]
    assert page.count("<svg") == 5  # losses of each stage, accuracy of two
    assert "2 views are held out: an accuracy on them is uncertain by 0.35" in page
    assert 'src="http' not in page
    assert 'href="http' not in page


def test_a_page_of_a_running_training_loads_itself_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("ncmodel.report.training_curves.time.monotonic", lambda: now[0])
    curves, path = Curves(tmp_path / "m.curves.html"), tmp_path / "m.curves.html"
    records = [{"epoch": 1, "loss": 0.5}]
    curves.show({"translator": records})
    assert f'<meta http-equiv="refresh" content="{RELOAD}">' in path.read_text()
    assert "Pass 1: loss 0.5000." in path.read_text()
    # It isn't drawn anew for every pass of moments.
    for now[0], expected in ((RELOAD - 1, "Pass 1"), (RELOAD, "Pass 2")):
        curves.show({"translator": [*records, {"epoch": 2, "loss": 0.4}]})
        assert expected in path.read_text()


def test_few_held_out_views_are_told_before_training(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(PRESETS, "micro", MICRO)
    words = ["train", str(data), str(data / "pairs.jsonl"), "-o", str(tmp_path / "m"), "--preset", "micro"]
    assert main([*words, "--stage", "ranker", "--epochs", "1"]) == 0
    first = capsys.readouterr().err.splitlines()[0]
    assert first.startswith("note: 2 views are held out: an accuracy on them is uncertain by 0.35")


def test_enough_held_out_views_are_not_spoken_of() -> None:
    def pairs(count: int) -> list[Pair]:
        return [Pair(Item(f"s{number}", "0"), 0, 1, "validation") for number in range(count)]

    assert validation_notes(pairs(ENOUGH_VIEWS)) == []
    assert "24 views are held out" in validation_notes(pairs(ENOUGH_VIEWS - 1))[0]
    assert "1 view is held out" in validation_notes(pairs(1))[0]
    assert "the last one is kept" in validation_notes([])[0]
