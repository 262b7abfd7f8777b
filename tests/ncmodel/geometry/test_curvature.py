"""Normals, areas, curvature and its derivative: against the plain definitions, closed forms, and other orders."""

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Mesh
from tests.helpers import analytic, spec_oracle
from tests.helpers.spec_oracle import Oracle
from tests.helpers.views import EYE, bumpy, seen


@pytest.fixture(scope="module")
def view() -> View:
    return seen(bumpy())


@pytest.fixture(scope="module")
def oracle() -> Oracle:
    return spec_oracle.evaluate(*bumpy(), np.array(EYE))


def agree(found: Floats, expected: Floats, tolerance: float = 1e-9) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * np.abs(expected).max())


def test_the_definitions_face_by_face(view: View, oracle: Oracle) -> None:
    """Every quantity equals the slow oracle's, directions up to sign."""
    surface = view.surface
    agree(surface.normals, oracle.normals)
    agree(surface.point_areas, oracle.point_areas)
    agree(surface.k1, oracle.k1)
    agree(surface.k2, oracle.k2)
    sign = np.sign((surface.dir1 * oracle.dir1).sum(axis=1))
    agree(surface.dir1 * sign[:, None], oracle.dir1, 1e-7)
    agree(surface.dcurv * sign[:, None], oracle.dcurv, 1e-7)
    agree(view.n_dot_v, oracle.n_dot_v)
    agree(view.kr, oracle.kr)
    agree(view.sc_num, oracle.sc_num)
    agree(view.q1, oracle.q1)
    agree(view.dt1q1 * np.sign((view.t1 * sign[:, None] * oracle.t1).sum(axis=1)), oracle.dt1q1, 1e-7)


def test_the_oracle_meets_acute_and_obtuse_faces() -> None:
    """The comparison covers both ways to divide a face among its corners."""
    vertices, faces = bumpy()
    squares = np.array([(spec_oracle.edges(vertices, face) ** 2).sum(axis=1) for face in faces])
    obtuse = (2 * squares.max(axis=1) > squares.sum(axis=1)).mean()
    assert 0.1 < obtuse < 0.9


def test_areas_add_up() -> None:
    for builder in (analytic.icosphere, analytic.sphere, analytic.torus, analytic.monkey_saddle):
        vertices, faces = builder()
        surface = Surface(Mesh(vertices, faces))
        corners = vertices[faces]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
        assert surface.point_areas.sum() == pytest.approx(area, rel=1e-12)
        assert (surface.point_areas > 0).all()


@pytest.mark.parametrize("radius", [0.01, 1.0, 40.0])
@pytest.mark.parametrize("build", [analytic.icosphere, lambda r: analytic.sphere(20, 40, r)], ids=["ico", "lat-long"])
def test_sphere_is_exact(radius: float, build) -> None:  # type: ignore[no-untyped-def]
    """These normals are exact on a sphere, so its curvature is 1/R to rounding at any tessellation."""
    vertices, faces = build(radius=radius) if build is analytic.icosphere else build(radius)
    surface = Surface(Mesh(vertices, faces))
    np.testing.assert_allclose(surface.normals, vertices / radius, atol=1e-12)
    np.testing.assert_allclose(surface.curvatures, 1 / radius, rtol=1e-11)
    assert np.abs(surface.dcurv).max() < 1e-9 / radius**2


def test_plane_has_none() -> None:
    surface = Surface(Mesh(*analytic.plane(6)))
    assert (surface.curvatures == 0).all()
    assert (surface.dcurv == 0).all()
    np.testing.assert_array_equal(surface.normals, np.tile([0.0, 0.0, 1.0], (49, 1)))


def test_cylinder_is_exact_off_its_ends() -> None:
    vertices, faces = analytic.cylinder(24, 40, 0.3)
    surface = Surface(Mesh(vertices, faces))
    inner = np.abs(vertices[:, 1]) < 0.35
    np.testing.assert_allclose(surface.k1[inner], 1 / 0.3, rtol=1e-10)
    np.testing.assert_allclose(surface.k2[inner], 0, atol=1e-10)
    np.testing.assert_allclose(np.abs(surface.dir2[inner, 1]), 1, rtol=1e-10)


def order(errors: list[float]) -> float:
    """The order of convergence between the last two of a row of errors at halved edges."""
    return float(np.log2(errors[-2] / errors[-1]))


