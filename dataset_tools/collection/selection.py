"""Choosing shapes by name: the first of a collection, and those of a folder that are for training or testing."""

from collections.abc import Sequence

from dataset_tools.build.mesh_files import Source
from dataset_tools.collection.families import FAMILIES, split_of
from ncmodel.errors import ArgumentError

SPLITS = ("training", "test", "all")

SEEDS_APART = 100_000
"""Numbers between the first shapes of two seeds."""


def shape_names(count: int, seed: int = 0, families: tuple[str, ...] | None = None, split: str = "all") -> list[str]:
    """The names of a collection's first shapes, going round the families.

    Args:
        count: How many.
        seed: Another seed, other shapes.
        families: Only these, in the order of `FAMILIES`.
        split: "training" leaves the test families out, "test" the others, "all" none.

    Raises:
        ArgumentError: An unknown family or split, or none is left.
    """
    unknown = sorted(set(families or ()) - set(FAMILIES))
    if unknown:
        raise ArgumentError("families", ", ".join(unknown), f"some of {', '.join(sorted(FAMILIES))}")
    _check(split)
    chosen = [
        family
        for family in FAMILIES
        if (families is None or family in families) and split in ("all", split_of(f"{family}_0"))
    ]
    if not chosen:
        raise ArgumentError("families", ", ".join(families or ()), f"some that are for {split}")
    return [f"{chosen[k % len(chosen)]}_{seed * SEEDS_APART + k // len(chosen)}" for k in range(count)]


def sources_of(sources: Sequence[Source], split: str) -> list[Source]:
    """The mesh files, made or real, that are for training or for testing, as their names say.

    Raises:
        ArgumentError: An unknown split, or none is left.
    """
    _check(split)
    chosen = [source for source in sources if split in ("all", split_of(source.path.stem))]
    if not chosen:
        raise ArgumentError("split", f"{split}, and none of {len(sources)} meshes is", "one that some are for")
    return chosen


def _check(split: str) -> None:
    if split not in SPLITS:
        raise ArgumentError("split", split, "training, test or all")
