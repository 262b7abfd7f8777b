"""Borders that touch are sewn: seams apart by rounding, T-junctions, patches and tiles that follow one curve."""

from collections.abc import Callable

import numpy as np
import pytest

from ncmodel.drawing.draw import draw
from ncmodel.scene.seams import sew_seams
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Ints, Mesh
from tests.helpers import analytic

Patch = tuple[Floats, Ints]


def grid(columns: int, rows: int, place: Callable[[Floats, Floats], list[Floats]]) -> Patch:
    """A patch of parameters u and v from 0 to 1."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1), indexing="ij")
    number = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.stack(place(u.ravel(), v.ravel()), axis=1), faces


def together(*patches: Patch) -> Mesh:
    counts = np.cumsum([0, *(len(vertices) for vertices, _ in patches)])
    vertices = np.concatenate([vertices for vertices, _ in patches])
    return Mesh(vertices, np.concatenate([faces + n for (_, faces), n in zip(patches, counts, strict=False)]))


def border_length(mesh: Mesh) -> float:
    a, b = mesh.vertices[Surface(mesh).boundary_edges.ends].transpose(1, 0, 2)
    return float(np.linalg.norm(b - a, axis=1).sum())


def tube(count: int, start: float, end: float, phase: float = 0.0, radius: float = 0.4) -> Patch:
    """An open tube of `count` sides round y."""

    def place(u: Floats, v: Floats) -> list[Floats]:
        angle = -2 * np.pi * (u + phase)
        return [radius * np.cos(angle), start + (end - start) * v, radius * np.sin(angle)]

    return grid(count, 6, place)


@pytest.mark.parametrize("gap", [1e-16, 1e-12, 1e-9, 1e-7, 1e-6, 5e-5])
def test_halves_apart_by_rounding_are_one(gap: float) -> None:
    vertices, faces = analytic.torus()
    right = vertices[faces].mean(axis=1)[:, 0] > 0
    moved = np.concatenate([vertices + [gap, gap / 3, 0], vertices - [gap, 0, 0]])
    whole = sew_seams(Surface(Mesh(moved, np.where(right[:, None], faces, faces + len(vertices)))))
    assert whole.is_closed
    assert len(whole.mesh.faces) == len(faces)


def test_a_vertex_on_another_edge_is_taken_into_it() -> None:
    """A cube of which one side has four squares, the others one: T-junctions at four edges."""
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    quads = [[0, 1, 3, 2], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([triangle for a, b, c, d in quads for triangle in ([a, b, c], [a, c, d])])
    fine = grid(2, 2, lambda u, v: [np.ones_like(u), u, v])
    mesh = together((corners, faces), fine)
    assert border_length(mesh) == pytest.approx(8.0)
    whole = sew_seams(Surface(mesh))
    assert whole.is_closed
    assert len(whole.mesh.faces) == len(mesh.faces) + 4
    assert whole.mesh.notes[-1] == "sewed seams: border edges split at 4 vertices that touch them"
    drawing = draw(mesh, size=(200, 200))
    assert {stroke.family for stroke in drawing.strokes} == {"creases"}


@pytest.mark.parametrize(("count", "phase"), [(24, 0.5 / 24), (36, 0.0), (35, 0.003), (25, 0.0), (48, 0.0), (13, 0.01)])
def test_tubes_that_meet_in_a_circle_are_one(count: int, phase: float) -> None:
    mesh = together(tube(24, -0.5, 0.0), tube(count, 0.0, 0.5, phase))
    whole = sew_seams(Surface(mesh)).mesh
    rims = sum(n * 0.8 * np.sin(np.pi / n) for n in (24, count))
    assert border_length(whole) == pytest.approx(rims, rel=1e-6)


@pytest.mark.parametrize("roughness", [0.0, 0.004])
@pytest.mark.parametrize("coarser", [2, 4, 3])
def test_tiles_of_terrain_have_no_borders_between_them(coarser: int, roughness: float) -> None:
    def height(x: Floats, z: Floats) -> Floats:
        rough = roughness * np.sin(91.0 * x + 57.0 * z) * np.cos(37.0 * x - 83.0 * z)
        return 0.1 * np.sin(5 * x) * np.cos(7 * z) + rough

    def tile(x: float, z: float, count: int) -> Patch:
        def place(u: Floats, v: Floats) -> list[Floats]:
            return [x + u / 2, height(x + u / 2, z + v / 2), z + v / 2]

        return grid(count, count, place)

    mesh = together(
        tile(-0.5, -0.5, 24), tile(0.0, -0.5, 24 // coarser), tile(-0.5, 0.0, 24 // coarser), tile(0, 0, 24)
    )
    whole = sew_seams(Surface(mesh)).mesh
    ends = Surface(whole).boundary_edges.ends
    assert (np.abs(whole.vertices[ends][:, :, ::2]).max(axis=2) > 0.4999).all()


def test_a_slit_stays_open() -> None:
    vertices, faces = analytic.sphere()
    middle = vertices[faces].mean(axis=1)
    slit = (np.abs(middle[:, 1]) < 0.1 * np.ptp(vertices)) & (middle[:, 2] > 0)
    surface = Surface(Mesh(vertices, faces[~slit]))
    assert len(surface.boundary_edges) > 10
    assert sew_seams(surface) is surface


def test_tubes_apart_or_in_each_other_keep_their_rims() -> None:
    rim = 24 * 0.8 * np.sin(np.pi / 24)
    apart = together(tube(24, -0.5, -0.005), tube(24, 0.005, 0.5))
    assert border_length(sew_seams(Surface(apart)).mesh) == pytest.approx(4 * rim)
    nested = together(tube(24, -0.5, 0.5), tube(24, -0.5, 0.5, 0.01, radius=0.38))
    assert border_length(sew_seams(Surface(nested)).mesh) == pytest.approx(2 * rim * (1 + 0.38 / 0.4))


def test_seams_of_wound_otherwise_patches_are_found_once_the_edges_are_shared() -> None:
    """What is wound differently is no border: such edges aren't taken for open ones."""
    vertices, faces = analytic.sphere()
    turned = np.where((vertices[faces].mean(axis=1)[:, 0] > 0)[:, None], faces[:, ::-1], faces)
    surface = Surface(Mesh(vertices, turned))
    assert sew_seams(surface) is surface


@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_tolerances_follow_the_size(scale: float) -> None:
    mesh = together(tube(24, -0.5, 0.0), tube(36, 0.0, 0.5))
    whole = sew_seams(Surface(mesh)).mesh
    scaled = sew_seams(Surface(Mesh(mesh.vertices * scale, mesh.faces))).mesh
    np.testing.assert_array_equal(scaled.faces, whole.faces)
