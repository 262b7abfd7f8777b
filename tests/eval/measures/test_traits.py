"""What a drawing is like, on drawings made of rulers."""

import numpy as np
import pytest

from eval.measures.traits import PAGE_MM, Measured, stroke_lengths
from ncmodel.types import Mask

SIDE = 480
"""Pixels of a square shape: 4 to a millimetre."""


def canvas() -> Mask:
    return np.zeros((600, 600), dtype=np.bool_)


def square() -> Mask:
    shape = canvas()
    shape[60 : 60 + SIDE, 60 : 60 + SIDE] = True
    return shape


def test_strokes_run_on_through_a_crossing() -> None:
    cross = canvas()
    cross[100, 50:251] = True
    cross[50:201, 150] = True
    assert sorted(stroke_lengths(cross)) == pytest.approx([150.0, 200.0])


def test_a_diagonal_is_as_long_as_it_looks_and_a_dot_has_no_length() -> None:
    line = canvas()
    line[range(100, 201), range(100, 201)] = True
    line[400, 400] = True
    assert stroke_lengths(line) == pytest.approx([100 * np.sqrt(2)])
    assert stroke_lengths(canvas()).size == 0


def test_ink_is_measured_against_the_silhouette_and_the_lines() -> None:
    """Two inner strokes, of 50 mm along a ridge and of 4 mm along nothing, and the square's own edge."""
    ridges, ink = canvas(), square().astype(np.float32)
    ink[62 : 58 + SIDE, 62 : 58 + SIDE] = 0.0
    ridges[202, 100:500] = True
    ink[200, 100:301] = ink[400, 100:117] = 1.0
    by = Measured.of(square(), {"ridges": ridges, "valleys": canvas()})
    assert by.pixels_per_mm == SIDE / PAGE_MM
    found = by.traits(by.inner(ink))
    assert found.inner == pytest.approx(218 / (4 * SIDE), rel=0.01)
    assert found.stroke == pytest.approx((50**2 + 4**2) / 54, rel=0.01)
    assert found.crumbs == pytest.approx(4 / 54, rel=0.01)
    assert found.along == pytest.approx({"ridges": 201 / 218, "valleys": 0.0})
    assert found.apart == pytest.approx(17 / 218)


def test_a_drawing_without_inner_lines_has_no_shares() -> None:
    by = Measured.of(square(), {"ridges": canvas()})
    found = by.traits(canvas())
    assert found.inner == 0.0
    assert np.isnan([found.stroke, found.crumbs, found.apart, found.along["ridges"]]).all()
    with pytest.raises(ValueError, match="no pixel shows the shape"):
        Measured.of(canvas(), {})
