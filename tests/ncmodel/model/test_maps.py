"""Line maps of surfaces: I_G(t) is the vector drawing at t, percentiles are the maps', nothing extra is computed."""

import numpy as np
import pytest
import torch

from ncmodel.drawing.draw import draw_view
from ncmodel.drawing.plan import Plan
from ncmodel.model.filters import line_drawing
from ncmodel.model.maps import line_maps, network_maps
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, Image, LineFamily, Thresholds
from tests.helpers.analytic import monkey_saddle, plane, torus
from tests.helpers.views import orbited

SIDE = 128


@pytest.fixture(scope="module")
def bumpy() -> View:
    """A torus squeezed out of shape, so that every family has lines of many strengths."""
    vertices, faces = torus()
    x, y, z = vertices.T
    bent = np.stack([x * (1 + 0.3 * np.sin(7 * y)), y * 1.4, z * (1 + 0.25 * np.sin(9 * x))], axis=1)
    return orbited(bent, faces, SIDE)


def geometric_drawing(view: View, thresholds: dict[LineFamily, float]) -> Image:
    """I_G(t) by equations 1-5."""
    maps = line_maps(view)
    t = torch.tensor([[thresholds[family] for family in FILTERED_FAMILIES]])
    always = np.maximum(maps.contours, maps.boundaries).ravel()
    lines, features = (torch.from_numpy(part.reshape(4, -1)) for part in (maps.lines, maps.features))
    return line_drawing(lines, features, torch.from_numpy(always), t)[0].reshape(maps.contours.shape).numpy()


def drawing_at(view: View, thresholds: dict[LineFamily, float]) -> Image:
    """What `draw` writes at these thresholds."""
    values = Thresholds(unit="p90").with_values(**{family.value: t for family, t in thresholds.items()})
    families = (LineFamily.CONTOURS, LineFamily.BOUNDARIES, *FILTERED_FAMILIES)
    return draw_view(view, Plan(families, values)).ink()


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.9])
def test_the_drawing_of_the_maps_is_the_drawing_of_the_vectors(bumpy: View, share: float) -> None:
    maps = line_maps(bumpy)
    thresholds = {}
    for family, ink, feature in zip(FILTERED_FAMILIES, maps.lines, maps.features, strict=True):
        strong = feature[ink > 0.3]
        thresholds[family] = float(np.quantile(strong, share)) if strong.size else 0.0
    by_maps, by_vectors = geometric_drawing(bumpy, thresholds), drawing_at(bumpy, thresholds)
    assert by_vectors.sum() > 100
    # Where lines cross, a pixel carries the feature of one of them only.
    assert np.abs(by_maps - by_vectors).mean() < 0.004
    assert np.corrcoef(by_maps.ravel(), by_vectors.ravel())[0, 1] > 0.99


def test_percentiles_are_those_of_the_positive_seen_values(bumpy: View) -> None:
    maps = line_maps(bumpy)
    for family, found in zip(FILTERED_FAMILIES, maps.p90, strict=True):
        values = bumpy.feature_map(family)
        assert (values[values > 0] <= found).mean() == pytest.approx(0.9, abs=0.01)


def test_features_stand_where_lines_stand(bumpy: View) -> None:
    maps = line_maps(bumpy)
    assert maps.lines.shape == maps.features.shape == (4, SIDE, SIDE)
    assert (maps.features[maps.lines == 0] == 0).all()
    assert (maps.features >= 0).all()
    assert 0 <= maps.lines.min() <= maps.lines.max() <= 1
    assert (maps.boundaries == 0).all()


def test_maps_barely_depend_on_resolution(bumpy: View) -> None:
    """Thresholds chosen at one size serve another."""
    fine = View(bumpy.surface, bumpy.camera.resized(4 * SIDE, 4 * SIDE))
    for family in FILTERED_FAMILIES:
        assert fine.feature_percentile(family) == pytest.approx(bumpy.feature_percentile(family), rel=0.05)
    coarse, shrunk = line_maps(bumpy), line_maps(fine)
    averaged = shrunk.lines.reshape(4, SIDE, 4, SIDE, 4).mean(axis=(2, 4))
    np.testing.assert_allclose(averaged.sum(axis=(1, 2)), coarse.lines.sum(axis=(1, 2)), rtol=0.05)


def test_only_the_families_asked_for_are_computed(bumpy: View) -> None:
    view = View(Surface(bumpy.mesh), bumpy.camera)
    maps = line_maps(view, [LineFamily.RIDGES])
    assert maps.lines[FILTERED_FAMILIES.index(LineFamily.RIDGES)].any()
    assert not maps.lines[[0, 2, 3]].any()
    computed = set(view.trace.seconds())
    assert "lines_ridges" in computed
    assert not computed & {"lines_suggestive", "lines_apparent", "lines_valleys", "view_curvature", "dt1q1"}


def test_open_surfaces_have_boundaries() -> None:
    view = orbited(*monkey_saddle(), SIDE)
    maps = line_maps(view)
    assert maps.boundaries.max() > 0.3
    assert np.isfinite(maps.features).all()


def test_a_plane_has_no_filtered_lines_and_units_that_are_numbers() -> None:
    maps = line_maps(orbited(*plane(), SIDE))
    assert np.isfinite(maps.p90).all()
    assert (maps.p90 > 0).all()
    assert np.isfinite(maps.features).all()


def test_network_maps_are_depth_and_shading(bumpy: View) -> None:
    maps = network_maps(bumpy)
    assert maps.shape == (7, SIDE, SIDE)
    assert maps.dtype == np.float32
    np.testing.assert_array_equal(maps[0], bumpy.depth)
    np.testing.assert_array_equal(maps[1:], bumpy.shaded)
    assert (maps[:, ~bumpy.buffers.hit] == 1.0).all()
