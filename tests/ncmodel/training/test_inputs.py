"""Which maps a network reads stands in preset, checkpoint and loader: the paper's variants noms and curv train."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.model.maps import item_maps, network_maps
from ncmodel.model.predictor import Model
from ncmodel.nets.checkpoints import load_checkpoint
from ncmodel.nets.presets import CURVATURE_MAPS, MAPS
from ncmodel.readers.ply import ply_bytes
from ncmodel.training.dataset import ViewImages
from ncmodel.training.train import TrainOptions, run_training
from ncmodel.types import LineFamily, Mesh
from tests.helpers import analytic
from tests.helpers.commands import complaint
from tests.helpers.micro_training import MICRO

pytestmark = pytest.mark.usefixtures("one_thread")

ITEM = Item("s001", "1")


@pytest.fixture(scope="module")
def meshes(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The made-up data folder, with a torus as the mesh of every shape."""
    folder = tmp_path_factory.mktemp("meshes") / "data"
    shutil.copytree(data, folder)
    for shape in range(4):
        path = DataFolder(folder).mesh_path(f"s{shape:03d}")
        path.parent.mkdir(parents=True)
        path.write_bytes(ply_bytes(Mesh(*analytic.torus(30, 15))))
    return folder


def test_curvature_maps_are_computed_clipped_and_white_outside(meshes: Path) -> None:
    data, inputs = DataFolder(meshes), ("depth", *CURVATURE_MAPS)
    whole = item_maps(data, ITEM, inputs)
    view = data.open_view(ITEM)
    for image, name in zip(whole[1:], CURVATURE_MAPS, strict=True):
        unit = view.feature_percentile(LineFamily(name))
        expected = np.clip(view.feature_map(LineFamily(name)) / unit, 0, 1)
        assert image[view.buffers.hit] == pytest.approx(expected[view.buffers.hit], abs=1e-6)
        assert (image[~view.buffers.hit] == 1.0).all()
    images = ViewImages(data, (48,), cache_bytes=0, inputs=inputs)
    assert images.maps(ITEM, 48) == pytest.approx(whole.reshape(5, 48, 2, 48, 2).mean(axis=(2, 4)), abs=2e-5)


def test_units_of_the_mesh_are_other_ones(meshes: Path) -> None:
    view = DataFolder(meshes).open_view(ITEM)
    per_view, per_mesh = (network_maps(view, ["ridges"], unit) for unit in ("view", "mesh"))
    k1 = view.surface.k1
    assert view.feature_percentile(LineFamily.RIDGES, "mesh") == float(np.percentile(k1[k1 > 0], 90))
    assert not np.array_equal(per_view, per_mesh)


@pytest.mark.parametrize("inputs", [("depth", "shaded_0"), (*MAPS, *CURVATURE_MAPS)], ids=["noms", "curv"])
def test_the_paper_s_variants_train_and_draw(meshes: Path, tmp_path: Path, inputs: tuple[str, ...]) -> None:
    preset = replace(MICRO, translation=replace(MICRO.translation, inputs=inputs), percentile="mesh")
    out = tmp_path / "m.safetensors"
    run_training(meshes, meshes / "pairs.jsonl", out, preset, TrainOptions(stages=("ranker", "translator"), epochs=1))
    checkpoint = load_checkpoint(out)
    assert checkpoint.preset == preset
    assert checkpoint.translator is not None
    assert checkpoint.translator.standardise.scale.shape == (len(inputs),)
    plan = Model(checkpoint).choose(DataFolder(meshes).open_view(ITEM), budget="draft")
    assert LineFamily.CONTOURS in plan.families


def test_the_unit_of_thresholds_is_nothing_to_networks_that_read_no_curvature(data: Path, tmp_path: Path) -> None:
    per_view, per_mesh = (
        load_checkpoint(
            run_training(
                data,
                data / "pairs.jsonl",
                tmp_path / unit,
                replace(MICRO, percentile=unit),
                TrainOptions(stages=("ranker", "translator"), epochs=1),
            ).checkpoint
        )
        for unit in ("view", "mesh")
    )
    for name, network in per_view.networks.items():
        other = per_mesh.networks[name].state_dict()
        assert all(torch.equal(value, other[key]) for key, value in network.state_dict().items())


def test_unknown_maps_are_told_in_a_line(meshes: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["train", meshes, meshes / "pairs.jsonl", "-o", tmp_path / "m", "--image-maps", "depth,colour"]
    assert "expected different ones of depth, shaded_0" in complaint(capsys, *words)
