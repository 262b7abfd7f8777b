"""Strokes as data: in a file and in a table, with their places in space."""

import json
from pathlib import Path

import numpy as np
import pytest

from ncmodel.drawing.draw import draw
from ncmodel.drawing.drawing import Drawing
from ncmodel.mesh.load import make_mesh
from ncmodel.types import Stroke
from tests.helpers.dirty import box


@pytest.fixture(scope="module")
def cube() -> Drawing:
    return draw(make_mesh(*box(), name="cube"), hidden="layer", lines="creases")


def test_positions_are_on_the_shape(cube: Drawing) -> None:
    frame = cube.strokes_frame()
    assert list(frame) == ["family", "hidden", "strength", "length", "points", "opacity", "depth", "position"]
    assert len(frame) == len(cube.strokes)
    assert set(frame["family"]) == {"creases"}
    assert 0 < frame["hidden"].sum() < len(frame)
    positions = np.concatenate(list(frame["position"]))
    # Edges of a cube of side 1: two coordinates are 1/2.
    np.testing.assert_allclose(np.sort(np.abs(positions), axis=1)[:, 1:], 0.5, atol=5e-3)
    back = cube.camera.project(positions)
    np.testing.assert_allclose(back[:, :2], np.concatenate(list(frame["points"])), atol=1e-6)


def test_a_file_holds_the_table(cube: Drawing, tmp_path: Path) -> None:
    cube.save(tmp_path / "a.json")
    found = json.loads((tmp_path / "a.json").read_text())
    assert found["shape"] == "cube"
    assert found["camera"] == json.loads(cube.camera.to_json())
    frame = cube.strokes_frame()
    assert [stroke["hidden"] for stroke in found["strokes"]] == frame["hidden"].tolist()
    for stroke, (_, row) in zip(found["strokes"], frame.iterrows(), strict=True):
        assert set(stroke) == set(frame)
        np.testing.assert_allclose(stroke["points"], row["points"], atol=0.0051)
        np.testing.assert_allclose(stroke["position"], row["position"], atol=1e-6)
        assert stroke["length"] == pytest.approx(row["length"], abs=0.0051)


def test_strength_is_the_mean_opacity_along_the_line(cube: Drawing) -> None:
    points = np.array([[0.0, 0.0], [10.0, 0.0], [40.0, 0.0]])
    drawn = Drawing(cube.camera, (Stroke("image", points, np.array([1.0, 1.0, 0.0])),))
    row = drawn.strokes_frame().iloc[0]
    assert row["strength"] == pytest.approx((10.0 + 15.0) / 40.0)
    assert row["length"] == 40.0
    assert row["depth"] is None
    assert row["position"] is None


def test_strokes_turned_for_the_pen_keep_their_places(cube: Drawing) -> None:
    positions = {p.round(3).tobytes() for row in cube.strokes_frame()["position"] for p in np.abs(row) + 1.0}
    turned = cube.sorted_for_pen().strokes_frame()
    assert positions == {p.round(3).tobytes() for row in turned["position"] for p in np.abs(row) + 1.0}
    starts = [stroke.points[0].tolist() for stroke in cube.strokes]
    assert any(row[0].tolist() not in starts for row in turned["points"])
