"""The crowd's stages that look at drawings: make a batch, let simulated participants answer it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from dataset_tools.questionnaires.batch import Built, Planner, build_batch
from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.counterbalancing import varied
from dataset_tools.questionnaires.identical_drawings import different_pictures
from dataset_tools.questionnaires.questionnaire import Key, Scheme
from dataset_tools.questionnaires.sentinels import Drawing, artists_drawings
from dataset_tools.simulation.artists import ArtistDrawings, crowd_artists
from dataset_tools.simulation.participants import Crowd, Distances, answer_all, answer_until_reliable, make_crowd
from dataset_tools.simulation.simulated_results import crowd_name, write_results
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import UsageError
from ncmodel.types import Floats

SENTINEL_ARTISTS = 3
"""Artists whose drawings sentinels are made from in simulation."""


def make_batch(
    data_dir: Path,
    batch_dir: Path,
    needs: Mapping[Item, int],
    scheme: Scheme,
    look: Look,
    artists: Path | None = None,
    fill: bool = True,
) -> Built:
    """Write a batch of questionnaires about the items of a data folder.

    Args:
        data_dir: The data folder.
        batch_dir: Where to write; doesn't exist yet or is empty.
        needs: Item -> votes wanted.
        scheme: Numbers of questions.
        look: How pictures are delivered.
        artists: Folder of artists' drawings for sentinels; without it they are the simulated artists'.
        fill: Whether every questionnaire has exactly `scheme.real` items.

    Raises:
        UsageError: The batch folder holds something already, or no item needs votes.
        InputError: A file of the data folder or an artists' drawing can't be read.
    """
    drawings: Sequence[Drawing] = ()
    data = DataFolder(data_dir)
    items, notes, settings = data.items(), [], {}
    if scheme.sentinels and len({item.shape for item in items}) == 1:
        scheme = replace(scheme, sentinels=0)
        notes.append("no sentinels: they show drawings of other shapes, and there is one shape; nobody is unreliable")
    if scheme.sentinels:
        drawings = artists_drawings(artists, items) if artists else _simulated(data, items, scheme)
        settings = {"sentinels_from": "artists" if artists else "simulated artists"}
        if artists is None:
            notes.append("sentinels show simulated artists' drawings; for a study with people give --artists")
    built = build_batch(Planner(data, scheme, drawings, needs, fill), batch_dir, look, settings)
    return replace(built, notes=(*built.notes, *notes))


def _simulated(data: DataFolder, items: Sequence[Item], scheme: Scheme) -> list[Drawing]:
    """Simulated artists' drawings of enough views for the pool, of as many shapes as possible."""
    chosen = varied(items, np.random.default_rng([scheme.seed, 3]))[: scheme.pool]
    drawings = ArtistDrawings(data, crowd_artists())
    by_item = {item: different_pictures(drawings.paths(item)[:SENTINEL_ARTISTS]) for item in chosen}
    return [Drawing(item, path) for item, paths in by_item.items() for path in paths]


def simulate_batch(
    batch_dir: Path,
    out: Path,
    crowd: Crowd,
    data_dir: Path | None = None,
    participants: int | None = None,
    seed: int = 0,
    advance: Callable[[], None] = lambda: None,
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

    Raises:
        UsageError: There are no participants.
        InputError: A file of the batch or the data folder can't be read.
    """
    key = Key.load(batch_dir)
    if participants is not None and participants < 1:
        raise UsageError(f"--participants is {participants}, expected 1 or more")
    data = DataFolder(data_dir or batch_dir / str(key.settings.get("data", "")))
    artists = crowd_artists()
    distances = Distances(data, ArtistDrawings(data, artists))
    for item in key.items:
        distances(item)
        advance()
    # Enough for all to be answered reliably, however many clickers there are.
    count = participants or 10 + 20 * len(key.questionnaires)
    name, rng = crowd_name(seed, key.questionnaires), np.random.default_rng([seed, 1])
    people = make_crowd(count, crowd, distances, len(artists), rng, name)
    sittings = answer_all(key, people, seed) if participants else answer_until_reliable(key, people, seed)
    fields = sorted({q.field for questionnaire in key.questionnaires.values() for q in questionnaire.questions})
    kinds = write_results(out, (sitting.sent for sitting in sittings), fields)
    return {"simulated_participants": kinds.total(), **kinds, "questionnaires": len(key.questionnaires)}


def sample_distances(data_dir: Path, count: int, seed: int, advance: Callable[[], None] = lambda: None) -> Floats:
    """(items, artists, 8) distances of candidates from simulated artists' drawings, for up to `count` items.

    Raises:
        InputError: A file of the data folder can't be read.
    """
    data = DataFolder(data_dir)
    chosen = varied(data.items(), np.random.default_rng([seed, 2]))[:count]
    distances = Distances(data, ArtistDrawings(data, crowd_artists()))
    found = []
    for item in chosen:
        found.append(distances(item))
        advance()
    return np.stack(found)
