"""A training that is stopped within a pass goes on there, and ends in the same bytes as if nothing had happened."""

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch
from torch import Tensor

from ncmodel.nets.checkpoints import load_tensors
from ncmodel.nets.presets import Rates, StatisticsDims
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.training.loop import Means, Plan, fit
from ncmodel.training.objectives import FinetuneObjective, RankerObjective, TranslatorObjective
from ncmodel.training.state import STATE_KIND
from ncmodel.training.statistics import StatisticsObjective
from ncmodel.training.train import TrainOptions, run_training
from tests.helpers.counted import COUNTING, MadeNumbers, ink_pairs
from tests.helpers.micro_training import MICRO, Interrupted

pytestmark = pytest.mark.usefixtures("one_thread")

SHORT = replace(MICRO, ranker=Rates(1e-3, 8, 2), translator=Rates(1e-3, 2, 2), finetune=Rates(1e-4, 8, 2))
"""Passes of several steps."""


def kill_at(monkeypatch: pytest.MonkeyPatch, objective: type, step: int) -> None:
    """Have a stage break off in a step, when its state has been written after the one before."""
    loss, steps = objective.loss, 0  # type: ignore[attr-defined]

    def breaking(self: Any, batch: Any) -> Tensor:
        nonlocal steps
        steps += 1
        if steps == step:
            raise Interrupted
        found: Tensor = loss(self, batch)
        return found

    monkeypatch.setattr(objective, "loss", breaking)


@pytest.mark.parametrize(
    ("stage", "objective"),
    [("ranker", RankerObjective), ("translator", TranslatorObjective), ("finetune", FinetuneObjective)],
)
def test_killed_within_a_pass_and_resumed_equals_uninterrupted(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stage: str, objective: type
) -> None:
    def train(out: str, stages: tuple[str, ...], save_every: float = 300.0) -> None:
        options = TrainOptions(stages=stages, save_every=save_every)
        run_training(data, data / "pairs.jsonl", tmp_path / out, SHORT, options)

    before = ("ranker", "translator") if stage == "finetune" else ()
    for out in ("whole", "broken"):
        if before:
            train(out, before)
    train("whole", (stage,))
    steps = 3 if stage == "translator" else 5  # of a pass
    with monkeypatch.context() as patched:
        kill_at(patched, objective, steps + 3)
        with pytest.raises(Interrupted):
            train("broken", (stage,), save_every=1e-9)
    _, header = load_tensors(tmp_path / f"broken.{stage}.state", STATE_KIND)
    assert (len(header["history"]), len(header["losses"])) == (1, 2)
    train("broken", (stage,))
    for suffix in ("", ".history.json", f".{stage}.state"):
        assert (tmp_path / f"whole{suffix}").read_bytes() == (tmp_path / f"broken{suffix}").read_bytes()


def test_what_networks_draw_at_random_goes_on_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The ranker on numbers has dropout."""
    numbers = MadeNumbers(4)
    pairs = ink_pairs(numbers, held_out=("0",))

    def train(state: str, save_every: float = 300.0) -> bytes:
        assert COUNTING.statistics is not None
        ranker = StatisticsRanker(COUNTING.statistics)
        ranker.initialise(torch.Generator().manual_seed(0))
        objective = StatisticsObjective(COUNTING, ranker, numbers, pairs)
        fit(objective, Plan(tmp_path / state, {}, 2, seed=0, means=Means(save_every=save_every)))
        return (tmp_path / state).read_bytes()

    assert StatisticsDims().dropout > 0
    whole = train("whole")
    with monkeypatch.context() as patched:
        kill_at(patched, StatisticsObjective, 3)
        with pytest.raises(Interrupted):
            train("broken", save_every=1e-9)
    torch.manual_seed(12345)
    assert train("broken") == whole


def test_states_are_as_old_as_asked_for_and_no_more_often(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of steps that take 10 s each by a made-up clock, every third is written, and the last one of a long pass."""
    now, written = [0.0], []
    loss, save = RankerObjective.loss, "ncmodel.training.loop.save_state"

    def slow(self: RankerObjective, batch: Any) -> Tensor:
        now[0] += 10.0
        return loss(self, batch)

    monkeypatch.setattr(RankerObjective, "loss", slow)
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    monkeypatch.setattr(save, lambda path, settings, learner, done: written.append((learner.steps, len(done.losses))))
    options = TrainOptions(stages=("ranker",), epochs=1, save_every=30.0)
    run_training(data, data / "pairs.jsonl", tmp_path / "m", SHORT, options)
    assert written == [(3, 3), (5, 5), (5, 0)]


def test_a_finished_pass_leaves_no_trace_of_its_steps(data: Path, tmp_path: Path) -> None:
    options = TrainOptions(stages=("ranker",), epochs=1, save_every=1e-9)
    run_training(data, data / "pairs.jsonl", tmp_path / "m", SHORT, options)
    tensors, header = load_tensors(tmp_path / "m.ranker.state", STATE_KIND)
    assert "losses" not in header
    assert not [name for name in tensors if name.startswith("random.")]
    assert json.loads((tmp_path / "m.history.json").read_text())["ranker"][0]["epoch"] == 1
