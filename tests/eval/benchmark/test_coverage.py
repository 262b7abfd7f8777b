"""Drawings are held against rays: outlines complete, nothing hidden drawn, nothing seen left out, no dashes.

Run by command for the table: pytest -m slow -s tests/eval/benchmark/test_coverage.py
"""

from collections.abc import Callable

import numpy as np
import pytest

from dataset_tools.simulation.shapes import KINDS, make_shape
from eval.benchmark import coverage
from eval.benchmark.coverage import Coverage, coverage_rows, depth_jumps, measure_coverage
from eval.benchmark.each_view import VIEWS, mean_rows
from eval.demo.pipeline import bundled_meshes
from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.geometry.raycast import RayScene
from ncmodel.mesh.load import load_mesh, make_mesh
from ncmodel.report.text import text_table
from ncmodel.scene.seams import sew_seams
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Ints, Mesh
from tests.helpers import analytic
from tests.helpers.dirty import box, hemisphere, joined, moebius, moved

Geometry = tuple[Floats, Ints]

BUNDLED = ("bunny.obj", "bunny10k_textured.obj", "airplane.obj", "cow.obj", "bone.ply", "cube.obj")


MADE: dict[str, Callable[[], Geometry]] = {
    "torus": lambda: analytic.torus(64, 32),
    "coarse torus": lambda: analytic.torus(24, 12),
    "twisted torus": lambda: analytic.torus(60, 28, twist=28 / 60),
    "monkey saddle": lambda: analytic.monkey_saddle(48),
    "waves": lambda: analytic.height_field(lambda x, y: 0.1 * np.sin(9 * x) * np.cos(7 * y + x), 60),
    "bowl": hemisphere,
    "moebius": moebius,
    "cube on a cube": lambda: joined(box(), box((0.25, 1, 0.25), (0.75, 1.5, 0.75))),
    "cube beside a cube": lambda: joined(box(), box((1, 0, 0), (2, 1, 1))),
    "shell in a shell": lambda: joined(analytic.icosphere(4, 1.0), analytic.icosphere(4, 0.999)),
    "touching spheres": lambda: joined(analytic.icosphere(4, 0.5), moved(analytic.icosphere(4, 0.5), (1.0, 0.0, 0.0))),
    "fin before a wall": lambda: joined(box((-1, -1, -0.1), (1, 1, 0)), box((-0.5, -0.5, 0.001), (0.5, 0.5, 0.002))),
    "far and near": lambda: joined(analytic.icosphere(4, 0.1), moved(analytic.icosphere(4, 30.0), (0.0, 0.0, -100.0))),
}
"""Shapes that test one clause each: cusps, open surfaces seen from both sides, shells that touch, depths."""


def surface_of(name: str) -> Surface:
    return Surface(make_mesh(*MADE[name](), name=name))


def measured(surface: Surface, views: tuple[tuple[float, float], ...] = VIEWS, size: int = 512) -> Coverage:
    return mean_rows(measure_coverage([surface], lambda _: None, views, size))[0]


@pytest.mark.parametrize("name", ["coarse torus", "cube on a cube", "bowl", "fin before a wall"])
def test_drawings_agree_with_rays(name: str) -> None:
    found = measured(surface_of(name), ((30.0, 20.0), (200.0, -40.0)), 384)
    assert found.outline > 0.999
    assert found.jumps > 0.9
    assert found.hidden < 0.02
    assert found.lost < 0.001
    assert found.gaps <= 1


@pytest.mark.slow
def test_all_shapes_agree_with_rays() -> None:
    files = [sew_seams(Surface(load_mesh(path))) for path in bundled_meshes(BUNDLED)]
    made = [*map(surface_of, MADE), *(Surface(make_shape(kind, 0)) for kind in KINDS)]
    rows = mean_rows(measure_coverage([*files, *made], lambda _: None))
    print(text_table(coverage_rows(rows)))  # noqa: T201
    for row in rows:
        assert row.outline > 0.999, row
        assert row.jumps > 0.92, row
        assert row.hidden < 0.015, row
        assert row.lost < 0.002, row
        assert row.gaps <= 3.0, row
    mean = rows[-1]
    assert mean.jumps > 0.98
    assert mean.hidden < 0.002
    assert mean.lost < 0.0005
    assert mean.gaps < 0.5


def test_jumps_of_depth_are_found_where_they_are() -> None:
    """A small square before a large one, which the background surrounds."""
    square = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    vertices, both = joined((0.5 * square, faces), (0.2 * square + [0.0, 0.0, 0.1], faces))
    camera = Camera((0.0, 0.0, 3.0), width=100, height=100, focal_pixels=200.0)
    places, before_background = depth_jumps(RayScene(Mesh(vertices, both)), camera)
    off = np.abs(places - 50.0).max(axis=1)
    np.testing.assert_allclose(off[before_background], 200 * 0.5 / 3.0, atol=2e-3)
    np.testing.assert_allclose(off[~before_background], 200 * 0.2 / 2.9, atol=2e-3)
    assert min(before_background.sum(), (~before_background).sum()) > 50


def test_a_slope_is_no_jump() -> None:
    vertices, faces = analytic.plane(4)
    camera = Camera((0.0, -0.9, 0.02), width=200, height=200, focal_pixels=60.0)
    _, before_background = depth_jumps(RayScene(Mesh(vertices, faces)), camera)
    assert before_background.all()


def test_what_drawings_lack_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without creases, a cube has no lines; with every line taken for seen, hidden ones are drawn."""
    from ncmodel.scene import view

    monkeypatch.setattr(coverage, "draw", lambda surface, camera, _: draw(surface, camera, ["ridges"]))
    nothing = measured(surface_of("cube on a cube"), ((30.0, 20.0),), 256)
    assert nothing.outline == 0.0
    assert nothing.jumps == 0.0
    monkeypatch.undo()
    monkeypatch.setattr(view.View, "unhidden", lambda _, lines, __=1.0: lines)
    everything = measured(surface_of("cube on a cube"), ((30.0, 20.0),), 256)
    assert 0.2 < everything.hidden < 0.5
    assert everything.lost == 0.0
    monkeypatch.setattr(view.View, "unhidden", lambda _, lines, __=1.0: lines.take(np.arange(0)))
    nothing = measured(surface_of("cube on a cube"), ((30.0, 20.0),), 256)
    assert nothing.hidden == 0.0
    assert nothing.lost == 1.0


@pytest.mark.parametrize(("gap", "turn", "dashes"), [(0.5, 0.0, 0), (3.0, 0.0, 1), (7.0, 0.0, 0), (3.0, 2.0, 0)])
def test_dashes_are_short_gaps_on_a_line(gap: float, turn: float, dashes: int) -> None:
    one = np.array([[0.0, 0.0], [10.0, 0.0]])
    other = np.array([[10.0 + gap, 0.0], [20.0 + gap, 10.0 * turn]])
    assert coverage._gaps([one, other], [one, other]) == dashes
    bridge = np.array([[5.0, 0.0], [25.0, 0.0]])
    assert coverage._gaps([one, other], [one, other, bridge]) == 0


def test_rows_average_views_first() -> None:
    found = [
        Coverage("a", 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0),
        Coverage("a", 1.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0),
        Coverage("b", 0.0, 0.0, 0.25, 0.0, 0.1, 0.0, 0.0),
    ]
    means = mean_rows(found)
    assert [row.shape for row in means] == ["a", "b", "mean"]
    assert [row.outline for row in means] == [0.75, 0.25, 0.5]
    assert coverage_rows(means)[2] == ["b", "25.00", "0.00", "10.00", "0.00", "0.0"]
