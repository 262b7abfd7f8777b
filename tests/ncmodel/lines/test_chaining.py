"""Segments into chains: paths, loops, crossings, junctions."""

import itertools

import numpy as np
import pytest

from ncmodel.lines.chaining import Chains, chain, connected
from ncmodel.types import Floats, Ints
from tests.helpers.strokes import PIXELS_PER_UNIT, segments_of, strokes_of, wave


def shuffled(segments: Floats, rng: np.random.Generator, noise: float = 0.0) -> tuple[Floats, Ints]:
    """The same segments in any order and direction, their ends moved a little; and where each one came from."""
    order = rng.permutation(len(segments))
    mixed = segments[order].copy()
    flip = rng.random(len(mixed)) < 0.5
    mixed[flip] = mixed[flip][:, ::-1]
    return mixed + noise * rng.uniform(-1, 1, mixed.shape), order


def lists(chains: Chains) -> list[list[int]]:
    return [chains.segment[a:b].tolist() for a, b in itertools.pairwise(chains.first)]


@pytest.mark.parametrize("noise", [0.0, 1e-9])
def test_paths_are_found_again(noise: float) -> None:
    rng = np.random.default_rng(0)
    paths = [wave(n, y, rng) for n, y in ((50, -1.0), (2, -0.5), (200, 0.0), (31, 0.7))]
    mixed, origin = shuffled(segments_of(*paths), rng, noise)
    found = chain(mixed)
    expected = [list(range(a, b)) for a, b in itertools.pairwise(np.cumsum([0, 49, 1, 199, 30]))]
    got = [origin[c].tolist() for c in lists(found)]
    assert sorted(min(c, c[::-1]) for c in got) == expected
    starts = mixed[found.segment, found.flipped.astype(int)]
    ends = mixed[found.segment, 1 - found.flipped.astype(int)]
    for a, b in itertools.pairwise(found.first):
        np.testing.assert_allclose(ends[a : b - 1], starts[a + 1 : b], atol=3 * noise + 1e-15)


def test_loop_is_one_chain_and_closed() -> None:
    angle = np.linspace(0, 2 * np.pi, 100)
    circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    circle[-1] = circle[0]
    mixed, _ = shuffled(segments_of(circle), np.random.default_rng(2))
    assert [len(c) for c in lists(chain(mixed))] == [99]
    (stroke,) = strokes_of(mixed)
    np.testing.assert_allclose(stroke.points[0], stroke.points[-1], atol=1e-6)
    assert np.abs(np.linalg.norm(stroke.points - 384.0, axis=1) - PIXELS_PER_UNIT).max() < 0.01


def test_duplicates_and_points_are_dropped() -> None:
    path = wave(20, 0.0, np.random.default_rng(3))
    segments = segments_of(path)
    crowded = np.concatenate([segments, segments[::-1, ::-1], segments + 1e-10, path[:, None].repeat(2, axis=1)])
    assert [len(c) for c in lists(chain(crowded))] == [19]


def test_straightest_way_on_is_taken_at_crossings() -> None:
    across = np.linspace([-1.0, 0, 0], [1, 0.2, 0], 9)
    down = np.linspace([0.0, 1.1, 0], [0, -0.9, 0], 9)
    assert sorted(map(sorted, lists(chain(segments_of(across, down))))) == [list(range(8)), list(range(8, 16))]


def test_third_line_ends_at_a_junction() -> None:
    through = np.linspace([-1.0, 0, 0], [1, 0, 0], 5)
    branch = np.linspace([0.0, 0, 0], [0.1, 1, 0], 5)
    assert sorted(map(len, lists(chain(segments_of(through, branch))))) == [4, 4]


def test_star_of_many_lines_stays_apart() -> None:
    angle = np.linspace(0, 2 * np.pi, 41)[:-1]
    star = np.stack([np.zeros((40, 3)), np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)], axis=1)
    assert len(chain(star)) == 40


def test_nothing() -> None:
    assert len(chain(np.zeros((0, 2, 3)))) == 0
    assert strokes_of(np.zeros((0, 2, 3))) == []
    assert len(chain(np.ones((3, 2, 3)))) == 0
    assert strokes_of(np.ones((3, 2, 3))) == []
    assert len(connected(np.zeros((0, 2, 3)))) == 0


def test_connected_segments_share_a_number() -> None:
    rng = np.random.default_rng(4)
    tree = segments_of(np.linspace([0.0, 0, 0], [1, 0, 0], 6), np.linspace([0.4, 0, 0], [0.4, 1, 0], 6))
    mixed, origin = shuffled(np.concatenate([tree, tree + [0, 0, 1]]), rng)
    number = connected(mixed)
    assert len(np.unique(number)) == 2
    assert len(np.unique(number[origin < 10])) == 1
