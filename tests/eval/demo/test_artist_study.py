"""Simulated artists beside real ones, on two made shapes: the figures that say whether they draw as people do."""

import numpy as np
import pytest

from dataset_tools.artists.motif import Motif
from dataset_tools.simulation.artists import crowd_artists
from eval.demo.artist_study import REAL, Drawn, draw_view, figures, measured
from tests.helpers.artists import carved_view


@pytest.fixture(scope="module")
def drawn() -> dict[str, list[Drawn]]:
    """Two carved balls, drawn by both crowds."""
    views = [carved_view((7.0, 6.0, 5.0)), carved_view((11.0, 4.0, 9.0))]
    found: dict[str, list[Drawn]] = {"frugal": [], "sketching": []}
    for view in views:
        motif, by = Motif(view), measured(view)
        found["frugal"].append(draw_view(view, motif, crowd_artists(kind="frugal"), by))
        found["sketching"].append(draw_view(view, motif, crowd_artists(), by))
    return found


def over(drawn: list[Drawn], name: str) -> float:
    return float(np.nanmean([getattr(traits, name) for view in drawn for traits in view.traits]))


def f1(drawn: list[Drawn], name: str) -> float:
    return float(np.mean([value for view in drawn for value in getattr(view, name)]))


def test_sketching_artists_draw_as_much_as_people_and_in_long_strokes(drawn: dict[str, list[Drawn]]) -> None:
    new, frugal = drawn["sketching"], drawn["frugal"]
    assert 0.8 < over(new, "inner") < 2.0
    assert over(new, "inner") > 1.2 * over(frugal, "inner")
    assert over(new, "stroke") > 19.0
    assert over(new, "crumbs") < 0.1
    assert 0.2 < over(new, "apart") < 0.75


def test_two_sketching_artists_agree_as_little_as_people_and_each_keeps_to_a_taste(
    drawn: dict[str, list[Drawn]],
) -> None:
    new, frugal = drawn["sketching"], drawn["frugal"]
    assert 0.3 < f1(new, "others") < 0.65
    assert f1(new, "selves") > f1(new, "others") + 0.15
    assert f1(frugal, "others") > 0.85


def test_every_figure_of_real_artists_has_its_counterpart(drawn: dict[str, list[Drawn]]) -> None:
    assert set(figures(drawn["sketching"])) == set(REAL)
    assert figures(drawn["sketching"][1:])["F1, two artists, few contours"] == "nan"
