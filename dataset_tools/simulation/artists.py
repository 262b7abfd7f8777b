"""The latent artists of simulated participants, and their drawings of a data folder's views."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Literal

import numpy as np

from dataset_tools.artists import frugal, sketchers
from dataset_tools.artists.frugal import FrugalArtist
from dataset_tools.artists.motif import Motif
from dataset_tools.artists.sketchers import Sketcher
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.images import from_ink, read_grey, write_png
from ncmodel.types import Image

Artist = FrugalArtist | Sketcher
Kind = Literal["sketching", "frugal"]
"""Of artists: those who draw as people do, or those of the first releases, for comparison."""

_CROWDS: dict[Kind, Callable[[int, int], Sequence[Artist]]] = {
    "sketching": sketchers.sketchers,
    "frugal": frugal.frugal_artists,
}


def crowd_artists(count: int = 5, seed: int = 0, kind: Kind = "sketching") -> list[Artist]:
    """The artists of a crowd.

    Args:
        count: How many.
        seed: Of their tastes.
        kind: What artists.
    """
    return list(_CROWDS[kind](count, seed))


class ArtistDrawings:
    """The artists' drawings of a data folder's views, drawn when first asked for and kept there.

    They lie in `simulated/artists-ID/SHAPE_VIEW/NUMBER.png`, where ID stands for the artists' tastes and the rules by
    which they draw.

    Args:
        data: The data folder.
        artists: The crowd's artists, of one kind.
    """

    def __init__(self, data: DataFolder, artists: Sequence[Artist]) -> None:
        self.data, self.artists = data, artists
        taste = json.dumps([asdict(artist) for artist in artists])
        identity = blake2b(taste.encode() + _rules(), digest_size=4)
        self.folder = data.root / "simulated" / f"artists-{identity.hexdigest()}"

    def paths(self, item: Item) -> list[Path]:
        """The picture files of an item's drawings, one an artist.

        Raises:
            InputError: The view's mesh or camera can't be read.
        """
        paths = [self.folder / item.name / f"{artist.number}.png" for artist in self.artists]
        missing = [(artist, path) for artist, path in zip(self.artists, paths, strict=True) if not path.is_file()]
        if missing:
            motif = Motif(self.data.open_view(item))
            paths[0].parent.mkdir(parents=True, exist_ok=True)
            for artist, path in missing:
                own = int.from_bytes(blake2b(item.name.encode(), digest_size=4).digest(), "big")
                rng = np.random.default_rng([artist.seed, own])
                write_png(path, from_ink(artist.draw(motif, rng)))
        return paths

    def inks(self, item: Item) -> list[Image]:
        """The drawings of an item as (H, W) ink, one an artist."""
        return [1.0 - read_grey(path) for path in self.paths(item)]


@cache
def _rules() -> bytes:
    """What tells two states of the artists' code apart: drawings by other rules are other drawings."""
    sources = sorted(Path(frugal.__file__).parent.glob("*.py"))
    return blake2b(b"".join(path.read_bytes() for path in sources), digest_size=8).digest()
