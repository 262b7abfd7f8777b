"""What is measured of a view goes to disk and back, and what is there isn't measured again."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest

from dataset_tools.build.runners import HereRunner, Outcome
from eval.default_model import views
from eval.default_model.views import MeasuredView, ShapeTask, distances_to, measure_all, measure_view
from ncmodel.data.item import Item
from ncmodel.drawing.settings import LayeredDrawings, Levels
from ncmodel.errors import InputError
from ncmodel.mesh.load import make_mesh
from ncmodel.readers.ply import ply_bytes
from ncmodel.scene.surface import Surface
from ncmodel.types import Mesh
from tests.helpers.counted import counted
from tests.helpers.views import bumpy


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(views, "SIZE", (96, 96))


def test_measured_views_go_to_disk_and_back(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    view = MeasuredView(Item("a_b", "3"), counted(rng), rng.random((5, 256)), np.arange(8))
    view.save(tmp_path)
    loaded = MeasuredView.load(tmp_path / "a_b_3.npz")
    assert loaded.item == view.item
    np.testing.assert_allclose(loaded.statistics.numbers(), view.statistics.numbers(), rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(loaded.distances, view.distances, rtol=1e-6)
    assert np.array_equal(loaded.shown, view.shown)


@pytest.mark.parametrize("content", [b"", b"PK\3\4"])
def test_files_that_are_none(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "s_0.npz").write_bytes(content)
    with pytest.raises(InputError, match="expected a measured view"):
        MeasuredView.load(tmp_path / "s_0.npz")


def test_a_view_has_numbers_and_distances_of_all_settings_and_eight_that_are_shown() -> None:
    found = measure_view(Surface(make_mesh(*bumpy(), "s")), Item("s", "0"))
    assert found.statistics.drawings.shape[0] == 256
    assert found.distances.shape[1] == 256
    assert (found.distances >= 0).all()
    assert np.isfinite(found.distances).all()
    assert len(set(found.shown.tolist())) == 8
    assert found.shown.max() < 256


def test_the_drawing_that_an_artist_drew_is_at_distance_0() -> None:
    ink = (np.random.default_rng(0).random((12, 96, 96)) < 0.01).astype(np.float32)
    drawings = LayeredDrawings(Levels(), np.stack([np.kron(layer[:24, :24], np.ones((4, 4))) for layer in ink]))
    found = distances_to(drawings, [drawings.drawing(40)])
    assert found.shape == (1, 256)
    assert found[0, 40] == pytest.approx(found.min())
    assert found[0].max() > found[0, 40]


def test_only_missing_views_are_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured: list[str] = []

    def noted(surface: Surface, item: Item) -> MeasuredView:
        measured.append(item.name)
        rng = np.random.default_rng(0)
        return MeasuredView(item, counted(rng), rng.random((2, 256)), np.arange(8))

    monkeypatch.setattr(views, "measure_view", noted)
    (tmp_path / "s.ply").write_bytes(ply_bytes(Mesh(*bumpy())))
    task = ShapeTask(str(tmp_path / "s.ply"), 2, str(tmp_path))
    assert measure_all([task], HereRunner()) == {}
    assert measured == ["s_0", "s_1"]
    (tmp_path / "s_1.npz").unlink()
    measure_all([task], HereRunner())
    assert measured == ["s_0", "s_1", "s_1"]


class Failing:
    """A runner whose tasks end badly."""

    def run(self, function: object, tasks: Sequence[ShapeTask], limits: object) -> Iterator[Outcome[ShapeTask, int]]:
        for task in tasks:
            yield Outcome(task, None, "too large")


def test_shapes_that_failed_are_told(tmp_path: Path) -> None:
    assert measure_all([ShapeTask("s.ply", 1, str(tmp_path))], Failing()) == {"s": "too large"}  # type: ignore[arg-type]
