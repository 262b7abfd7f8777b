"""The baselines: what they draw, and searches that find what they should."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from eval.baselines import canny, grid, rtsc
from eval.baselines.rtsc import ALWAYS, AR, METHODS, RV, SC, plan
from eval.measures.evaluation import Settings, Target
from eval.measures.thinning import read_ink
from ncmodel.camera import Camera
from ncmodel.chamfer import chamfer_distance
from ncmodel.drawing.plan import Plan
from ncmodel.mesh.load import load_mesh, make_mesh
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Image, LineFamily, Thresholds
from tests.helpers.analytic import height_field

SIZE = (160, 120)
LEVELS = 11


def drawn(view: View, plan: Plan) -> Image:
    return rtsc.draw(view, plan)


@pytest.fixture(scope="module")
def view() -> View:
    """Hills and dents on an open sheet: lines of every family, and a boundary."""

    def height(x: Floats, y: Floats) -> Floats:
        return np.asarray(0.1 * np.cos(9 * x) * np.cos(7 * y) + 0.05 * np.sin(16 * x + 3 * y))

    mesh = make_mesh(*height_field(height, cells=60), "hills")
    return View(Surface(mesh), Camera.orbit(mesh.vertices, elevation=40, size=SIZE))


def test_drawings_are_ink_of_the_camera_s_size(view: View) -> None:
    for name, settings in METHODS.items():
        ink = drawn(view, settings)
        assert ink.shape == (SIZE[1], SIZE[0]), name
        assert ink.dtype == np.float32
        assert 0.0 <= ink.min() < ink.max() <= 1.0


def test_all_lines_are_those_of_the_families_together(view: View) -> None:
    drawings = {name: drawn(view, settings) for name, settings in METHODS.items()}
    together = np.maximum.reduce([drawings[name] for name in METHODS if name != "all-rtsc"])
    np.testing.assert_array_equal(drawings["all-rtsc"], together)
    for name in ("SC-rtsc", "RV-rtsc", "AR-rtsc"):
        assert drawings[name].sum() > drawings["contours"].sum()


def test_boundaries_are_always_drawn(view: View) -> None:
    boundary = rtsc.layer(view, LineFamily.BOUNDARIES)
    assert boundary.sum() > 100
    assert (drawn(view, plan()) >= boundary).all()


def test_higher_thresholds_only_take_away(view: View) -> None:
    for family in SC + RV + AR:
        inks = [rtsc.layer(view, family, threshold) for threshold in (0.0, 0.01, 0.1, 1.0)]
        # Strokes are simplified anew at each threshold, so pixels beside a line may change a little.
        assert all(np.maximum(less - more, 0).sum() < 0.05 * less.sum() + 1e-9 for more, less in pairwise(inks))
        assert inks[0].sum() > inks[2].sum()


@pytest.mark.parametrize("shape", ["bumpy_sphere", "torus"])
@pytest.mark.parametrize(
    ("picture", "families"),
    [("contours", ()), ("apparent", AR), ("contours_ridges_valleys", RV), ("contours_suggestive", SC)],
)
def test_the_classic_program_s_drawings_are_matched(
    shared: Path, shape: str, picture: str, families: tuple[LineFamily, ...]
) -> None:
    reference = shared / "reference"
    mesh = load_mesh(reference / f"{shape}.ply")
    ink = drawn(View(Surface(mesh), Camera.load(reference / f"{shape}.camera.json")), plan(families))
    target = Target.of(shape, {"rtsc": read_ink(reference / f"{shape}_{picture}.png")}, Settings(2.0))
    found = target.scores(target.prepare(ink))[0].measures
    assert min(found.precision, found.recall) > 0.98


def test_a_family_without_threshold_is_left_out(view: View) -> None:
    left_out = plan(SC, Thresholds(suggestive=None))
    np.testing.assert_array_equal(drawn(view, left_out), drawn(view, plan()))


def step(contrast: float) -> Image:
    picture = np.full((40, 60), 0.5 - contrast / 2, np.float32)
    picture[:, 30:] += contrast
    return picture


@pytest.mark.parametrize("turn", range(4))
def test_an_edge_is_one_line_at_the_step(turn: int) -> None:
    found = np.rot90(canny.edges(np.rot90(step(0.8), turn).copy(), canny.CannySettings()), -turn)
    columns = np.argwhere(found)[:, 1]
    assert set(columns) in ({29}, {30})
    assert len(columns) >= 36


def test_thresholds_are_brightness_per_pixel() -> None:
    ramp = np.repeat(np.linspace(0.0, 1.0, 61, dtype=np.float32)[None], 40, axis=0)
    bent = np.where(np.arange(61) < 30, 2 * ramp, 1.0 - 0.2 * (ramp - 0.5)).astype(np.float32)
    slope = 2 / 60
    assert canny.edges(bent, canny.CannySettings(0.0, 1.2 * slope, 1.2 * slope)).sum() == 0
    assert canny.edges(bent, canny.CannySettings(0.0, 0.8 * slope, 0.8 * slope)).sum() > 0


def test_a_flat_picture_has_no_edges() -> None:
    for value in (0.0, 0.3, 1.0):
        assert not canny.edges(np.full((20, 30), value, np.float32), canny.CannySettings(high=0.001, low=0.001)).any()


def test_weak_edges_are_followed_from_strong_ones() -> None:
    fading = step(0.5) * np.linspace(1.0, 0.1, 40, dtype=np.float32)[:, None]
    strict = canny.edges(fading, canny.CannySettings(1.0, 0.15, 0.15))
    lenient = canny.edges(fading, canny.CannySettings(1.0, 0.15, 0.03))
    assert (strict <= lenient).all()
    assert lenient.sum() > 1.5 * strict.sum() > 0


def target_of(ink: Image, *more: Image) -> Target:
    return Target.of("hills", {str(n): drawing for n, drawing in enumerate((ink, *more))}, Settings())


def test_the_search_finds_the_parameters_that_drew_the_reference(view: View) -> None:
    truth = canny.GRID[9]
    examples = [(view, target_of(canny.draw(view, truth)))]
    assert canny.search(examples, canny.GRID[::3]) == truth
    with pytest.raises(ValueError, match="no examples"):
        canny.search([])


@pytest.fixture(scope="module")
def found(view: View) -> grid.Search:
    """A search for a drawing of suggestive contours and apparent ridges at two of the levels."""
    truth = plan(SC + AR, Thresholds(suggestive=0.1, apparent=0.1))
    return grid.search([(view, target_of(drawn(view, truth)))], LEVELS)


def test_the_grid_search_finds_the_thresholds_that_drew_the_reference(found: grid.Search) -> None:
    assert found.thresholds == pytest.approx(np.linspace(0, 1, LEVELS))
    both = found.best(SC, AR)
    assert both.families == (*ALWAYS, *SC, *AR)
    # Within a step: a union's thin lines aren't quite those of a drawing of both families.
    assert (both.thresholds.suggestive, both.thresholds.apparent) == pytest.approx((0.1, 0.1), abs=0.101)
    assert both.thresholds.ridges is None
    assert found.costs[1, LEVELS, 1] < 0.1


def test_every_variant_draws_its_families_at_the_best_of_its_levels(found: grid.Search, view: View) -> None:
    assert list(found.methods) == ["SC-grid", "RV-grid", "AR-grid", "all-grid"]
    assert [m.families for m in found.methods.values()] == [(*ALWAYS, *kinds) for kinds in (SC, RV, AR, SC + RV + AR)]
    ridges = found.methods["RV-grid"].thresholds
    assert ridges.ridges == ridges.valleys == found.thresholds[int(np.argmin(found.costs[LEVELS, :-1, LEVELS]))]
    assert found.best() == plan((), Thresholds(None, None, None, None))
    for settings in found.methods.values():
        assert drawn(view, settings).any()


def test_costs_are_close_to_those_of_the_final_drawings(found: grid.Search, view: View) -> None:
    truth = drawn(view, plan(SC + AR, Thresholds(suggestive=0.1, apparent=0.1)))
    target = target_of(truth)
    for index in [(0, 0, 0), (1, 2, 3), (5, 1, 2), (2, 5, 5)]:
        s, r, a = (found.thresholds[place] for place in index)
        drawing = target.prepare(drawn(view, plan(SC + RV + AR, Thresholds(s, r, r, a))))
        exact = chamfer_distance(drawing, target.references["0"])
        assert found.costs[index] == pytest.approx(exact, rel=0.15, abs=0.3)


def test_references_and_views_are_averaged(view: View) -> None:
    drawings = [drawn(view, METHODS[name]) for name in ("contours", "AR-rtsc")]
    each = [grid.search([(view, target_of(ink))], 3).costs for ink in drawings]
    both = grid.search([(view, target_of(*drawings))], 3).costs
    apart = grid.search([(view, target_of(ink)) for ink in drawings], 3).costs
    np.testing.assert_allclose(both, np.mean(each, axis=0))
    np.testing.assert_allclose(apart, both)
    with pytest.raises(ValueError, match="no examples"):
        grid.search([])
