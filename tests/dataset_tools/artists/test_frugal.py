"""Frugal artists: contours, edges of machine parts, and inner lines up to a length."""

import numpy as np
import pytest

from dataset_tools.artists.frugal import FrugalArtist, frugal_artists
from dataset_tools.artists.motif import Motif
from ncmodel.types import LineFamily
from tests.helpers.artists import box_view, bumpy_view


def test_artists_are_alike_but_not_the_same() -> None:
    artists = frugal_artists(5)
    assert artists == frugal_artists(5)
    assert len({artist.inner for artist in artists}) == 5
    assert all(0.3 < artist.inner < 1.2 for artist in artists)
    assert all(sum(artist.shares.values()) == pytest.approx(1.0) for artist in artists)
    assert all(max(artist.shares, key=lambda f: artist.shares[f]) is LineFamily.APPARENT for artist in artists)


def test_an_artist_who_wants_more_draws_more() -> None:
    motif, typical = Motif(bumpy_view()), frugal_artists(1)[0]
    inks = []
    for inner in (0.0, 0.5, 2.0):
        artist = FrugalArtist(0, inner, typical.shares, 0.0, 0)
        inks.append(artist.draw(motif, np.random.default_rng(0)))
    assert 0 < inks[0].sum() <= inks[1].sum() <= inks[2].sum()
    assert inks[2].sum() > inks[0].sum()
    assert all((ink >= inks[0]).all() for ink in inks), "contours are never left out"
    assert inks[0].max() <= 1.0


def test_forgetful_artists_forget_some_strokes_and_the_seed_says_which() -> None:
    motif, typical = Motif(bumpy_view()), frugal_artists(1)[0]
    sure = FrugalArtist(0, 2.0, typical.shares, 0.0, 0).draw(motif, np.random.default_rng(0))
    forgetful = FrugalArtist(0, 2.0, typical.shares, 1.0, 0)
    drawn = [forgetful.draw(motif, np.random.default_rng(seed)) for seed in (1, 1, 2, 3)]
    assert (drawn[0] == drawn[1]).all()
    assert any(one.sum() < sure.sum() for one in drawn)


def test_mechanical_shapes_get_their_creases() -> None:
    """A box seen from a corner shows its nine visible edges."""
    view = box_view()
    box = frugal_artists(1)[0].draw(Motif(view), np.random.default_rng(0))
    edges = view.camera.project(view.visible(LineFamily.CREASES).points)[..., :2]
    middle = edges.mean(axis=1).astype(int)
    assert len(edges) >= 7
    assert np.mean([box[v - 1 : v + 2, u - 1 : u + 2].max() > 0.5 for u, v in middle]) > 0.9
