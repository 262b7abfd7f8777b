"""Chains into strokes: projection, simplification, tapers, what is too short."""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ncmodel.drawing.strokes import ALPHA_TOLERANCE
from tests.helpers.strokes import CAMERA, pen_reversed, segments_of, strokes_of, wave


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
