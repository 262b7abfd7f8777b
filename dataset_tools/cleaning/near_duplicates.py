"""Duplicate shapes of a collection: rotated about the vertical axis, scaled, re-ordered, exported or meshed again."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from dataset_tools.cleaning.shape_distance import surface_distance
from ncmodel.errors import InputError
from ncmodel.mesh.load import load_mesh
from ncmodel.parsing import parse_json
from ncmodel.types import Floats

NEAR = 0.01
"""Shapes whose invariants all differ by less are compared. Measured: a mesh exported again differs by 1e-5, one with
half the faces by 0.002, distinct shapes by 0.14 and more."""


@dataclass(frozen=True)
class Comparison:
    """Two shapes to compare.

    Attributes:
        first: The name that comes first.
        second: The other one.
        meshes: Their mesh files.
    """

    first: str
    second: str
    meshes: tuple[str, str]


@dataclass(frozen=True)
class Duplicate:
    """A shape that is another one again.

    Attributes:
        shape: Its name.
        of: The shape that is kept; its name comes first.
        distance: Between their surfaces, as `surface_distance` says.
    """

    shape: str
    of: str
    distance: float


def candidate_pairs(invariants: Mapping[str, Floats]) -> list[tuple[str, str]]:
    """Pairs of shapes alike enough to be compared, each in the order of names."""
    names = sorted(invariants)
    if len(names) < 2:
        return []
    tree = cKDTree(np.stack([invariants[name] for name in names]))
    pairs = tree.query_pairs(NEAR, p=np.inf)
    return sorted((names[min(pair)], names[max(pair)]) for pair in pairs)


def compare(comparison: Comparison) -> float | None:
    """Distance between two shapes' surfaces; None where one of them can't be read."""
    try:
        one, other = (load_mesh(path) for path in comparison.meshes)
    except InputError:
        return None
    return round(surface_distance(one, other), 6)


def decide(distances: Mapping[tuple[str, str], float], tolerance: float) -> list[Duplicate]:
    """Which shapes to leave out.

    Of shapes that are alike, the one whose name comes first is kept. A shape is only ever left out for one that is
    kept, so that a chain of small differences doesn't swallow what differs much.

    Args:
        distances: (first, second) -> distance, names in order.
        tolerance: Largest distance between duplicates.
    """
    found: dict[str, Duplicate] = {}
    for (first, second), distance in sorted(distances.items(), key=lambda entry: (entry[0][1], entry[0][0])):
        if distance <= tolerance and first not in found and second not in found:
            found[second] = Duplicate(second, first, distance)
    return list(found.values())


def to_json(
    distances: Mapping[tuple[str, str], float], found: Sequence[Duplicate], checksums: Mapping[str, str]
) -> str:
    """What `duplicates.json` holds: the decisions, all that was compared, and the checksums of the meshes compared."""
    record = {
        "duplicates": {one.shape: {"of": one.of, "distance": one.distance} for one in found},
        "compared": [[*pair, distance] for pair, distance in sorted(distances.items())],
        "meshes": dict(sorted(checksums.items())),
    }
    return json.dumps(record, indent=1) + "\n"


def compared_before(path: Path, checksums: Mapping[str, str]) -> dict[tuple[str, str], float]:
    """The comparisons that `duplicates.json` holds, of meshes that are still the same; none without such a file.

    Args:
        path: The file.
        checksums: Shape -> checksum of its mesh now.
    """
    try:
        record = parse_json(path.read_text(encoding="utf-8"))
        same = {shape for shape, checksum in record["meshes"].items() if checksums.get(shape) == checksum}
        known = {(first, second): float(distance) for first, second, distance in record["compared"]}
        return {pair: distance for pair, distance in known.items() if same.issuperset(pair)}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}  # compared again
