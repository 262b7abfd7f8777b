"""What a request doesn't need isn't computed, and nothing is computed twice: the trace tells."""

import pytest

from ncmodel.camera import Camera
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import LineFamily, Mesh
from tests.helpers import analytic

CURVATURE = {"point_areas", "curvature"}
FOR_LINES = {
    # What each family needs before its own extraction.
    "boundaries": {"faces", "is_closed", "boundary_edges"},
    "creases": {"faces", "rings", "creases"},
    "intersections": {"faces", "rings", "intersections"},
    "suggestive": {"faces", "normals", "n_dot_v", *CURVATURE, "dcurv", "enclosing_radius", "feature_size"}
    | {"radial_curvature", "sc_num"},
    "ridges": {"faces", "normals", "n_dot_v", *CURVATURE, "dcurv", "enclosing_radius", "feature_size"}
    | {"ridges_and_valleys"},
    "apparent": {"faces", "normals", "n_dot_v", *CURVATURE, "enclosing_radius", "feature_size", "rings"}
    | {"radial_curvature", "view_curvature", "view_derivative"},
    "contours": {"faces", "normals", "n_dot_v", *CURVATURE, "radial_curvature"},
}


def view_of(mesh: Mesh) -> View:
    return View(Surface(mesh), Camera((1.3, 1.1, 2.4), width=64, height=64, focal_pixels=120.0))


def stages(view: View) -> list[str]:
    return [timing.stage for timing in view.trace.timings]


@pytest.mark.parametrize("family", FOR_LINES)
def test_lines_compute_what_they_need_once(family: str) -> None:
    view = view_of(Mesh(*analytic.torus(24, 12)))
    for _ in range(2):
        view.lines(LineFamily(family))
    done = stages(view)
    assert set(done) == FOR_LINES[family] | {f"lines_{family}"}
    assert len(done) == len(set(done))


def test_visible_contours_need_no_curvature() -> None:
    view = view_of(Mesh(*analytic.torus(24, 12)))
    assert len(view.visible(LineFamily.CONTOURS)) > 0
    assert not {"curvature", "dcurv", "radial_curvature", "feature_size"} & set(stages(view))
    assert {"facing_slope", "outlines", "visible_contours", "polygonal_outlines"} <= set(stages(view))


def test_intersections_are_found_once_for_all_views() -> None:
    surface = Surface(Mesh(*analytic.torus(24, 12)))
    for eye in ((1.3, 1.1, 2.4), (-2.0, 0.3, 1.0)):
        View(surface, Camera(eye)).visible(LineFamily.INTERSECTIONS)
    assert [timing.stage for timing in surface.trace.timings].count("intersections") == 1
    contours = view_of(Mesh(*analytic.torus(24, 12)))
    contours.visible(LineFamily.CONTOURS)
    assert "intersections" not in stages(contours)


def test_apparent_ridges_need_no_derivative_of_curvature() -> None:
    view = view_of(Mesh(*analytic.torus(24, 12)))
    view.visible(LineFamily.APPARENT)
    assert "dcurv" not in stages(view)


def test_a_closed_mesh_is_not_searched_for_borders() -> None:
    closed, opened = view_of(Mesh(*analytic.torus(24, 12))), view_of(Mesh(*analytic.cylinder(8, 12)))
    assert len(closed.lines(LineFamily.BOUNDARIES)) == 0
    assert len(opened.lines(LineFamily.BOUNDARIES)) == 24
    assert "rings" not in stages(closed)
    assert "rings" in stages(opened)


def test_maps_smooth_normals_only_for_shading() -> None:
    view = view_of(Mesh(*analytic.torus(24, 12)))
    view.feature_map(LineFamily.RIDGES)
    assert view.depth.shape == (64, 64)
    assert "smoothed_normals" not in stages(view)
    assert view.shaded.shape == (6, 64, 64)
    assert stages(view).count("smoothed_normals") == stages(view).count("buffers") == 1


def test_two_views_share_what_the_surface_knows() -> None:
    surface = Surface(Mesh(*analytic.torus(24, 12)))
    for eye in ((1.3, 1.1, 2.4), (-2.0, 0.3, 1.0)):
        View(surface, Camera(eye)).lines(LineFamily.SUGGESTIVE)
    done = [timing.stage for timing in surface.trace.timings]
    assert done.count("curvature") == done.count("dcurv") == done.count("normals") == 1
    assert done.count("sc_num") == done.count("lines_suggestive") == 2
