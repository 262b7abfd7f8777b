"""Shapes made in code are closed, outward-facing, fine enough, varied and reproducible."""

import numpy as np
import pytest

from dataset_tools.simulation.shapes import KINDS, make_shape, make_shapes
from ncmodel.types import Ints
from tests.helpers.dirty import signed_volume


def edge_counts(faces: Ints) -> Ints:
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1]


@pytest.mark.parametrize("kind", sorted(KINDS))
@pytest.mark.parametrize("number", [0, 5])
def test_every_shape_is_a_closed_solid(kind: str, number: int) -> None:
    mesh = make_shape(kind, number)
    assert len(mesh.faces) >= 2000
    assert np.isfinite(mesh.vertices).all()
    assert (edge_counts(mesh.faces) == 2).all()
    assert signed_volume(mesh.vertices, mesh.faces) > 0.01


def test_the_same_seed_gives_the_same_bytes_and_another_number_another_shape() -> None:
    first, again, other = make_shape("figure", 1), make_shape("figure", 1), make_shape("figure", 2)
    assert first.vertices.tobytes() == again.vertices.tobytes()
    assert first.vertices.shape != other.vertices.shape or not np.allclose(first.vertices, other.vertices)


def test_the_kinds_take_turns() -> None:
    names = [mesh.name for mesh in make_shapes(len(KINDS) + 1)]
    assert names == [*(f"{kind}_0" for kind in KINDS), f"{next(iter(KINDS))}_1"]
