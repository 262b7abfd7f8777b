"""How much drawings of one surface depend on its mesh: three tessellations, mutual F1 within 2 pixels.

Run by command for the table: pytest -m slow -s tests/ncmodel/scene/test_retessellation.py
"""

from itertools import combinations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from eval.measures.metrics import compare_lines
from eval.measures.thinning import thin_lines
from ncmodel.camera import Camera
from ncmodel.chamfer import Lines
from ncmodel.drawing.draw import draw
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Ints, LineFamily, Mesh, Thresholds
from tests.helpers import analytic

THRESHOLDS = Thresholds(suggestive=0.005, ridges=0.04, valleys=0.04, apparent=0.02)
"""Low enough that every family has lines on this surface."""

LEAST_F1 = {
    LineFamily.CONTOURS: 0.99,
    LineFamily.SUGGESTIVE: 0.81,
    LineFamily.RIDGES: 0.69,
    LineFamily.VALLEYS: 0.77,
    LineFamily.APPARENT: 0.765,
}
"""Somewhat below what is measured at 40000 vertices, with one feature size."""
OWN_SIZES = {**LEAST_F1, LineFamily.SUGGESTIVE: 0.78}
"""With the meshes' own, which `draw` uses: their thresholds differ as their feature sizes do, by up to 15 %."""


def lumpy(directions: Floats) -> Floats:
    """Points of a star-shaped surface with bumps and dents."""
    x, y, z = directions.T
    waves = np.sin(4 * x + 1) * np.cos(5 * y) + np.sin(5 * z + 2 * x) + np.cos(6 * y + 2 * z)
    return np.asarray(directions * (0.45 + 0.075 * np.tanh(1.5 * waves))[:, None])


def random_sphere(count: int) -> tuple[Floats, Ints]:
    """The Delaunay triangulation of random points on the unit sphere."""
    directions = np.random.default_rng(0).normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    faces = ConvexHull(directions).simplices.astype(np.int64)
    corners = directions[faces]
    inwards = np.einsum("ij,ij->i", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2]) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    return directions, faces


def tessellations(scale: int) -> dict[str, Mesh]:
    """About 10000 vertices each, times the square of `scale`."""
    spheres = {
        "uniform": analytic.icosphere(4 + scale),
        "anisotropic": analytic.sphere(200 * scale, 52 * scale),
        "random": random_sphere(10242 * scale**2),
    }
    return {name: Mesh(lumpy(vertices), faces) for name, (vertices, faces) in spheres.items()}


def table(scale: int, one_size: bool = False) -> dict[LineFamily, dict[str, float]]:
    """F1 between drawings of each pair of meshes, by family; with one feature size for all three if `one_size`."""
    surfaces = {name: Surface(mesh) for name, mesh in tessellations(scale).items()}
    if one_size:
        size = surfaces["uniform"].feature_size
        for surface in surfaces.values():
            surface.__dict__["feature_size"] = size
    camera = Camera.orbit(surfaces["uniform"].mesh.vertices)
    result: dict[LineFamily, dict[str, float]] = {}
    for family in LEAST_F1:
        drawn = {
            n: Lines.of(thin_lines(draw(s, camera, [family], THRESHOLDS).ink(1.5), 0.3)) for n, s in surfaces.items()
        }
        result[family] = {f"{a}-{b}": compare_lines(drawn[a], drawn[b], 2.0).f1 for a, b in combinations(drawn, 2)}
    return result


def test_feature_sizes_of_one_surface_are_alike() -> None:
    """They follow the vertices, so crowding them shifts the size; meshes of even density agree."""
    sizes = {name: Surface(mesh).feature_size for name, mesh in tessellations(1).items()}
    assert sizes["random"] == pytest.approx(sizes["uniform"], rel=0.02)
    assert sizes["anisotropic"] == pytest.approx(sizes["uniform"], rel=0.15)


@pytest.mark.slow
def test_drawings_of_one_surface_agree_more_on_finer_meshes() -> None:
    """With the meshes' own feature sizes, as drawings have them; with one for all, that tests the curvature fit."""
    coarse, fine, own = table(1, one_size=True), table(2, one_size=True), table(2)
    for label, scores in (
        ("10000, own sizes", table(1)),
        ("10000, one size", coarse),
        ("40000, own sizes", own),
        ("40000, one size", fine),
        ("90000, own sizes", table(3)),
    ):
        for family, row in scores.items():
            cells = "  ".join(f"{pair} {score:.3f}" for pair, score in row.items())
            print(f"{label:16} {family:10} {cells}")  # noqa: T201
    for family, least in LEAST_F1.items():
        assert min(fine[family].values()) > least
        assert min(own[family].values()) > OWN_SIZES[family]
        assert min(fine[family].values()) > min(coarse[family].values())
