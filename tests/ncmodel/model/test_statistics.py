"""Numbers of drawings: what a count of pixels, drawing by drawing, gives too."""

import numpy as np
import pytest

from ncmodel.drawing.settings import Levels
from ncmodel.model.statistics import FAINT, statistics
from ncmodel.nets.presets import StatisticsDims
from tests.helpers.counted import SIDE, counted, made_ink

MEMBERS = Levels().members


@pytest.mark.parametrize("seed", range(4))
def test_drawings_numbers_are_those_of_a_count_pixel_by_pixel(seed: int) -> None:
    masks, depth, shaded = made_ink(np.random.default_rng(seed))
    found = statistics(masks, MEMBERS, depth, shaded)
    outline = (masks[0] | masks[2]).sum()
    inner = masks & ~masks[0]
    for row in range(0, 256, 17):
        chosen = [layer for layer in range(1, 12) if MEMBERS[row, layer]]
        drawn = inner[chosen].any(axis=0) if chosen else np.zeros_like(masks[0])
        doubled = sum(int(inner[layer].sum()) for layer in chosen) - drawn.sum()
        shares = [(drawn & inner[layer]).sum() / inner[layer].sum() for layer in range(1, 12)]
        amount = drawn.sum() / outline
        np.testing.assert_allclose(
            found.drawings[row], [amount, np.log(amount + FAINT), doubled / outline, *shares], atol=1e-12
        )
    area = int((depth < 1).sum())
    own = inner[1:].sum(axis=(1, 2)) / outline
    np.testing.assert_allclose(found.view[:11], np.log(own + FAINT))
    np.testing.assert_allclose(found.view[35:37], [np.log(outline / np.sqrt(area)), area / SIDE**2])


def test_reach_and_crumbs_are_means_over_the_ink() -> None:
    masks = np.zeros((12, 100, 100), dtype=np.bool_)
    masks[0, 10, 10:70] = True  # 60 pixels over 60 columns and a row
    masks[0, 50, 50:52] = True  # 2 pixels: a crumb
    empty = np.zeros((6, 100, 100), np.float32)
    found = statistics(masks, MEMBERS, np.full((100, 100), 0.5, np.float32), empty)
    reach, crumbs = found.view[11], found.view[23]
    assert reach == pytest.approx((60 * np.hypot(60, 1) + 2 * np.hypot(2, 1)) / 62 / 100)
    assert crumbs == pytest.approx(2 / 62)


def test_there_are_as_many_numbers_as_the_ranker_reads() -> None:
    numbers = counted(np.random.default_rng(0)).numbers()
    dims = StatisticsDims()
    assert numbers.shape == (dims.settings, dims.numbers)
    assert numbers.dtype == np.float32


def test_numbers_of_some_drawings_are_rows_of_all() -> None:
    found = counted(np.random.default_rng(1))
    rows = np.array([7, 255, 7])
    assert np.array_equal(found.numbers(rows), found.numbers()[rows])


@pytest.mark.parametrize("depth", [1.0, 0.5])
def test_without_any_ink_numbers_are_finite(depth: float) -> None:
    masks = np.zeros((12, SIDE, SIDE), dtype=np.bool_)
    found = statistics(masks, MEMBERS, np.full((SIDE, SIDE), depth, np.float32), np.ones((6, SIDE, SIDE), np.float32))
    assert np.isfinite(found.numbers()).all()
    assert not found.drawings[:, 0].any()
