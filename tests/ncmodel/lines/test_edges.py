"""Borders, creases, closedness: by counting, and against a search through all pairs of faces."""

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.lines import edges
from ncmodel.lines.edges import Edges, bent_to
from ncmodel.mesh.weld import weld
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Ints, LineFamily, Mesh
from tests.helpers import analytic
from tests.helpers.dirty import joined


def brute_force(vertices: Floats, faces: Ints, angle: float) -> tuple[set[tuple[int, int]], set[frozenset[int]]]:
    """Directed sides without a twin, and edges with a pair of twins whose faces bend by more than `angle` degrees.

    A face and its copy turned over, back to back, are no such pair unless they are alone at the edge.
    """
    sides = [(int(f[c]), int(f[(c + 1) % 3]), n) for n, f in enumerate(faces) for c in range(3)]
    normals = np.cross(vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    boundary, sharp = set(), set()
    for i, j, f in sides:
        twins = [g for a, b, g in sides if (a, b) == (j, i)]
        if not twins:
            boundary.add((i, j))
        alone = sum({a, b} == {i, j} for a, b, _ in sides) == 2
        pairs = [g for g in twins if alone or set(faces[f]) != set(faces[g])]
        if any(normals[f] @ normals[g] < np.cos(np.radians(angle)) for g in pairs):
            sharp.add(frozenset((i, j)))
    return boundary, sharp


def found(surface: Surface, angle: float) -> tuple[set[tuple[int, int]], set[frozenset[int]]]:
    boundary = {(int(i), int(j)) for i, j in surface.boundary_edges.ends}
    creases = surface.creases(angle)
    sharp = {frozenset((int(i), int(j))) for i, j in creases.ends}
    assert len(sharp) == len(creases)
    return boundary, sharp


def tangle(seed: int) -> tuple[Floats, Ints]:
    """Random faces on few vertices: sides used by many faces, in both directions, faces repeated and turned."""
    rng = np.random.default_rng(seed)
    faces = np.array([rng.permutation(12)[:3] for _ in range(40)])
    return rng.normal(size=(12, 3)), faces


@pytest.mark.parametrize("seed", range(8))
def test_tangled_meshes(seed: int) -> None:
    vertices, faces = tangle(seed)
    surface = Surface(Mesh(vertices, faces))
    assert found(surface, 50.0) == brute_force(vertices, faces, 50.0)
    assert not surface.is_closed


@pytest.mark.parametrize("build", [analytic.cube, analytic.icosphere, analytic.torus, analytic.sphere])
def test_closed_meshes(build) -> None:  # type: ignore[no-untyped-def]
    surface = Surface(Mesh(*build()))
    assert surface.is_closed
    assert len(surface.boundary_edges) == 0


@pytest.mark.parametrize("cells", [1, 5])
def test_a_sheet_has_one_border(cells: int) -> None:
    surface = Surface(Mesh(*analytic.plane(cells)))
    assert not surface.is_closed
    assert len(surface.boundary_edges) == 4 * cells


def test_one_face_less_or_turned_opens_a_mesh() -> None:
    vertices, faces = analytic.icosphere(2)
    assert not Surface(Mesh(vertices, faces[1:])).is_closed
    turned = faces.copy()
    turned[7] = turned[7, ::-1]
    surface = Surface(Mesh(vertices, turned))
    assert not surface.is_closed
    assert len(surface.boundary_edges) == 6


def test_a_cube_has_twelve_creases() -> None:
    """Its faces' diagonals are none; every crease is 90 degrees."""
    surface = Surface(Mesh(*analytic.cube()))
    assert len(surface.creases()) == len(surface.creases(89.9)) == 12
    assert len(surface.creases(90.1)) == 0
    lines = surface.creases().lines(LineFamily.CREASES, surface.mesh.vertices)
    assert np.linalg.norm(lines.points[:, 1] - lines.points[:, 0], axis=1).tolist() == [1.0] * 12
    on_face = surface.mesh.faces[lines.face]
    ends = surface.creases().ends
    assert all(set(pair) < set(face) for pair, face in zip(ends.tolist(), on_face.tolist(), strict=True))


def test_a_hub_of_many_faces_takes_no_quadratic_time() -> None:
    """20000 faces round one vertex."""
    phi = np.linspace(0, 2 * np.pi, 20000, endpoint=False)
    n = np.arange(20000)
    vertices = np.concatenate([np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=1), [[0, 0, 0.1]]])
    surface = Surface(Mesh(vertices, np.stack([n, (n + 1) % 20000, np.full(20000, 20000)], axis=1)))
    assert len(surface.boundary_edges) == 20000
    assert len(surface.creases()) == 0


