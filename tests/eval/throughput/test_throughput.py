"""What is measured of training steps, and what that makes on the paper's set."""

import json
from pathlib import Path

import pytest
import torch

from eval.throughput import pictures
from eval.throughput.__main__ import main, setups_of
from eval.throughput.drawing import Agreement
from eval.throughput.growth import EXCHANGE, ITEMS, growth_of
from eval.throughput.pictures import write_views
from eval.throughput.report import Throughput, drawing_rows, growth_rows, speed_rows
from eval.throughput.training import Setup, Speed, measure_speed
from ncmodel.data.data_folder import DataFolder
from ncmodel.nets.presets import PRESETS
from tests.helpers.micro_training import MICRO

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture
def micro(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PRESETS, "micro", MICRO)
    monkeypatch.setattr(pictures, "SIDE", 96)


@pytest.mark.usefixtures("micro")
@pytest.mark.parametrize("stage", ["ranker", "translator", "finetune"])
def test_steps_of_every_stage_are_measured(tmp_path: Path, stage: str) -> None:
    pairs = write_views(tmp_path, 10)
    assert {pair.split for pair in pairs} == {"train", "validation"}
    setup = Setup("micro", stage, False, 0)
    found = measure_speed(setup, DataFolder(tmp_path), pairs, torch.device("cpu"), 0.05)
    assert found.steps >= 1
    assert not found.failure
    per_step = MICRO.rates(stage).batch
    assert 0.7 * per_step <= found.batch <= 1.5 * per_step
    assert found.pairs == pytest.approx(found.batch / found.seconds, rel=0.5)
    assert 0 < found.views <= found.pairs
    assert found.memory > 0


@pytest.mark.usefixtures("micro")
def test_a_setup_that_fails_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise torch.OutOfMemoryError("CUDA out of memory.\nTried to allocate 2 GiB")

    monkeypatch.setattr("eval.throughput.training.Trainer.step", full)
    pairs = write_views(tmp_path, 10)
    found = measure_speed(Setup("micro", "ranker", False, 0), DataFolder(tmp_path), pairs, torch.device("cpu"), 0.05)
    assert (found.steps, found.failure) == (0, "CUDA out of memory. Tried to allocate 2 GiB")


@pytest.mark.usefixtures("micro")
def test_the_command_writes_tables_within_its_time(tmp_path: Path) -> None:
    main(tmp_path / "out", presets="micro", workers=1, seconds=0.01, views=10, drawing=False)
    record = json.loads((tmp_path / "out" / "throughput.json").read_text())
    assert record["training"] == []
    assert len(record["left_out"]) == len(setups_of(["micro"], 1, several=False)) == 12
    assert "Left out for want of time: micro ranker, 1 workers;" in (tmp_path / "out" / "throughput.md").read_text()
    assert "<table>" in (tmp_path / "out" / "throughput.html").read_text()


def test_what_matters_most_is_measured_first() -> None:
    setups = setups_of(["paper", "tiny"], 8, several=True)
    assert setups[:3] == [Setup("paper", stage, True, 8) for stage in ("ranker", "translator", "finetune")]
    assert [setup.batch for setup in setups[3:6]] == [4, 1, 4]
    assert len(setups) == len(set(setups)) == 2 * 3 * 4 + 3
    assert setups_of(["paper"], 8, several=False)[0] == Setup("paper", "ranker", False, 8)


def test_growth_is_computed_from_measured_steps() -> None:
    whole = Speed(Setup("paper", "ranker", True, 8), 32, 10, 0.5, 10.0, 64.0, 20.0, 50_000_000)
    part = Speed(Setup("paper", "ranker", True, 8, 4), 4, 10, 0.1, 10.0, 40.0, 3.0, 50_000_000)
    one, *rest = growth_of([whole, part])
    assert not rest
    steps = ITEMS * 7 / 32
    assert one.steps == round(steps)
    assert one.hours == pytest.approx(20 * steps * 0.5 / 3600, rel=1e-4)
    exchange = 2 * 7 / 8 * 4 * 50_000_000 / EXCHANGE
    assert one.hours_on_many == pytest.approx(20 * steps * (0.1 + exchange) / 3600, rel=1e-4)
    assert growth_of([whole])[0].hours_on_many == 0.0


def test_what_failed_and_what_was_drawn_stand_in_the_report(tmp_path: Path) -> None:
    failed = Speed(Setup("paper", "finetune", False, 0), 32, failure="out of memory")
    assert speed_rows([failed])[1][5] == "out of memory"
    assert growth_rows(growth_of([failed])) == growth_rows([])
    drawn = Agreement("draft", 15.0, 1.5, 1e-5, 1e-4, ((0.1, None, 0.2, 0.3), (0.1, None, 0.2, 0.3)), 0.001)
    Throughput({"device": "a GPU"}, [failed], drawing=drawn).write(tmp_path)
    text = (tmp_path / "throughput.md").read_text()
    assert "| thresholds on the device | 0.100 – 0.200 0.300 |" in text
    assert "0.10%" in {row[1] for row in drawing_rows(drawn)}
