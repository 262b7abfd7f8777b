"""Thick anti-aliased lines against a brute-force rasteriser."""

import numpy as np
import pytest

from ncmodel.export.rasterize import draw_features, draw_segments
from ncmodel.types import Floats, Image

SHAPE = (20, 24)
SUBSAMPLES = 32


def covered(segment: Floats, width: float, shape: tuple[int, int] = SHAPE) -> tuple[Floats, Floats]:
    """The share of each pixel within half a width of a segment, by sampling, and where along it the pixel lies."""
    offsets = (np.arange(SUBSAMPLES) + 0.5) / SUBSAMPLES
    fine = [(np.arange(n)[:, None] + offsets).ravel() for n in shape]
    near = distance(segment, *np.meshgrid(fine[1], fine[0]))[0] <= width / 2
    cover = near.reshape(shape[0], SUBSAMPLES, shape[1], SUBSAMPLES).mean(axis=(1, 3))
    return cover, distance(segment, *np.meshgrid(np.arange(shape[1]) + 0.5, np.arange(shape[0]) + 0.5))[1]


def distance(segment: Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Distance of points to a segment, and where along it (0..1) the nearest point is."""
    (x0, y0), (dx, dy) = segment[0], segment[1] - segment[0]
    along = np.clip(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
    return np.hypot(x - x0 - along * dx, y - y0 - along * dy), along


def ones(points: Floats) -> Floats:
    return np.ones(points.shape[:2])


@pytest.mark.parametrize(("width", "worst"), [(0.5, 0.2), (1.0, 0.2), (2.0, 0.12), (2.5, 0.08), (6.0, 0.06)])
def test_ink_is_the_covered_share_times_alpha(width: float, worst: float) -> None:
    rng = np.random.default_rng(1)
    for _ in range(25):
        points, alpha = rng.uniform(-6, 28, (1, 2, 2)), rng.uniform(0.2, 1.0, (1, 2))
        cover, along = covered(points[0], width)
        expected = cover * (alpha[0, 0] + along * (alpha[0, 1] - alpha[0, 0]))
        difference = np.abs(draw_segments(points, alpha, width, SHAPE) - expected)
        inner = np.abs(along - 0.5) < 0.5 - 1.0 / np.linalg.norm(points[0, 1] - points[0, 0])
        assert difference.max() <= worst  # at the caps; along the sides it is the oracle's sampling:
        assert difference[inner].max(initial=0) <= 0.035


@pytest.mark.parametrize("angle", np.radians([0, 17, 45, 90, 133]))
def test_sides_are_exact(angle: float) -> None:
    direction = np.array([np.cos(angle), np.sin(angle)])
    points = np.array([[[12.0, 10.3] - 40 * direction, [12.0, 10.3] + 40 * direction]])
    # Any unit of length across the line holds `width` of ink: the sum over the image is the band's area in it.
    cover, _ = covered(points[0], 3.0)
    assert draw_segments(points, ones(points), 3.0, SHAPE).sum() == pytest.approx(cover.sum(), rel=2e-3)


def test_lines_are_composited_by_maximum_in_any_order() -> None:
    rng = np.random.default_rng(2)
    points, alpha = rng.uniform(0, 24, (30, 2, 2)), rng.uniform(0, 1, (30, 2))
    together = draw_segments(points, alpha, 2.5, SHAPE)
    singly = np.max([draw_segments(p[None], a[None], 2.5, SHAPE) for p, a in zip(points, alpha, strict=True)], axis=0)
    np.testing.assert_array_equal(together, singly)
    np.testing.assert_array_equal(together, draw_segments(points[::-1], alpha[::-1], 2.5, SHAPE))
    np.testing.assert_allclose(together, draw_segments(points[:, ::-1], alpha[:, ::-1], 2.5, SHAPE), atol=1e-6)


def test_drawing_onto_an_image_keeps_what_is_there() -> None:
    points = np.array([[[2.0, 2.0], [20.0, 15.0]]])
    paper: Image = np.full(SHAPE, 0.25, dtype=np.float32)
    drawn = draw_segments(points, ones(points), 2.0, SHAPE, onto=paper)
    assert (paper == 0.25).all()
    np.testing.assert_array_equal(drawn, np.maximum(draw_segments(points, ones(points), 2.0, SHAPE), 0.25))


@pytest.mark.parametrize(
    "segment",
    [
        [[5, 5], [5, 5]],
        [[np.nan, 5], [9, 9]],
        [[5, 5], [np.inf, 9]],
        [[1e300, 5], [-1e300, 9]],
        [[-50, -50], [-40, 90]],
        [[3, 1e9], [4, 2e9]],
    ],
)
def test_nothing_to_draw(segment: list[list[float]]) -> None:
    points = np.array([segment], dtype=np.float64)
    assert not draw_segments(points, ones(points), 2.5, SHAPE).any()
    assert not draw_segments(points, np.zeros((1, 2)), 2.5, SHAPE).any()


def test_far_ends_are_clipped_without_moving_the_line() -> None:
    near = np.array([[[-30.0, 4.0], [60.0, 16.0]]])
    middle, way = near.mean(axis=1), near[0, 1] - near[0, 0]
    far = np.array([[middle[0] - 1e5 * way, middle[0] + 1e5 * way]])
    np.testing.assert_allclose(
        draw_segments(far, ones(far), 2.5, SHAPE), draw_segments(near, ones(near), 2.5, SHAPE), atol=1e-4
    )


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1)])
def test_smallest_images(shape: tuple[int, int]) -> None:
    points = np.array([[[-5.0, 0.5], [15.0, 0.5]]])
    image = draw_segments(points, ones(points), 3.0, shape)
    assert image.shape == shape
    assert image[0, 0] == 1.0


def test_no_segments() -> None:
    assert not draw_segments(np.zeros((0, 2, 2)), np.zeros((0, 2)), 2.5, SHAPE).any()


def test_strongest_line_carries_its_feature() -> None:
    across = np.array([[[0.0, 5.5], [24.0, 5.5]], [[12.5, 0.0], [12.5, 20.0]]])
    alpha, feature = np.array([[1.0, 1.0], [0.5, 0.5]]), np.array([[2.0, 4.0], [7.0, 7.0]])
    ink, carried = draw_features(across, alpha, feature, 2.0, SHAPE)
    np.testing.assert_array_equal(ink, draw_segments(across, alpha, 2.0, SHAPE))
    assert carried[5, 3] == pytest.approx(2.0 + 2.0 * 3.5 / 24.0)
    assert carried[5, 12] == pytest.approx(2.0 + 2.0 * 12.5 / 24.0)
    assert carried[15, 12] == 7.0
    assert (carried[ink == 0] == 0).all()


def test_among_equal_lines_the_largest_feature_wins() -> None:
    points = np.tile([[[0.0, 5.5], [24.0, 5.5]]], (3, 1, 1))
    for feature in ([1.0, 3.0, 2.0], [3.0, 1.0, 2.0], [-3.0, -1.0, -2.0]):
        pairs = np.repeat(np.array(feature)[:, None], 2, axis=1)
        _, carried = draw_features(points, ones(points), pairs, 2.0, SHAPE)
        assert carried[5, 7] == max(feature)