@pytest.mark.parametrize("pages", [2, 3000])
def test_a_book_of_many_pages_has_few_sides_at_its_spine(pages: int) -> None:
    phi = np.linspace(0, np.pi, pages)
    vertices = np.concatenate([[[0.0, 0, 0], [0, 0, 1]], np.stack([np.cos(phi), np.sin(phi), 0.5 + 0 * phi], axis=1)])
    book = Surface(Mesh(vertices, np.stack([np.zeros(pages, int), np.ones(pages, int), np.arange(pages) + 2], axis=1)))
    ends = book.boundary_edges.ends
    assert np.count_nonzero((ends == [0, 1]).all(axis=1)) == min(pages, edges.MOST_ALIKE)
    assert len(ends) == 2 * pages + min(pages, edges.MOST_ALIKE)
    assert len(book.creases()) == 0


def test_a_fan_of_faces_and_their_copies_turned_over_is_told_in_time() -> None:
    """20000 faces and copies round one vertex, of whose sides four each run along the spokes and two along the rim."""
    count = 20000
    phi, n = np.linspace(0, 2 * np.pi, count, endpoint=False), np.arange(count)
    vertices = np.concatenate([np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=1), [[0, 0, 1.0]]])
    fan = np.stack([n, (n + 1) % count, np.full(count, count)], axis=1)
    surface = Surface(Mesh(vertices, np.concatenate([fan, fan[:, ::-1]])))
    creases = surface.creases()
    assert len(surface.boundary_edges) == 0
    assert len(creases) == count
    assert (
        bent_to(creases.joined(Edges(fan[:, 1:], n)), vertices, surface.rings, np.array([0.0, 0, 5, 1]), 0.7).ends.max()
        < count
    )


def wall_in_a_box(welded: bool) -> Mesh:
    """A box whose sides have edges in the middle, where a wall within meets them."""
    halves = np.array([[x, y, z] for x in (-0.5, 0.0, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [[0, 1, 3, 2], [8, 10, 11, 9]]
    for k in (0, 4):
        quads += [
            [k, k + 4, k + 5, k + 1],
            [k + 2, k + 3, k + 7, k + 6],
            [k, k + 2, k + 6, k + 4],
            [k + 1, k + 5, k + 7, k + 3],
        ]
    wall = [[4, 5, 7, 6]] if welded else [[12, 13, 15, 14]]
    vertices = halves if welded else np.concatenate([halves, halves[4:8]])
    return Mesh(vertices, np.array([[q[0], q[i], q[i + 1]] for q in quads + wall for i in (1, 2)]))


@pytest.mark.parametrize("welded", [True, False])
def test_an_inner_wall_draws_no_line_on_the_flat_sides(welded: bool) -> None:
    surface = Surface(wall_in_a_box(welded))
    view = View(surface, Camera((1.3, 1.1, 2.4)))
    assert len(surface.boundary_edges) == (0 if welded else 4)
    for family, expected in ((LineFamily.BOUNDARIES, 0.0), (LineFamily.CREASES, 9.0)):
        seen = view.visible(family).points
        length = np.linalg.norm(seen[:, 1] - seen[:, 0], axis=1)
        on_wall = (np.abs(seen[..., 0]) < 1e-6).all(axis=1)
        assert length[on_wall].sum() < 0.002  # less than a pixel, at the corners
        assert length[~on_wall].sum() == pytest.approx(expected, rel=0.02)  # two corners are out of the picture


def test_a_wall_on_a_floor_has_its_line_from_its_side_alone() -> None:
    floor = np.array([[x, 0.0, z] for x in (-0.5, 0.0, 0.5) for z in (-0.5, 0.5)])
    vertices = np.concatenate([floor, floor[2:4] + (0.0, 0.4, 0.0)])
    faces = np.array([[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4], [2, 3, 7], [2, 7, 6]])
    for y, shown in ((1.0, 1.0), (-1.0, 0.0)):
        view = View(Surface(Mesh(vertices, faces)), Camera((1.5, y, 0.3)))
        points = np.concatenate([view.visible(family).points for family in (LineFamily.CREASES, LineFamily.BOUNDARIES)])
        foot = points[(np.abs(points[..., :2]) < 1e-9).all(axis=(1, 2))]
        length = np.linalg.norm(foot[:, 1] - foot[:, 0], axis=1)
        assert length.max(initial=0.0) == pytest.approx(shown, abs=0.01)


def test_boxes_that_touch_in_an_edge_have_that_edge_from_both_rooms() -> None:
    corners, quads = analytic.cube()
    mesh = Mesh(*weld(*joined((corners, quads), (corners + (1.0, 1.0, 0.0), quads))))
    for eye in ((3.0, -1.0, 2.0), (-1.0, 3.0, 2.0)):
        seen = View(Surface(mesh), Camera(eye)).visible(LineFamily.CREASES).points
        edge = seen[(np.abs(seen[..., :2] - 0.5) < 1e-9).all(axis=(1, 2))]
        assert np.linalg.norm(edge[:, 1] - edge[:, 0], axis=1).sum() == pytest.approx(1.0, abs=0.01)
