"""Drawings from afar."""

import numpy as np
import pytest
import torch

from ncmodel.model.filters import CELLS, FAINT, LOOKED_AT, Glance, line_drawing
from ncmodel.types import Floats, Image, Ints

SHAPE = (60, 96)


def lines(seed: int = 0, share: float = 0.1) -> tuple[Ints, Image]:
    """Flat indices of pixels that carry lines, and their ink."""
    rng = np.random.default_rng(seed)
    pixels = np.flatnonzero(rng.random(SHAPE) < share)
    return pixels, rng.random(len(pixels)).astype(np.float32)


def counted(pixels: Ints, ink: Image) -> Floats:
    """Ink in each cell that has lines, one pixel after the other."""
    cells = np.zeros((CELLS, CELLS))
    seen = np.zeros((CELLS, CELLS), dtype=np.bool_)
    for pixel, amount in zip(pixels, ink, strict=True):
        cell = (pixel // SHAPE[1] * CELLS // SHAPE[0], pixel % SHAPE[1] * CELLS // SHAPE[1])
        cells[cell] += amount
        seen[cell] = True
    return cells[seen]


def test_a_glance_is_the_root_of_the_ink_in_each_cell() -> None:
    pixels, ink = lines()
    glance = Glance(pixels, ink, SHAPE)
    some = ink * (np.arange(len(ink)) % 3 == 0)
    full, part = counted(pixels, ink), counted(pixels, some)
    faint = FAINT * full.max()
    found = glance(np.stack([ink, some])[:, glance.pixels])
    expected = np.sqrt(np.stack([full, part]) + faint) / np.sqrt((full + faint).sum())
    np.testing.assert_allclose(found, expected, rtol=1e-5)
    assert np.square(found[0]).sum() == pytest.approx(1.0)


def test_of_many_pixels_a_part_stands_for_all() -> None:
    pixels, ink = np.arange(SHAPE[0] * SHAPE[1]), np.ones(SHAPE[0] * SHAPE[1], np.float32)
    glance = Glance(pixels, ink, SHAPE)
    assert LOOKED_AT / 2 < len(glance.pixels) <= LOOKED_AT
    seen = glance(np.ones((1, len(glance.pixels)), np.float32))
    np.testing.assert_allclose(seen, 1 / CELLS, rtol=0.1)


def test_lines_that_lie_on_others_make_no_difference() -> None:
    """What thresholds alone wouldn't tell: a family that is covered by another may go."""
    pixels, ink = lines()
    glance = Glance(pixels, ink, SHAPE)
    families = torch.from_numpy(np.stack([ink, 0.9 * ink, 0 * ink, 0 * ink])[:, glance.pixels])
    t = torch.tensor([[0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.5, 1.0, 0.0, 0.0]])
    drawn = line_drawing(families, torch.ones_like(families), torch.zeros(families.shape[1]), t)
    both, one, faded = glance(drawn.numpy())
    np.testing.assert_array_equal(both, one)
    assert np.linalg.norm(both - faded) > 0.2
