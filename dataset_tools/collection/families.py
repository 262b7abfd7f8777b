"""The families of made shapes, the shape that a name means, and which names are for testing only."""

import hashlib
import zlib
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from dataset_tools.generators import (
    animals,
    birds_and_fish,
    buildings,
    cabinets,
    cars,
    drapery,
    figures,
    heads,
    machines,
    plants,
    seats,
    ships_and_aircraft,
    vessels,
)
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
            cars.car,
            heads.head,
            seats.chair,
            vessels.vase,
            plants.plant,
            figures.character,
            machines.gearwheel,
            birds_and_fish.bird,
            ships_and_aircraft.aircraft,
            cabinets.cabinet,
            figures.hand,
            machines.fitting,
            plants.tree,
            vessels.lamp,
            birds_and_fish.fish,
            seats.sofa,
            ships_and_aircraft.boat,
            plants.flower,
            machines.tool,
            animals.insect,
            vessels.bottle,
            buildings.building,
            drapery.drapery,
        )
    }
)
"""Name -> maker. Shapes go round them in this order, so that a few have something of all."""

TEST_SHARE_MADE, TEST_SHARE_REAL = 0.18, 0.4
"""Families and real meshes whose names' hashes lie below are never trained on."""


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
