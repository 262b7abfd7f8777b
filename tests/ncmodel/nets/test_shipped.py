"""The model that ships: it is there, small, and draws at once."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from ncmodel.cli.main import main
from ncmodel.errors import UsageError
from ncmodel.model.predictor import Model, load_model
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.shipped import DEFAULT_PATH, checkpoint_path
from ncmodel.readers.ply import ply_bytes
from ncmodel.types import LineFamily, Mesh
from tests.helpers.micro_training import MICRO
from tests.helpers.views import bumpy, orbited

pytestmark = pytest.mark.usefixtures("one_thread")

MOST_BYTES = 8_000_000


def test_it_is_small_and_counts_ink() -> None:
    assert DEFAULT_PATH.stat().st_size < MOST_BYTES
    checkpoint = load_model("default").checkpoint
    assert checkpoint.statistics is not None
    assert checkpoint.statistics.mix.min() >= 0
    assert checkpoint.statistics.mix.max() > 0
    assert "statistics" in checkpoint.training["stages"]


def test_a_file_of_its_name_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert checkpoint_path("default") == DEFAULT_PATH
    (tmp_path / "default").write_bytes(b"mine")
    assert checkpoint_path("default") == Path("default")
    assert checkpoint_path("other.ckpt") == Path("other.ckpt")


def test_drawing_with_it_writes_the_same_bytes_each_time(tmp_path: Path) -> None:
    mesh = tmp_path / "bumpy.ply"
    mesh.write_bytes(ply_bytes(Mesh(*bumpy())))
    for name in ("a.svg", "b.svg"):
        command = ["draw", str(mesh), "-o", str(tmp_path / name), "--model", "default", "--preset", "instant"]
        assert main([*command, "--size", "256x256"]) == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert b"<path" in (tmp_path / "a.svg").read_bytes()


def test_instantly_no_picture_is_looked_at() -> None:
    plan = load_model("default").choose(orbited(*bumpy(), side=128), budget="instant")
    assert plan.evaluations == 0
    assert plan.score is not None
    assert plan.thresholds.unit == "rtsc"


def test_a_model_that_does_not_count_ink_can_not_draw_at_once() -> None:
    model = Model(Checkpoint(MICRO, ranker=RankingModule(MICRO.ranking)))
    with pytest.raises(UsageError, match=r"preset: found 'instant', expected draft, balanced or accurate"):
        model.choose(orbited(*bumpy(), side=64), budget="instant")


@pytest.mark.parametrize("hard", [True, False])
def test_edges_of_machines_are_always_drawn_and_those_of_sculptures_never(hard: bool) -> None:
    made = trimesh.creation.cylinder(1.0, 2.0, sections=12) if hard else trimesh.creation.icosphere(2)
    depth = 0.0 if hard else 0.1
    vertices = made.vertices * (1.0 + depth * np.random.default_rng(0).uniform(-1.0, 1.0, (len(made.vertices), 1)))
    view = orbited(vertices, made.faces, side=128)
    assert len(view.surface.creases()) > 0
    plan = load_model("default").choose(view, budget="instant")
    assert (LineFamily.CREASES in plan.families) == hard
    assert LineFamily.INTERSECTIONS in plan.families
