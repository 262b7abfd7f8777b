"""Sketching artists: long lines, as much ink as people use, one taste apart from the next."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from dataset_tools.artists.motif import Motif, strength_of
from dataset_tools.artists.shading_lines import KIND, shading_lines
from dataset_tools.artists.sketchers import sketchers
from ncmodel.chamfer import distance_to
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import SUGGESTIVE_FADE, Image, LineFamily, Mask, Mesh
from tests.helpers.analytic import icosphere
from tests.helpers.artists import box_view, bumpy_view
from tests.helpers.views import seen


@pytest.fixture(scope="module")
def motif() -> Motif:
    return Motif(bumpy_view(768))


@pytest.fixture(scope="module")
def drawings(motif: Motif) -> list[Image]:
    return [artist.draw(motif, np.random.default_rng(artist.seed)) for artist in sketchers(5)]


def inner(motif: Motif, ink: Image) -> Mask:
    return np.asarray((ink >= 0.5) & (motif.from_silhouette > 8.0))


def test_tastes_differ_and_the_seed_decides_them() -> None:
    artists = sketchers(5)
    assert artists == sketchers(5)
    assert artists != sketchers(5, seed=1)
    wanted = sorted(artist.inner for artist in artists)
    assert wanted[-1] > 1.5 * wanted[0]
    assert len({max(artist.liking, key=lambda kind: artist.liking[kind]) for artist in artists}) >= 3


def test_the_same_rng_gives_the_same_drawing(motif: Motif, drawings: list[Image]) -> None:
    artist = sketchers(5)[0]
    assert (artist.draw(motif, np.random.default_rng(artist.seed)) == drawings[0]).all()
    assert (artist.draw(Motif(motif.view), np.random.default_rng(1)) != drawings[0]).any()


def test_artists_differ_more_from_each_other_than_from_themselves(motif: Motif, drawings: list[Image]) -> None:
    def apart(first: Image, second: Image) -> float:
        a, b = inner(motif, first), inner(motif, second)
        return float((distance_to(a)[b] > 6.0).mean() + (distance_to(b)[a] > 6.0).mean()) / 2

    others = [apart(a, b) for a, b in itertools.combinations(drawings, 2)]
    again = [artist.draw(motif, np.random.default_rng(77)) for artist in sketchers(5)]
    selves = [apart(a, b) for a, b in zip(drawings, again, strict=True)]
    assert np.mean(selves) < 0.8 * np.mean(others)
    assert np.mean(others) > 0.2


def test_all_draw_the_outline(motif: Motif, drawings: list[Image]) -> None:
    for ink in drawings:
        assert (distance_to(ink >= 0.5)[motif.silhouette] <= 6.0).mean() > 0.97


def test_an_artist_who_wants_more_draws_more(motif: Motif) -> None:
    artist = sketchers(1)[0]
    amounts = [
        inner(motif, replace(artist, inner=wanted).draw(motif, np.random.default_rng(0))).sum()
        for wanted in (0.2, 0.8, 2.0)
    ]
    assert amounts[0] < amounts[1] < amounts[2]


def test_edges_of_a_box_are_drawn() -> None:
    view = box_view()
    edges = view.camera.project(view.visible(LineFamily.CREASES).points)[..., :2].mean(axis=1).astype(int)
    for artist in sketchers(3):
        away = distance_to(artist.draw(Motif(view), np.random.default_rng(0)) >= 0.5)
        assert np.mean([away[v, u] <= 8.0 for u, v in edges]) > 0.8


def test_a_picture_of_any_size_shows_the_same_drawing(motif: Motif, drawings: list[Image]) -> None:
    small = View(motif.view.surface, motif.view.camera.resized(384, 384))
    artist = sketchers(5)[0]
    ink = artist.draw(Motif(small), np.random.default_rng(artist.seed))
    assert ink.shape == (384, 384)
    assert 0.3 < (ink >= 0.5).sum() / ((drawings[0] >= 0.5).sum() / 4) < 3.0


def test_the_terminator_of_a_sphere_is_a_line_of_shading() -> None:
    """Half of a ball is dark where the light comes from the side: the line between is straight, through the middle."""
    view = seen(icosphere(4, 0.4))
    lines = shading_lines(Motif(view), np.array([1.0, 0.0, 0.0]), level=0.5, blur=4.0)
    longest = max(lines, key=lambda line: line.length)
    assert longest.kind == KIND
    assert np.abs(longest.points[:, 0] - 384.0).max() < 8.0


def test_a_shape_without_lines_gets_its_outline() -> None:
    view = View(Surface(Mesh(*icosphere(4, 0.4), "ball")), seen(icosphere(4, 0.4)).camera)
    ink = sketchers(1)[0].draw(Motif(view), np.random.default_rng(0))
    assert ink.max() > 0.9


@pytest.mark.parametrize("family", [LineFamily.RIDGES, LineFamily.SUGGESTIVE])
def test_strength_is_what_the_fade_was_made_from(family: LineFamily) -> None:
    strength = np.array([0.05, 0.2, 1.0])
    faintest = 0.001 if family is LineFamily.SUGGESTIVE else 0.02
    excess = strength - faintest
    alpha = excess / (excess + SUGGESTIVE_FADE) if family is LineFamily.SUGGESTIVE else 1 - faintest / strength
    assert strength_of(family, alpha) == pytest.approx(strength)
