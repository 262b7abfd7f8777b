"""Whether shapes to test on are in a data folder already, by the measure that finds a collection's duplicates."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from dataset_tools.build.config import BuildConfig
from dataset_tools.build.mesh_files import Source
from dataset_tools.build.store import Store
from dataset_tools.cleaning.near_duplicates import NEAR, Duplicate
from dataset_tools.cleaning.repair import clean_file
from dataset_tools.cleaning.shape_distance import invariants, surface_distance
from ncmodel.config import read_config
from ncmodel.errors import InputError


def shapes_known(sources: Sequence[Source], data_dir: str | Path, advance: Callable[[str], None]) -> list[Duplicate]:
    """The meshes that a data folder has already, rotated, scaled or meshed again as they may be.

    Args:
        sources: Mesh files; each is cleaned as the data folder's were.
        data_dir: The data folder.
        advance: Is told about every mesh.

    Raises:
        InputError: It isn't a data folder, or a mesh can't be read.
    """
    store = Store(data_dir)
    if not store.config_path.is_file():
        raise InputError(data_dir, "no config.toml in it", "a folder made by `ncontours dataset build`")
    config = read_config(BuildConfig, store.config_path)
    records = {shape: store.shape_record(shape) or {} for shape in store.shapes()}
    moments = {shape: np.array(record["invariants"]) for shape, record in records.items() if "invariants" in record}
    found = []
    for source in sources:
        mesh, _ = clean_file(str(source.path), config.upward(source.place), config.clean)
        own = invariants(mesh)
        for shape in sorted(shape for shape, theirs in moments.items() if np.abs(theirs - own).max() <= NEAR):
            distance = surface_distance(mesh, store.load_mesh(shape))
            if distance <= config.duplicate_distance:
                found.append(Duplicate(source.name, shape, round(distance, 6)))
        advance(source.name)
    return found
