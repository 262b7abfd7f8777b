"""The simulated crowd at work: its artists draw for sentinels, its participants answer a batch."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from dataset_tools.questionnaires.counterbalancing import alternate_shapes
from dataset_tools.questionnaires.identical_drawings import distinct_pictures
from dataset_tools.questionnaires.questionnaire import Key, Scheme
from dataset_tools.questionnaires.sentinels import Drawing
from dataset_tools.simulation.artists import ArtistDrawings, Kind, crowd_artists
from dataset_tools.simulation.participants import Crowd, Distances, answer_all, answer_until_reliable, make_crowd
from dataset_tools.simulation.simulated_results import crowd_name, write_results
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import ArgumentError
from ncmodel.types import Floats

SENTINEL_ARTISTS = 3
"""Artists whose drawings sentinels are made from in simulation."""


class SimulatedArtists:
    """Simulated artists' drawings for sentinels: of enough views for the pool, of as many shapes as possible.

    Args:
        data_dir: The data folder; drawings are made when they are asked for, and kept there.
    """

    name = "simulated artists"
    note = "sentinels show simulated artists' drawings; for a study with people give artists' own"

    def __init__(self, data_dir: Path) -> None:
        self._drawings = ArtistDrawings(DataFolder(data_dir), crowd_artists())

    def drawings(self, items: Sequence[Item], scheme: Scheme) -> list[Drawing]:
        """See `SentinelDrawings.drawings`."""
        chosen = alternate_shapes(items, np.random.default_rng([scheme.seed, 3]))[: scheme.pool]
        by_item = {item: distinct_pictures(self._drawings.paths(item)[:SENTINEL_ARTISTS]) for item in chosen}
        return [Drawing(item, path) for item, paths in by_item.items() for path in paths]


def simulate_batch(
    batch_dir: Path,
    out: Path,
    crowd: Crowd,
    data_dir: Path | None = None,
    participants: int | None = None,
    seed: int = 0,
    advance: Callable[[], None] = lambda: None,
    followed: Kind = "sketching",
) -> dict[str, object]:
    """Let simulated participants answer a batch, and write their results in Mechanical Turk's format.

    Args:
        batch_dir: The batch.
        out: Results file to write.
        crowd: What the participants are like.
        data_dir: The data folder; by default the one that the batch was made from.
        participants: How many, each questionnaire answered in turn; by default as many as it takes for each to be
            answered by somebody who passes the sentinels, as a requester posts rejected questionnaires again.
        seed: Of everything random.
        advance: Called after each item whose drawings were compared.
        followed: The artists whom participants follow.

    Raises:
        UsageError: There are no participants.
        InputError: A file of the batch or the data folder can't be read.
    """
    key = Key.load(batch_dir)
    if participants is not None and participants < 1:
        raise ArgumentError("participants", str(participants), "1 or more")
    data = DataFolder(data_dir or batch_dir / str(key.settings.get("data", "")))
    artists = crowd_artists(kind=followed)
    distances = Distances(data, ArtistDrawings(data, artists))
    for item in key.items:
        distances(item)
        advance()
    # Enough for all to be answered reliably, however many clickers there are.
    count = participants or 10 + 20 * len(key.questionnaires)
    name, rng = crowd_name(seed, key.questionnaires), np.random.default_rng([seed, 1])
    people = make_crowd(count, crowd, distances, len(artists), rng, name)
    answered = answer_all(key, people, seed) if participants else answer_until_reliable(key, people, seed)
    fields = sorted({q.field for questionnaire in key.questionnaires.values() for q in questionnaire.questions})
    kinds = write_results(out, (one.submission for one in answered), fields)
    return {"simulated_participants": kinds.total(), **kinds, "questionnaires": len(key.questionnaires)}


def sample_distances(
    data_dir: Path,
    count: int,
    seed: int,
    advance: Callable[[], None] = lambda: None,
    followed: Kind = "sketching",
) -> Floats:
    """(items, artists, 8) distances of an item's drawings from simulated artists' drawings, for up to `count` items.

    Raises:
        InputError: A file of the data folder can't be read.
    """
    data = DataFolder(data_dir)
    chosen = alternate_shapes(data.items(), np.random.default_rng([seed, 2]))[:count]
    distances = Distances(data, ArtistDrawings(data, crowd_artists(kind=followed)))
    found = []
    for item in chosen:
        found.append(distances(item))
        advance()
    return np.stack(found)
