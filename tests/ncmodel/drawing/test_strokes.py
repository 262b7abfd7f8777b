"""Segments into strokes: chains, simplification, pen travel."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ncmodel.camera import Camera
from ncmodel.drawing.strokes import ALPHA_TOLERANCE, strokes
from ncmodel.lines.chaining import Chains, chain, connected
from ncmodel.mesh.weld import coincident, rounding
from ncmodel.types import Floats, Ints, LineFamily, Segments, Stroke

CAMERA = Camera((0.0, 0.0, 3.0), focal_pixels=300.0)
PIXELS_PER_UNIT = 100.0  # at z = 0


def segments_of(*paths: Floats) -> Floats:
    return np.concatenate([np.stack([path[:-1], path[1:]], axis=1) for path in paths])


def shuffled(segments: Floats, rng: np.random.Generator, noise: float = 0.0) -> tuple[Floats, Ints]:
    """The same segments in any order and direction, their ends moved a little; and where each one came from."""
    order = rng.permutation(len(segments))
    mixed = segments[order].copy()
    flip = rng.random(len(mixed)) < 0.5
    mixed[flip] = mixed[flip][:, ::-1]
    return mixed + noise * rng.uniform(-1, 1, mixed.shape), order


def lists(chains: Chains) -> list[list[int]]:
    return [chains.segment[a:b].tolist() for a, b in itertools.pairwise(chains.first)]


def wave(n: int, y: float, rng: np.random.Generator) -> Floats:
    x = np.linspace(-1, 1, n)
    return np.stack([x, y + 0.1 * np.sin(9 * x + y), 0.02 * rng.normal(size=n)], axis=1)


def strokes_of(
    points: Floats, alpha: Floats | None = None, tolerance: float = 0.25, shortest: float = 0.0
) -> list[Stroke]:
    opacity = np.ones(points.shape[:2]) if alpha is None else alpha
    lines = Segments(LineFamily.RIDGES, points, opacity, np.zeros(len(points), dtype=np.int64))
    return list(strokes(lines, CAMERA, tolerance, shortest))


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


def test_points_on_grid_lines_are_matched_all_the_same() -> None:
    rng = np.random.default_rng(1)
    # Multiples of the cell size, where rounding to a grid falls either way.
    exact = rng.integers(0, 2**20, (2000, 3)) * 2.0**-20
    exact[:2] = [[0, 0, 0], [1, 1, 1]]
    pair = np.concatenate([exact, np.clip(exact + rng.uniform(-1e-12, 1e-12, exact.shape), 0, 1)])
    number = coincident(pair, rounding(pair))
    np.testing.assert_array_equal(number[:2000], number[2000:])
    assert len(np.unique(number)) > 1990


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


@settings(max_examples=40, deadline=None)
@given(st.integers(2, 200), st.floats(0.01, 5.0), st.integers(0, 1000))
def test_simplified_strokes_stay_within_tolerance(n: int, tolerance: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    path = np.cumsum(rng.normal(0, 0.02, (n, 3)) * [1, 1, 0], axis=0)
    opacity = np.clip(np.cumsum(rng.normal(0, 0.03, n)) + 0.5, 0, 1)
    (stroke,) = strokes_of(segments_of(path), segments_of(opacity), tolerance)
    pixels = CAMERA.project(path)[:, :2]
    kept = [int(np.flatnonzero((pixels == p).all(axis=1))[0]) for p in stroke.points]
    if kept[0] > kept[-1]:
        kept, stroke = kept[::-1], pen_reversed(stroke)
    assert kept[0] == 0
    assert kept[-1] == n - 1
    for (a, b), k in zip(itertools.pairwise(kept), range(len(kept)), strict=False):
        way = pixels[b] - pixels[a]
        along = np.clip((pixels[a : b + 1] - pixels[a]) @ way / max(way @ way, 1e-300), 0, 1)
        off = np.linalg.norm(pixels[a : b + 1] - pixels[a] - along[:, None] * way, axis=1)
        assert off.max() <= tolerance * (1 + 1e-9)
        faded = stroke.alpha[k] + along * (stroke.alpha[k + 1] - stroke.alpha[k])
        assert np.abs(faded - opacity[a : b + 1]).max() <= ALPHA_TOLERANCE * (1 + 1e-9)


def pen_reversed(stroke: Stroke) -> Stroke:
    return Stroke(stroke.family, stroke.points[::-1], stroke.alpha[::-1])


def test_straight_line_of_even_opacity_is_two_points_and_tolerance_zero_keeps_all() -> None:
    line = segments_of(np.linspace([-1.0, -0.5, 0], [1, 0.5, 0], 300))
    assert [len(s.points) for s in strokes_of(line)] == [2]
    bent = segments_of(wave(300, 0.0, np.random.default_rng(5)))
    assert [len(s.points) for s in strokes_of(bent, tolerance=0.0)] == [300]


def test_taper_survives_on_a_straight_line() -> None:
    line = segments_of(np.linspace([-1.0, 0, 0], [1, 0, 0], 101))
    fade = segments_of(np.minimum(np.linspace(0, 4, 101), 1.0))
    (stroke,) = strokes_of(line, fade)
    ordered = stroke if stroke.alpha[0] < 0.5 else pen_reversed(stroke)
    np.testing.assert_allclose(ordered.alpha, [0, 1, 1], atol=ALPHA_TOLERANCE)
    np.testing.assert_allclose(ordered.points[1, 0], 384 - 50, atol=2.0)


def test_short_strokes_can_be_left_out() -> None:
    long, short = np.linspace([-1.0, 0, 0], [1, 0, 0], 5), np.linspace([0.0, 0.5, 0], [0.01, 0.5, 0], 5)
    assert len(strokes_of(segments_of(long, short))) == 2
    assert len(strokes_of(segments_of(long, short), shortest=1.01)) == 1
    assert len(strokes_of(segments_of(long, short), shortest=0.99)) == 2


def test_edges_seen_end_on_are_no_strokes() -> None:
    towards_the_eye = np.array([[[0.5, 0.25, 0.0], [0.25, 0.125, 1.5]]])
    assert np.ptp(CAMERA.project(towards_the_eye[0])[:, :2], axis=0).max() < 1e-9
    assert strokes_of(towards_the_eye) == []
    assert strokes_of(towards_the_eye, tolerance=0.0) == []


def test_spurs_shorter_than_the_tolerance_merge_into_what_they_end_on() -> None:
    line = np.linspace([-1.0, 0, 0], [1, 0, 0], 5)
    spur = np.array([[0.0, 0, 0], [0, 0.002, 0]])  # a fifth of a pixel
    alone = spur + [0.0, 0.5, 0]
    both = segments_of(line, spur, alone)
    assert len(strokes_of(both, tolerance=0.25)) == 2
    assert len(strokes_of(both, tolerance=0.1)) == 3
    assert len(strokes_of(segments_of(spur, alone), tolerance=0.25)) == 2
