"""Consensus, reliability and held-out shapes; order never matters and sentinels never become pairs."""

import json
import random
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dataset_tools.votes.agreement import krippendorff_alpha
from dataset_tools.votes.careless_responding import flags
from dataset_tools.votes.consensus import Rules, aggregate
from dataset_tools.votes.dawid_skene import one_coin
from dataset_tools.votes.reliability import assess, counted
from dataset_tools.votes.votes import Vote, to_frame
from ncmodel.data.item import Item
from ncmodel.data.pairs import write_pairs
from ncmodel.errors import UsageError
from tests.helpers.crowd_data import vote


def sentinel(worker: str, passed: bool, **more: object) -> Vote:
    return vote(worker, "checked", 0 if passed else 3, sentinel=True, passed=passed, question=9, **more)


def on_item(*choices: int) -> list[Vote]:
    return [vote(f"w{i}", "shape", choice) for i, choice in enumerate(choices)]


@pytest.mark.parametrize(
    ("choices", "best"),
    [
        ((4, 4, 1), 4),
        ((4, 4, 4), 4),
        ((4, 4), 4),
        ((4,), None),
        ((4, 1, 2), None),
        ((-1, -1, 4), None),
        ((4, -1, 4), 4),
        ((4, 4, 1, 1), None),
        ((4, 4, 1, 2), None),
        ((4, 4, 4, 1), 4),
        ((0, 0, 7), 0),
    ],
)
def test_two_of_three_agree(choices: tuple[int, ...], best: int | None) -> None:
    found = aggregate(to_frame(on_item(*choices)), Rules())
    assert found.verdicts[0].best == best
    pairs = found.pairs()
    assert len(pairs) == (0 if best is None else 7)
    assert all(pair.better == best and pair.worse != best for pair in pairs)
    if best is not None:
        assert {pair.worse for pair in pairs} == set(range(8)) - {best}
        assert {(pair.votes_for, pair.votes) for pair in pairs} == {(choices.count(best), len(choices))}


def test_one_failed_sentinel_makes_all_answers_count_for_nothing() -> None:
    votes = [*on_item(4, 4, 1), sentinel("w0", passed=True), sentinel("w1", passed=False)]
    found = aggregate(to_frame(votes), Rules())
    assert found.verdicts[0].votes == {1: 1, 4: 1}
    assert found.participants["w1"].reasons == ("failed 1 of 1 sentinels",)
    assert found.participants["w0"].reliable
    assert aggregate(to_frame(votes), Rules(unreliable_too=True)).verdicts[0].best == 4


def test_a_failed_sentinel_in_a_later_questionnaire_counts_too() -> None:
    later = sentinel("w0", passed=False, assignment="z", submitted="2026-01-02T00:00:00Z")
    assert not assess(to_frame([vote("w0", "s", 1, submitted="2026-01-01T00:00:00Z"), later]))["w0"].reliable


def test_the_first_questionnaire_counts() -> None:
    first = vote("w", "one", 1, assignment="b", submitted="2026-01-01T00:00:00Z")
    second = vote("w", "two", 2, assignment="a", submitted="2026-01-02T00:00:00Z")
    for votes in ([first, second], [second, first]):
        participants = assess(to_frame(votes))
        assert counted(to_frame(votes), participants).equals(to_frame([first]))
        assert participants["w"].later == (("a", "q"),)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from(["majority", "one-coin"]))
def test_order_of_votes_changes_nothing_and_sentinels_never_become_pairs(seed: int, method: str) -> None:
    rng = random.Random(seed)
    votes = [
        vote(f"w{w}", f"s{rng.randrange(6)}", rng.randrange(-1, 8), assignment=f"a{rng.randrange(2)}", question=q)
        for w in range(8)
        for q in range(6)
    ]
    votes += [sentinel(f"w{w}", rng.random() < 0.8, assignment="a0") for w in range(8)]
    rules = Rules(method=method)  # type: ignore[arg-type]
    before = aggregate(to_frame(votes), rules)
    rng.shuffle(votes)
    after = aggregate(to_frame(votes), rules)
    assert before.pairs() == after.pairs()
    assert before.summary() == after.summary()
    assert "checked" not in {pair.item.shape for pair in after.pairs()}


def test_shapes_are_held_out_whole() -> None:
    places = [(w, s, v) for w in range(3) for s in range(30) for v in range(2)]
    votes = [vote(f"w{w}-{s}-{v}", f"s{s}", 2, view=str(v)) for w, s, v in places]
    pairs = aggregate(to_frame(votes), Rules()).pairs()
    split = {(pair.item.shape, pair.split) for pair in pairs}
    assert Counter(name for _, name in split) == {"train": 27, "validation": 3}
    assert len(split) == 30


@pytest.mark.parametrize(("shapes", "expected"), [(1, 0), (2, 1), (4, 1), (10, 1), (16, 2)])
def test_small_collections_hold_out_at_least_one_shape(shapes: int, expected: int) -> None:
    votes = [vote(f"w{w}{s}", f"s{s}", 2) for w in range(3) for s in range(shapes)]
    assert len(aggregate(to_frame(votes), Rules()).validation) == expected


