"""The families of made shapes, which of them are only ever tested on, and what a shape's name says."""

import hashlib
import zlib
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from dataset_tools.collection import animals, furniture, machines, people, plants, vehicles, vessels
from dataset_tools.modelling.finishes import finished
from dataset_tools.modelling.sculpting import Surface
from ncmodel.errors import ArgumentError
from ncmodel.types import Mesh

Maker = Callable[[np.random.Generator], Surface]

FAMILIES: Mapping[str, Maker] = MappingProxyType(
    {
        maker.__name__: maker
        for maker in (
            animals.quadruped,
            machines.housing,
            vehicles.car,
            people.head,
            furniture.chair,
            vessels.vase,
            plants.plant,
            people.character,
            machines.gearwheel,
            animals.bird,
            vehicles.aircraft,
            furniture.cabinet,
            people.hand,
            machines.fitting,
            plants.tree,
            vessels.lamp,
            animals.fish,
            furniture.sofa,
            vehicles.boat,
            plants.flower,
            machines.tool,
            animals.insect,
            vessels.bottle,
        )
    }
)
"""Name -> maker. Shapes go round them in this order, so that a few have something of all."""

TEST_SHARE_MADE, TEST_SHARE_REAL = 0.18, 0.4
"""Families and real meshes whose names' hashes lie below are never trained on."""

SEEDS_APART = 100_000
"""Numbers between the first shapes of two seeds."""


def _place(name: str) -> float:
    """Where a name falls between 0 and 1: by its hash, so that it depends on nothing else."""
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:8], "big") / 2**64


def held_out_families() -> tuple[str, ...]:
    """The families that are never trained on; one that is added later changes nothing for the others."""
    return tuple(sorted(family for family in FAMILIES if _place(family) < TEST_SHARE_MADE))


def split_of(shape: str) -> str:
    """Whether a shape is for training or for testing, by its name alone.

    Args:
        shape: A made shape's name, FAMILY_NUMBER, whose family decides; or that of a real mesh: its file's name
            without folder and suffix, whose SHA-256 decides.

    Returns:
        "training" or "test".
    """
    family, _, number = shape.rpartition("_")
    if family in FAMILIES and number.isdigit():
        return "test" if family in held_out_families() else "training"
    return "test" if _place(shape) < TEST_SHARE_REAL else "training"


def make_shape(name: str) -> Mesh:
    """The shape of a name; its number is the seed.

    Args:
        name: FAMILY_NUMBER.

    Returns:
        A mesh of 5 to 100 thousand faces, upright (+y), in the units it was modelled in.

    Raises:
        ArgumentError: There is no such family, or the number isn't one.
    """
    family, _, number = name.rpartition("_")
    if family not in FAMILIES or not number.isdigit():
        raise ArgumentError("name", repr(name), f"FAMILY_NUMBER, of the families {', '.join(sorted(FAMILIES))}")
    rng = np.random.default_rng([int(number), zlib.crc32(family.encode())])
    vertices, faces = finished(FAMILIES[family](rng), rng)
    return Mesh(np.ascontiguousarray(vertices), np.ascontiguousarray(faces, dtype=np.int64), name)


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
    if split not in ("training", "test", "all"):
        raise ArgumentError("split", split, "training, test or all")
    chosen = [
        family
        for family in FAMILIES
        if (families is None or family in families) and split in ("all", split_of(f"{family}_0"))
    ]
    if not chosen:
        raise ArgumentError("families", ", ".join(families or ()), f"some that are for {split}")
    return [f"{chosen[k % len(chosen)]}_{seed * SEEDS_APART + k // len(chosen)}" for k in range(count)]
