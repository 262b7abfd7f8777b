"""Where bodies pierce each other: against closed forms, and against bodies that only touch."""

from collections.abc import Sequence

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.geometry.crossing_faces import crossing_faces
from ncmodel.lines.intersections import LEAST_ANGLE
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mesh
from tests.helpers import analytic

Body = tuple[Floats, Ints]
TURNED = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
"""Any rotation: nothing is along the axes."""


def box(low: Sequence[float], high: Sequence[float]) -> Body:
    vertices, faces = analytic.cube(1.0)
    return np.asarray(low) + (vertices + 0.5) * (np.asarray(high) - np.asarray(low)), faces


def gridded(cells: int, size: float = 1.0) -> Body:
    """A square in z = 0 whose vertices lie on a regular grid."""
    return analytic.plane(cells, size)


def together(*bodies: Body, turn: Floats | None = None) -> Mesh:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in bodies)])
    vertices = np.concatenate([vertices for vertices, _ in bodies])
    faces = np.concatenate([faces + start for (_, faces), start in zip(bodies, starts, strict=False)])
    return Mesh(vertices if turn is None else vertices @ turn.T, faces)


def lines_of(mesh: Mesh) -> LineSet:
    return Surface(mesh).intersections


def length(lines: LineSet) -> float:
    return float(np.linalg.norm(lines.points[:, 1] - lines.points[:, 0], axis=1).sum())


@pytest.mark.parametrize("turn", [np.eye(3), TURNED])
def test_a_post_through_a_plate_has_a_line_on_both_sides(turn: Floats) -> None:
    plate, post = box((-1, -1, -0.1), (1, 1, 0.1)), box((-0.3, -0.2, -0.5), (0.4, 0.3, 0.5))
    lines = lines_of(together(plate, post, turn=turn))
    assert length(lines) == pytest.approx(2 * 2 * (0.7 + 0.5), rel=1e-9)
    assert np.allclose(np.abs((lines.points @ turn)[..., 2]), 0.1, atol=1e-12)


@pytest.mark.parametrize("offset", [0.0, 1e-8, 0.037])
@pytest.mark.parametrize("turn", [np.eye(3), TURNED])
def test_walls_along_the_edges_of_a_grid_pierce_it_all_the_same(turn: Floats, offset: float) -> None:
    """At offset 0 the post's walls pass through edges and vertices of the grid, and no face alone is on both sides."""
    post = box((-0.25 + offset, -0.25 + offset, -0.5), (0.25 + offset, 0.25 + offset, 0.5))
    assert length(lines_of(together(gridded(8), post, turn=turn))) == pytest.approx(2.0, rel=1e-6)


def test_a_snowman_has_a_circle() -> None:
    """Spheres of radius 1 and 0.7 at a distance of 1.3 meet in a circle of known radius and height."""
    body, head = analytic.icosphere(4, 1.0), analytic.icosphere(4, 0.7)
    height = (1.3**2 + 1.0 - 0.7**2) / (2 * 1.3)
    lines = lines_of(together(body, (head[0] + (0, 1.3, 0), head[1])))
    assert length(lines) == pytest.approx(2 * np.pi * np.sqrt(1 - height**2), rel=0.01)
    assert np.allclose(lines.points[..., 1], height, atol=0.01)


