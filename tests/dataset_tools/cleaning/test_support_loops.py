"""Vertices beside hard edges: flat faces stay flat up to their edges, and nothing moves."""

import numpy as np
import pytest

from dataset_tools.cleaning.support_loops import support_hard_edges
from ncmodel.scene.surface import Surface
from ncmodel.types import Floats, Ints, Mesh
from tests.helpers import analytic, dirty

STEP = 0.01


def areas(vertices: Floats, faces: Ints) -> Floats:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1)) / 2


def test_a_box_keeps_its_shape_and_gets_flat_sides() -> None:
    vertices, faces = dirty.box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
    points, parts = support_hard_edges(vertices, faces, STEP)
    assert points[: len(vertices)].tolist() == vertices.tolist()
    assert dirty.is_closed(parts)
    assert dirty.signed_volume(points, parts) == pytest.approx(1.0)
    assert areas(points, parts).sum() == pytest.approx(6.0)
    assert (areas(points, parts) > 0).all()
    # All new vertices lie on one side of the box, and their normals are that side's.
    new = points[len(vertices) :]
    normals = Surface(Mesh(points, parts)).normals[len(vertices) :]
    inner = (np.abs(new) > 0.5 - 1e-9).sum(axis=1) == 1
    assert inner.sum() >= 24
    aligned = np.abs(normals[inner]).max(axis=1)
    assert aligned == pytest.approx(np.ones(len(aligned)), abs=1e-9)


def test_the_step_is_kept() -> None:
    vertices, faces = dirty.box()
    points, _ = support_hard_edges(vertices, faces, STEP)
    new = points[len(vertices) :]
    to_side = np.minimum(new, 1 - new)
    nearest_edge = np.sort(to_side, axis=1)[:, 1]
    # A step along the diagonal of a side is 0.7 steps from the edge.
    assert nearest_edge.min() == pytest.approx(STEP / np.sqrt(2))
    assert nearest_edge.max() <= STEP * 1.001


@pytest.mark.parametrize(
    "part",
    [analytic.icosphere(3), analytic.torus(48, 24), dirty.hemisphere(), dirty.with_seam(3, 3)],
    ids=["sphere", "torus", "bowl", "flat"],
)
def test_rounded_shapes_and_flat_ones_are_left_alone(part: dirty.Geometry) -> None:
    vertices, faces = part
    points, parts = support_hard_edges(vertices, faces, STEP)
    assert points is vertices
    assert parts is faces


def test_a_coarse_rounded_shape_is_not_taken_for_a_machine() -> None:
    vertices, faces = analytic.icosphere(0)  # an icosahedron bends by 42 degrees everywhere
    assert support_hard_edges(vertices, faces, STEP)[1] is faces


def test_fine_parts_are_left_alone_where_there_is_no_room() -> None:
    vertices, faces = dirty.box()
    points, parts = support_hard_edges(vertices * 2 * STEP, faces, STEP)
    assert len(parts) == len(faces)
    assert len(points) == len(vertices)


def test_faces_away_from_hard_edges_keep_their_order() -> None:
    ball = dirty.sphere(0.5, (3, 0, 0))
    vertices, faces = dirty.joined(ball, dirty.box())
    _, parts = support_hard_edges(vertices, faces, STEP)
    assert parts[: len(ball[1])].tolist() == ball[1].tolist()
    assert len(parts) > len(faces)


def test_a_prism_of_many_sides_stays_closed() -> None:
    sides = 40
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    bottom, top = np.insert(ring, 1, 0.0, axis=1), np.insert(ring, 1, 1.0, axis=1)
    vertices = np.concatenate([bottom, top])
    i, j = np.arange(sides), (np.arange(sides) + 1) % sides
    walls = np.concatenate([np.stack([i, sides + i, j], 1), np.stack([j, sides + i, sides + j], 1)])
    fan = np.arange(1, sides - 1)
    caps = [np.stack([0 * fan, fan, fan + 1], 1), np.stack([0 * fan, fan + 1, fan], 1) + sides]
    faces = np.concatenate([walls, *caps])
    assert dirty.is_closed(faces)
    points, parts = support_hard_edges(vertices, faces, STEP)
    assert dirty.is_closed(parts)
    assert dirty.signed_volume(points, parts) == pytest.approx(dirty.signed_volume(vertices, faces))
    assert areas(points, parts).sum() == pytest.approx(areas(vertices, faces).sum())


def cut_at_random(part: dirty.Geometry, cuts: int, seed: int) -> dirty.Geometry:
    """The same surface, faces chosen at random cut in three, some of the new corners close to an old one."""
    rng = np.random.default_rng(seed)
    points, triangles = list(part[0]), [tuple(face) for face in part[1]]
    for _ in range(cuts):
        a, b, c = triangles.pop(int(rng.integers(len(triangles))))
        share = rng.dirichlet((0.3, 0.3, 0.3)).clip(0.01)
        points.append(np.asarray(share / share.sum() @ np.array([points[a], points[b], points[c]])))
        new = len(points) - 1
        triangles += [(a, b, new), (b, c, new), (c, a, new)]
    return np.array(points), np.array(triangles)


@pytest.mark.parametrize("seed", range(8))
def test_no_crack_opens_where_only_one_side_of_an_edge_has_room(seed: int) -> None:
    vertices, faces = cut_at_random(dirty.box(), 40, seed)
    assert dirty.is_closed(faces)
    points, parts = support_hard_edges(vertices, faces, STEP)
    assert len(points) > len(vertices)
    assert dirty.is_closed(parts)
    assert dirty.signed_volume(points, parts) == pytest.approx(1.0)
    assert areas(points, parts).sum() == pytest.approx(6.0)
