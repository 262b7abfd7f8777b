"""Short strokes: what carries nothing is left out, what a person would draw stays at any size."""

import numpy as np
import pytest

from ncmodel.drawing.crumbs import without_crumbs
from ncmodel.types import Stroke
from tests.helpers.strokes import inside

ALL_LINES = ["contours", "boundaries", "creases", "intersections", "suggestive", "ridges", "valleys", "apparent"]
CURVATURE = ["suggestive", "ridges", "valleys", "apparent"]


def stroke(family: str, *points: tuple[float, float], alpha: float = 1.0) -> Stroke:
    return Stroke(family, np.array(points, dtype=np.float64), np.full(len(points), alpha))


def ring(family: str, radius: float) -> Stroke:
    angle = np.linspace(0.0, 2 * np.pi, 13)
    return Stroke(family, 300.0 + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1), np.ones(13))


@pytest.mark.parametrize("family", ALL_LINES)
def test_an_eye_stays_and_a_crumb_goes(family: str) -> None:
    eye, crumb, line = ring(family, 2.0), stroke(family, (10, 10), (20, 12)), stroke(family, (50, 50), (90, 50))
    assert without_crumbs([eye, crumb, line], 15.0, 3.0, inside) == (eye, line)


@pytest.mark.parametrize("family", ALL_LINES)
def test_what_touches_a_longer_line_stays_if_it_is_no_line_of_curvature(family: str) -> None:
    line, tooth = stroke("contours", (0, 0), (100, 0)), stroke(family, (50, 2), (53, 10))
    assert without_crumbs([line, tooth], 15.0, 3.0, inside) == ((line,) if family in CURVATURE else (line, tooth))
    apart = stroke(family, (50, 4), (53, 12))
    assert without_crumbs([line, apart], 15.0, 3.0, inside) == (line,)


def test_the_outline_is_no_crumb() -> None:
    line, crumb, edge = (
        stroke("contours", (50, 50), (90, 50)),
        stroke("creases", (10, 10), (20, 12)),
        stroke("creases", (10, 20), (20, 22)),
    )
    kept = without_crumbs([line, crumb, edge], 15.0, 3.0, lambda some: np.array([each is edge for each in some]))
    assert kept == (line, edge)


def test_strokes_that_share_an_end_count_together() -> None:
    first, second = stroke("suggestive", (0, 0), (10, 0)), stroke("apparent", (10, 0), (18, 3))
    assert without_crumbs([first, second], 15.0, 3.0, inside) == (first, second)
    assert without_crumbs([first], 15.0, 3.0, inside) == ()


def test_faint_strokes_have_less_ink() -> None:
    strong, faint = stroke("suggestive", (0, 0), (20, 0)), stroke("suggestive", (0, 50), (20, 50), alpha=0.5)
    assert without_crumbs([strong, faint], 15.0, 3.0, inside) == (strong,)


def test_nothing_is_no_trouble() -> None:
    assert without_crumbs([], 15.0, 3.0, inside) == ()
