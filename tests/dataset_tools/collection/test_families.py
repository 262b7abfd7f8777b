"""Made shapes are sound, of usable size, all different, the same for a name; names say who is for training."""

import numpy as np
import pytest

from dataset_tools.cleaning.near_duplicates import candidate_pairs
from dataset_tools.cleaning.shape_distance import invariants
from dataset_tools.collection.families import FAMILIES, held_out_families, make_shape, split_of
from dataset_tools.collection.selection import shape_names
from ncmodel.errors import ArgumentError
from ncmodel.types import Mesh
from tests.helpers.dirty import signed_volume

NAMES = [*(f"{family}_3" for family in FAMILIES), "bottle_4", "chair_4", "lamp_4", "plant_4", "sofa_4", "vase_4"]


@pytest.fixture(scope="module")
def shapes() -> dict[str, Mesh]:
    return {name: make_shape(name) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_shapes_are_sound_and_of_usable_size(shapes: dict[str, Mesh], name: str) -> None:
    mesh = shapes[name]
    assert 4_500 <= len(mesh.faces) <= 101_000
    assert np.isfinite(mesh.vertices).all()
    assert len(np.unique(mesh.faces)) == len(mesh.vertices)
    assert signed_volume(mesh.vertices, mesh.faces) > 0


def test_no_two_shapes_are_alike(shapes: dict[str, Mesh]) -> None:
    found = {name: invariants(mesh) for name, mesh in shapes.items()}
    assert candidate_pairs(found) == []
    assert candidate_pairs(found | {"again": found["vase_3"]}) == [("again", "vase_3")]


def test_a_name_always_means_the_same_shape(shapes: dict[str, Mesh]) -> None:
    for name in ("gearwheel_3", "drapery_3"):
        again = make_shape(name)
        assert again.vertices.tobytes() == shapes[name].vertices.tobytes()
        assert again.faces.tobytes() == shapes[name].faces.tobytes()


def test_four_families_are_only_for_testing() -> None:
    assert len(FAMILIES) >= 14
    assert held_out_families() == ("boat", "car", "fitting", "hand")
    assert {name.rsplit("_", 1)[0] for name in shape_names(100, split="test")} == set(held_out_families())
    training = {name.rsplit("_", 1)[0] for name in shape_names(100, split="training")}
    assert training == set(FAMILIES) - set(held_out_families())


def test_split_goes_by_the_family_or_by_the_name_of_a_real_mesh() -> None:
    assert split_of("car_12") == split_of("car_7") == "test"
    assert split_of("vase_12") == "training"
    assert split_of("car_old") == split_of("car_old")  # a real mesh: no number, so its own name decides
    halves = [split_of(f"mesh {k}") for k in range(500)]
    assert 0.33 < halves.count("test") / 500 < 0.47


def test_another_seed_means_other_names() -> None:
    assert shape_names(2, families=("vase",)) == ["vase_0", "vase_1"]
    assert shape_names(1, seed=2, families=("vase",)) == ["vase_200000"]


@pytest.mark.parametrize("name", ["vase", "vase_x", "teapot_3"])
def test_unknown_names_are_told(name: str) -> None:
    with pytest.raises(ArgumentError, match="FAMILY_NUMBER"):
        make_shape(name)