def test_shapes_to_hold_out_can_be_named() -> None:
    votes = [vote(f"w{w}{s}", f"s{s}", 2) for w in range(3) for s in range(5)]
    assert aggregate(to_frame(votes), Rules(validation_shapes=("s1", "s4"))).validation == {"s1", "s4"}
    with pytest.raises(UsageError, match="nobody, which has no votes"):
        aggregate(to_frame(votes), Rules(validation_shapes=("nobody",)))
    with pytest.raises(UsageError) as found:
        aggregate(to_frame(votes), Rules(validation_shapes=("s1", "skipped", "nobody")))
    assert str(found.value).endswith(
        "found nobody, skipped, which have no votes, expected some of the 5 shapes that were voted on"
    )


def test_pairs_file(tmp_path: Path) -> None:
    votes = [vote(f"w{i}", "shape", 4, source="simulated") for i in range(3)]
    write_pairs(tmp_path / "pairs.jsonl", aggregate(to_frame(votes), Rules()).pairs())
    lines = [json.loads(line) for line in (tmp_path / "pairs.jsonl").read_text().splitlines()]
    assert len(lines) == 7
    assert lines[0] == {
        "shape": "shape", "view": 0, "better": 4, "worse": 0, "votes_for": 3, "votes": 3, "split": "train",
        "source": "simulated",
    }  # fmt: skip


def crowd(rng: np.random.Generator, items: int, accuracies: list[float]) -> tuple[list[Vote], dict[Item, int]]:
    truth = {Item(f"s{i}", "0"): int(rng.integers(-1, 8)) for i in range(items)}
    votes = []
    for item, right in truth.items():
        for worker, accuracy in enumerate(accuracies):
            wrong = [choice for choice in range(-1, 8) if choice != right]
            choice = right if rng.random() < accuracy else int(rng.choice(wrong))
            votes.append(vote(f"w{worker}", item.shape, choice))
    return votes, truth


def test_one_coin_finds_who_is_right() -> None:
    """Two good participants against three who guess: the majority errs where one coin a participant doesn't."""
    votes, truth = crowd(np.random.default_rng(0), 300, [0.95, 0.95, 1 / 9, 1 / 9, 1 / 9])
    frame = to_frame(votes)
    believed = one_coin(frame)
    right = np.mean([int(np.argmax(believed[item].probabilities)) - 1 == choice for item, choice in truth.items()])
    plurality = np.mean([verdict.choice == truth[verdict.item] for verdict in aggregate(frame, Rules()).verdicts])
    assert right > 0.9
    assert right > plurality + 0.2


def test_one_coin_reaches_a_stationary_point() -> None:
    """More sweeps change nothing: the iteration has converged and didn't just stop."""
    votes, _ = crowd(np.random.default_rng(1), 80, [0.9, 0.6, 0.5, 0.3])
    short, long = one_coin(to_frame(votes), iterations=200), one_coin(to_frame(votes), iterations=2000, tolerance=0.0)
    assert max(np.abs(short[i].probabilities - long[i].probabilities).max() for i in short) < 1e-5
    assert all(belief.probabilities.sum() == pytest.approx(1.0) for belief in short.values())


def test_one_coin_posterior_of_unanimous_strangers() -> None:
    """Closed form: everybody agrees, so all accuracies are (n + 4) / (n + 6) with n = 1 answer each."""
    belief = one_coin(to_frame(on_item(3, 3, 3)))[Item("shape", "0")].probabilities
    accuracy = 5 / 7
    odds = (accuracy / ((1 - accuracy) / 8)) ** 3
    assert belief[4] == pytest.approx(odds / (odds + 8), abs=2e-3)


@pytest.mark.parametrize("bad", [{"least": 0}, {"held_out": 1.0}, {"held_out": -0.1}, {"posterior": 0.0}])
def test_rules_that_make_no_sense(bad: dict[str, float]) -> None:
    with pytest.raises(UsageError, match="expected"):
        Rules(**bad)  # type: ignore[arg-type]


def test_alpha_of_perfect_and_of_no_agreement() -> None:
    agreed = [vote(f"w{w}", f"s{s}", s % 8) for w in range(3) for s in range(16)]
    assert krippendorff_alpha(to_frame(agreed)) == pytest.approx(1.0)
    rng = np.random.default_rng(0)
    guessed = [vote(f"w{w}", f"s{s}", int(rng.integers(-1, 8))) for w in range(3) for s in range(400)]
    assert krippendorff_alpha(to_frame(guessed)) == pytest.approx(0.0, abs=0.05)
    assert krippendorff_alpha(to_frame([vote("w", "s", 1)])) is None


@pytest.mark.parametrize(
    ("positions", "sign"),
    [([3] * 12, "answer 3 in 12 of 12"), ([1, 2, 3, 4, 5, 6, 7, 8] * 2, "steps of 1"), ([2, 6] * 8, "steps of 4")],
)
def test_patterns_of_positions_are_seen(positions: list[int], sign: str) -> None:
    votes = [vote("w", f"s{i}", 1, question=i + 1, position=place) for i, place in enumerate(positions)]
    assert sign in "; ".join(flags(to_frame(votes))["w"])


def test_haste_and_copies_are_seen() -> None:
    hasty = [vote("fast", f"s{i}", i % 8, question=i + 1, seconds=0.4, questionnaire="h") for i in range(10)]
    twins = [vote(name, f"s{i}", i % 8, question=i + 1) for name in ("ann", "bob") for i in range(10)]
    found = flags(to_frame([*hasty, *twins]))
    assert "0.4 s a question" in found["fast"]
    assert found["ann"] == ("same answers as bob",)
    assert found["bob"] == ("same answers as ann",)
