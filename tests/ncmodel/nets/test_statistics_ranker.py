"""The ranker on numbers: scales, votes, weights from a seed, and presets with and without it."""

from dataclasses import replace
from pathlib import Path

import pytest
import torch

from ncmodel.nets.checkpoints import Checkpoint, load_checkpoint, save_checkpoint
from ncmodel.nets.presets import PRESETS, Preset, StatisticsDims
from ncmodel.nets.statistics_ranker import VOICES, StatisticsRanker
from tests.helpers.counted import COUNTING

DIMS = StatisticsDims(numbers=5, settings=4, width=3, networks=2)


def ranker(seed: int = 0) -> StatisticsRanker:
    network = StatisticsRanker(DIMS).eval()
    network.initialise(torch.Generator().manual_seed(seed))
    return network


def test_scores_are_the_mean_of_the_networks_votes() -> None:
    network, numbers = ranker(), torch.randn(7, 5)
    votes = network.votes(numbers)
    assert votes.shape == (2, 7)
    assert torch.equal(network(numbers), votes.mean(dim=0))
    assert not torch.allclose(votes[0], votes[1])
    # Each network may be given its own drawings.
    other = torch.randn(7, 5)
    torch.testing.assert_close(network.votes(torch.stack([numbers, other]))[0], votes[0])


def test_scales_do_not_matter_once_they_are_measured_and_constants_count_nothing() -> None:
    numbers = torch.randn(50, 5)
    numbers[:, 4] = 3.0
    scaled = numbers * torch.tensor([1.0, 10.0, 100.0, 0.1, 1.0]) + 7.0
    first, second = ranker(), ranker()
    first.fit_scales(numbers)
    second.fit_scales(scaled)
    torch.testing.assert_close(first(numbers), second(scaled), rtol=1e-3, atol=1e-4)
    assert first.inverse_scale[4] == 0.0
    numbers[:, 4] = 1e6
    torch.testing.assert_close(first(numbers), second(scaled), rtol=1e-3, atol=1e-4)


def test_the_seed_decides_the_weights() -> None:
    a, b, c = (ranker(seed).state_dict() for seed in (1, 1, 2))
    assert all(torch.equal(a[name], b[name]) for name in a)
    assert not torch.equal(a["first"], c["first"])


def test_before_training_numbers_alone_count() -> None:
    assert dict(zip(VOICES, ranker().mix.tolist(), strict=True)) == {"statistics": 1.0, "habit": 0.0, "picture": 0.0}


@pytest.mark.parametrize("wrong", [{"numbers": 0}, {"networks": 0}, {"dropout": 1.0}, {"dropout": -0.1}])
def test_dimensions_that_make_no_sense(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="expected positive numbers and a share"):
        replace(DIMS, **wrong)  # type: ignore[arg-type]


def test_stages_of_presets() -> None:
    three = ("ranker", "translator", "finetune")
    assert {name: preset.stages for name, preset in PRESETS.items()} == {
        "paper": three,
        "small": (*three, "statistics"),
        "tiny": (*three, "statistics"),
    }
    assert COUNTING.rates("statistics") == COUNTING.counting
    assert COUNTING.rates("finetune") == COUNTING.finetune


@pytest.mark.parametrize("preset", [*PRESETS.values(), COUNTING], ids=lambda preset: preset.name)
def test_presets_go_to_headers_and_back(preset: Preset) -> None:
    assert Preset.from_record(preset.to_record()) == preset


def test_headers_of_before_have_no_ranker_on_numbers() -> None:
    record = PRESETS["tiny"].to_record()
    del record["statistics"], record["counting"]
    assert Preset.from_record(record) == replace(PRESETS["tiny"], statistics=None)


def test_checkpoints_hold_it(tmp_path: Path) -> None:
    network = StatisticsRanker(StatisticsDims(width=8, networks=2, dropout=0.1))
    network.initialise(torch.Generator().manual_seed(0))
    network.habit.copy_(torch.arange(256.0))
    save_checkpoint(tmp_path / "m", Checkpoint(COUNTING, statistics=network))
    loaded = load_checkpoint(tmp_path / "m")
    assert list(loaded.networks) == ["statistics"]
    assert loaded.statistics is not None
    state = loaded.statistics.state_dict()
    assert all(torch.equal(value, state[name]) for name, value in network.state_dict().items())
