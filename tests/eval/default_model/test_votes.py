"""Simulated votes in rounds: who wins a question, and what later rounds set the winner against."""

import numpy as np
import pytest

from dataset_tools.simulation.participants import Crowd
from eval.default_model import votes
from eval.default_model.views import MeasuredView
from eval.default_model.votes import rounds
from ncmodel.data.item import Item
from ncmodel.drawing.settings import Levels
from ncmodel.types import Floats
from tests.helpers.counted import counted

SURE = Crowd(noise=0.0)


def view(distances: Floats) -> MeasuredView:
    return MeasuredView(Item("s", "0"), counted(np.random.default_rng(0)), distances, np.arange(0, 256, 32))


def agreed() -> MeasuredView:
    """All artists draw what setting 64 shows, and settings are the farther the more their number differs from it."""
    return view(np.tile(0.01 + np.abs(np.arange(256.0) - 64), (3, 1)))


def test_the_drawing_nearest_to_the_artists_wins_over_the_seven_others() -> None:
    pairs = rounds(agreed(), 1, SURE, "train", np.random.default_rng(0))
    assert {pair.better for pair in pairs} == {64}
    assert [pair.worse for pair in pairs] == [0, 32, 96, 128, 160, 192, 224]
    assert {(pair.item, pair.split, pair.source) for pair in pairs} == {(Item("s", "0"), "train", "simulated")}


def test_later_rounds_show_others_and_then_the_winner_with_its_neighbours() -> None:
    pairs = rounds(agreed(), 3, SURE, "validation", np.random.default_rng(0))
    assert len(pairs) == 21
    shown = {pair.worse for pair in pairs[14:]}
    assert {pair.better for pair in pairs[14:]} == {64}, "the first winner, shown again"
    settings = Levels().settings
    for other in shown:
        changed = [
            name
            for name in ("suggestive", "apparent", "ridges_valleys", "creases", "borders")
            if getattr(settings[other], name) != getattr(settings[64], name)
        ]
        assert 1 <= len(changed) <= 2


class Rolls:
    """Random numbers of which the artists that are asked are known."""

    def __init__(self, artists: list[int]) -> None:
        self.artists = artists

    def integers(self, high: int, size: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
        return np.array(self.artists[:size])

    def gumbel(self, size: tuple[int, int]) -> Floats:
        return np.zeros(size)


@pytest.mark.parametrize(("artists", "winner"), [([0, 1, 2], None), ([0, 1, 1], 1), ([2, 2, 2], 2), ([2, 0, 2], 2)])
def test_two_of_three_must_agree(artists: list[int], winner: int | None) -> None:
    distances = np.ones((3, 8)) - 0.5 * np.eye(3, 8)  # artist k drew drawing k
    assert votes._asked(distances, SURE, Rolls(artists)) == winner  # type: ignore[arg-type]


def test_without_a_winner_no_neighbours_are_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def nobody(distances: Floats, crowd: Crowd, rng: np.random.Generator) -> None:
        asked.append(distances.shape[1])

    def neighbours(setting: int) -> None:
        raise AssertionError("nothing has won yet")

    monkeypatch.setattr(votes, "_asked", nobody)
    monkeypatch.setattr(votes, "_neighbours", neighbours)
    assert rounds(agreed(), 6, SURE, "train", np.random.default_rng(0)) == []
    assert asked == [8] * 6


def test_neighbours_differ_least() -> None:
    near = votes._neighbours(0)
    assert len(set(near.tolist())) == votes.NEAR
    assert 0 not in near
    # One step of one filter or switch, all five of them, come before any two.
    assert set(near[:5].tolist()) == {1, 2, 4, 16, 64}