def test_a_part_that_pierces_itself_has_a_line() -> None:
    """A tube bent into a figure eight passes through itself."""
    tube, faces = analytic.cylinder(200, 24, 0.1, 2 * np.pi)
    t = tube[:, 1]
    middle = np.stack([np.sin(t), np.sin(2 * t) / 2, 0.05 * np.cos(t)], axis=1)
    along = np.stack([np.cos(t), np.cos(2 * t), -0.05 * np.sin(t)], axis=1)
    side = np.cross(along, (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    bent = middle + tube[:, :1] * side + tube[:, 2:] * (0.0, 0.0, 1.0)
    lines = lines_of(Mesh(bent, faces))
    assert length(lines) > 0.5
    assert np.abs(lines.points[..., :2]).max() < 0.25


TOUCHING = {
    "a box on a table": [box((-1, -1, -0.1), (1, 1, 0)), box((-0.3, -0.2, 0), (0.4, 0.3, 0.5))],
    "a box under a table": [box((-1, -1, -0.1), (1, 1, 0)), box((-0.3, -0.2, -0.6), (0.4, 0.3, -0.1))],
    "boxes side by side": [box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1))],
    "boxes that share an edge": [box((0, 0, 0), (1, 1, 1)), box((1, 1, 0), (2, 2, 1))],
    "a corner on a table": [
        box((-1, -1, -0.1), (1, 1, 0)),
        (box((0, 0, 0), (1, 1, 1))[0] @ TURNED.T, analytic.cube()[1]),
    ],
    "a wall under a roof": [gridded(4, 2.0), (gridded(4)[0][:, [0, 2, 1]] - (0, 0, 0.5), gridded(4)[1])],
    "a wall on a floor": [gridded(4, 2.0), (gridded(4)[0][:, [0, 2, 1]] + (0, 0, 0.5), gridded(4)[1])],
    "a box in a room": [box((-1, -1, 0), (1, 1, 2)), box((-0.3, -0.2, 0), (0.4, 0.3, 0.5))],
    "the same twice": [analytic.icosphere(2), analytic.icosphere(2)],
    "one within another": [analytic.icosphere(2), analytic.icosphere(2, 0.9)],
    "layers in one plane": [gridded(4), (gridded(5)[0] + (0.1, 0.2, 0), gridded(5)[1])],
    "layers that nearly coincide": [analytic.icosphere(3), analytic.sphere(20, 36)],
}


@pytest.mark.parametrize("turn", [np.eye(3), TURNED])
@pytest.mark.parametrize("case", TOUCHING)
def test_bodies_that_touch_have_no_line(case: str, turn: Floats) -> None:
    bodies = [(vertices.copy(), faces) for vertices, faces in TOUCHING[case]]
    if case == "a corner on a table":
        bodies[1][0][:, 2] -= bodies[1][0][:, 2].min()
    assert len(lines_of(together(*bodies, turn=turn))) == 0


def test_small_folds_of_a_scan_are_no_lines() -> None:
    vertices, faces = analytic.height_field(lambda x, y: 0.1 * np.cos(5 * x), 40)
    # One vertex is pushed through the faces beyond its neighbours.
    vertices[20 * 41 + 20, :2] += 0.06
    vertices[20 * 41 + 20, 2] -= 0.02
    rough = Surface(Mesh(vertices, faces))
    assert len(crossing_faces(rough.mesh.vertices, rough.faces, 1e-6, LEAST_ANGLE)) > 0
    assert len(rough.intersections) == 0


def test_only_what_the_eye_sees_is_drawn() -> None:
    plate, post = box((-1, -1, -0.1), (1, 1, 0.1)), box((-0.3, -0.2, -0.5), (0.4, 0.3, 0.5))
    mesh = together(plate, post)
    eye = np.array([2.0, 3.0, 6.0])
    seen = View(Surface(mesh), Camera(tuple(eye))).visible(LineFamily.INTERSECTIONS)
    assert length(seen) == pytest.approx(0.7 + 0.5, rel=0.01)  # on the upper side, the two walls turned to the eye
    assert (seen.points[..., 2] > 0).all()


def test_drawn_unasked_and_by_name() -> None:
    plate, post = box((-1, -1, -0.1), (1, 1, 0.1)), box((-0.3, -0.2, -0.5), (0.4, 0.3, 0.5))
    mesh = together(plate, post)
    for lines in (None, "intersections"):
        drawing = draw(mesh, lines=lines, size=200)
        assert any(stroke.family == "intersections" for stroke in drawing.strokes)
    apart = together(plate, box((-0.3, -0.2, 0.1), (0.4, 0.3, 0.5)))
    assert not any(stroke.family == "intersections" for stroke in draw(apart, size=200).strokes)
