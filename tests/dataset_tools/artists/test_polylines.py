"""Lines joined over gaps, and parted where something is drawn."""

import numpy as np
import pytest

from dataset_tools.artists.hand import Hand, smoothed
from dataset_tools.artists.motif import Motif
from dataset_tools.artists.polylines import STEP, Polyline, joined, resampled, runs, without
from tests.helpers.artists import bumpy_view


def straight(*ends: tuple[float, float]) -> Polyline:
    return resampled(np.array(ends), "ridges", np.ones(len(ends)))


def test_points_are_evenly_spaced_and_the_length_stays() -> None:
    line = resampled(np.array([(0.0, 0.0), (1.0, 0.0), (30.0, 0.0), (30.0, 20.0)]), "ridges", np.array([0.0, 1, 1, 0]))
    steps = np.linalg.norm(np.diff(line.points, axis=0), axis=1)
    assert line.length == pytest.approx(50.0)
    assert steps.max() <= STEP + 1e-9
    assert line.salience[0] == line.salience[-1] == 0.0


def test_lines_that_go_on_as_one_another_are_one() -> None:
    ahead = [straight((0, 0), (40, 0)), straight((90, 2), (50, 0)), straight((100, 2), (140, 4))]
    (one,) = joined(ahead, gap=12.0)
    assert sorted([one.points[0][0], one.points[-1][0]]) == [0.0, 140.0]
    assert one.length == pytest.approx(140.0, abs=1.0)


@pytest.mark.parametrize(
    "other",
    [
        pytest.param(straight((60, 0), (100, 0)), id="too far"),
        pytest.param(straight((45, 0), (45, 40)), id="round a corner"),
        pytest.param(straight((40, 8), (0, 8)), id="beside it"),
    ],
)
def test_other_lines_stay_apart(other: Polyline) -> None:
    line = straight((0, 0), (40, 0))
    assert {id(one) for one in joined([line, other], gap=12.0)} == {id(line), id(other)}


def test_a_ring_in_pieces_stays_whole_once() -> None:
    turn = np.linspace(0.0, 2 * np.pi, 61)
    ring = 50.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    pieces = [resampled(ring[i : i + 19], "ridges", np.ones(19)) for i in (0, 20, 40)]
    (one,) = joined(pieces, gap=12.0)
    assert one.length == pytest.approx(2 * np.pi * 50.0, rel=0.07)


def test_what_is_taken_is_left_out_and_crossings_are_crossed() -> None:
    line = straight((0, 0), (200, 0))
    x = line.points[:, 0]
    crossed = ((x > 40) & (x < 46)) | (x > 120)
    (part,) = without(line, crossed, crossing=10.0, shortest=20.0)
    assert part.points[0][0] == 0.0
    assert part.points[-1][0] == pytest.approx(120.0, abs=STEP)
    assert without(line, x > 15, crossing=10.0, shortest=20.0) == []
    assert runs(np.array([True, False, True, True])) == [(0, 1), (2, 4)]


def test_a_smoothed_line_keeps_its_ends_and_a_smoothed_ring_stays_closed() -> None:
    rng = np.random.default_rng(0)
    noisy = straight((0, 0), (100, 0)).points + rng.normal(0, 0.5, (51, 2))
    soft = smoothed(noisy, 8.0)
    assert np.allclose(soft[[0, -1]], noisy[[0, -1]], atol=1e-9)
    assert soft[:, 1].std() < 0.5 * noisy[:, 1].std()
    turn = np.linspace(0.0, 2 * np.pi, 200)
    ring = smoothed(50.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1), 8.0)
    assert np.linalg.norm(ring[0] - ring[-1]) < 2 * STEP


def test_a_sure_hand_draws_what_is_there_and_a_shaky_one_beside_it() -> None:
    motif, line = Motif(bumpy_view()), straight((200, 300), (500, 300))
    away = []
    for misplaced in (0.0, 3.0):
        rng = np.random.default_rng(1)
        hand = Hand(smoothing=8.0, misplaced=misplaced, wobble=0.0, overshoot=0.0)
        away.append(np.abs(hand.draw(line, hand.field(motif, rng), rng).points[:, 1] - 300.0))
    assert away[0].max() < 1e-6
    assert 0.3 < away[1].mean() < 8.0
    long = Hand(8.0, 0.0, 0.0, overshoot=30.0).draw(line, np.zeros((768, 768, 2), np.float32), np.random.default_rng(0))
    assert line.length < long.length < line.length + 60.0