@pytest.mark.parametrize("twist", [0.0, 0.5])
def test_torus_converges_at_second_order(twist: float) -> None:
    """Largest errors of k1, k2 and of the one derivative that isn't 0, straight and sheared grids."""
    major, minor = 0.355, 0.145
    errors: dict[str, list[float]] = {"k1": [], "k2": [], "c122": [], "c111": []}
    for n in (32, 64):
        surface = Surface(Mesh(*analytic.torus(2 * n, n, major, minor, twist)))
        _, v = analytic.torus_angles(2 * n, n, twist)
        tube = major + minor * np.cos(v.ravel())
        along = np.sin(v.ravel()) * major / tube**2 / minor
        errors["k1"].append(np.abs(surface.k1 - 1 / minor).max() * minor)
        errors["k2"].append(np.abs(surface.k2 - np.cos(v.ravel()) / tube).max() * minor)
        errors["c122"].append(np.abs(np.abs(surface.dcurv[:, 2]) - np.abs(along)).max() * minor**2)
        errors["c111"].append(np.abs(surface.dcurv[:, 0]).max() * minor**2)
    for name, values in errors.items():
        assert order(values) > 1.85, (name, values)
        assert values[-1] < 0.02, (name, values)


def test_ellipsoid_converges_where_the_mesh_is_regular() -> None:
    """Second order in the median; at the twelve corners of valence 5 an error stays that does not shrink."""
    errors = []
    for subdivisions in (3, 4, 5):
        vertices, faces = analytic.ellipsoid(subdivisions)
        surface = Surface(Mesh(vertices, faces))
        gauss, mean = analytic.ellipsoid_curvature(vertices)
        root = np.sqrt(np.maximum(mean**2 - gauss, 0))
        errors.append(float(np.median(np.abs(surface.k1 - mean - root) + np.abs(surface.k2 - mean + root))))
    assert order(errors) > 1.7
    assert errors[-1] < 4e-3


def test_monkey_saddle_converges_at_second_order() -> None:
    """Gaussian and mean curvature inside the patch, and the cubic form at its flat middle."""
    gauss_errors, cubic_errors = [], []
    for cells in (32, 64):
        vertices, faces = analytic.monkey_saddle(cells)
        surface = Surface(Mesh(vertices, faces))
        x, y = vertices[:, 0], vertices[:, 1]
        gauss = -36 * (x**2 + y**2) / (1 + 9 * (x**2 + y**2) ** 2) ** 2
        inside = (np.abs(x) < 0.35) & (np.abs(y) < 0.35)
        gauss_errors.append(float(np.sqrt(np.mean((surface.k1 * surface.k2 - gauss)[inside] ** 2))))
        middle = surface.dcurv[np.argmin(x**2 + y**2)]
        cubic_errors.append(abs(float(np.sqrt((middle**2) @ [1, 3, 3, 1])) - 12))
    assert order(gauss_errors) > 1.85
    assert order(cubic_errors) > 1.85
    assert cubic_errors[-1] < 1e-3


def test_inside_out_flips_curvature() -> None:
    vertices, faces = bumpy()
    outside, inside = Surface(Mesh(vertices, faces)), Surface(Mesh(vertices, faces[:, ::-1].copy()))
    agree(inside.normals, -outside.normals)
    agree(inside.k1, -outside.k1)
    agree(inside.k2, -outside.k2)


QUANTITIES = ("k1", "k2", "kr", "sc_num", "q1", "n_dot_v")


def of_view(view: View) -> dict[str, Floats]:
    surface = view.surface
    return {name: getattr(surface if name in ("k1", "k2") else view, name) for name in QUANTITIES}


def test_rotation_and_translation_change_nothing(view: View) -> None:
    rng = np.random.default_rng(3)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    shift = np.array([0.3, -0.2, 0.5])
    vertices, faces = bumpy()
    eye = rotation @ EYE + shift
    moved = View(Surface(Mesh(vertices @ rotation.T + shift, faces)), Camera((eye[0], eye[1], eye[2])))
    for name, value in of_view(moved).items():
        agree(value, of_view(view)[name], 1e-7)
    agree(moved.surface.normals, view.surface.normals @ rotation.T)
    assert moved.surface.feature_size == pytest.approx(view.surface.feature_size, rel=1e-9)


def test_scale_scales(view: View) -> None:
    factor = 1e-3
    vertices, faces = bumpy()
    small = View(Surface(Mesh(vertices * factor, faces)), Camera((EYE[0] * factor, EYE[1] * factor, EYE[2] * factor)))
    agree(small.surface.k1 * factor, view.surface.k1)
    agree(small.surface.dcurv * factor**2, view.surface.dcurv, 1e-7)
    agree(small.q1 * factor**2, view.q1)
    assert small.surface.feature_size == pytest.approx(view.surface.feature_size * factor, rel=1e-9)


def test_vertex_and_face_order_change_nothing(view: View) -> None:
    rng = np.random.default_rng(4)
    vertices, faces = bumpy()
    new_from_old = rng.permutation(len(vertices))
    shuffled = np.empty_like(vertices)
    shuffled[new_from_old] = vertices
    turned = np.stack([np.roll(face, rng.integers(3)) for face in new_from_old[faces]])
    other = seen((shuffled, turned[rng.permutation(len(faces))]))
    for name, value in of_view(other).items():
        agree(value[new_from_old], of_view(view)[name], 1e-9)
    assert other.surface.feature_size == pytest.approx(view.surface.feature_size, rel=1e-9)
