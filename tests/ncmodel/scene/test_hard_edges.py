"""Surfaces of hard edges are told from sculpted ones, however coarsely either is made."""

import numpy as np
import pytest
import trimesh

from ncmodel.mesh.load import make_mesh
from ncmodel.scene.creases import split_at_creases
from ncmodel.scene.hard_edges import has_hard_edges
from ncmodel.scene.surface import CREASE_ANGLE, Surface


def surface_of(made: trimesh.Trimesh) -> Surface:
    return Surface(make_mesh(np.asarray(made.vertices), np.asarray(made.faces), "s"))


def carved(subdivisions: int, depth: float) -> Surface:
    """A ball as a knife leaves it: each vertex in or out by up to a share of the radius."""
    made = trimesh.creation.icosphere(subdivisions)
    vertices = made.vertices * (1.0 + depth * np.random.default_rng(0).uniform(-1.0, 1.0, (len(made.vertices), 1)))
    return Surface(make_mesh(vertices, np.asarray(made.faces), "s"))


@pytest.mark.parametrize("sections", [6, 8, 12, 16, 24, 64])
def test_cylinders_have_hard_edges_however_coarse(sections: int) -> None:
    assert has_hard_edges(surface_of(trimesh.creation.cylinder(1.0, 2.0, sections=sections)), CREASE_ANGLE)


def test_cones_and_boxes_have_hard_edges() -> None:
    assert has_hard_edges(surface_of(trimesh.creation.cone(1.0, 2.0, sections=16)), CREASE_ANGLE)
    assert has_hard_edges(surface_of(trimesh.creation.box()), CREASE_ANGLE)


@pytest.mark.parametrize(("subdivisions", "depth"), [(2, 0.1), (3, 0.06), (4, 0.03)])
def test_carved_balls_have_creases_but_no_hard_edges(subdivisions: int, depth: float) -> None:
    surface = carved(subdivisions, depth)
    assert len(surface.creases(CREASE_ANGLE)) > 20
    assert not has_hard_edges(surface, CREASE_ANGLE)


def test_a_smooth_surface_has_none() -> None:
    assert not has_hard_edges(surface_of(trimesh.creation.torus(1.0, 0.3, 64, 32)), CREASE_ANGLE)


def test_parted_or_whole_it_is_the_same() -> None:
    surface = surface_of(trimesh.creation.box())
    assert has_hard_edges(split_at_creases(surface, CREASE_ANGLE), CREASE_ANGLE)


def test_edges_of_three_faces_say_nothing() -> None:
    made = trimesh.creation.box()
    wall = np.array([[0, 1, 8]])
    vertices = np.vstack([made.vertices, [[5.0, 5.0, 5.0]]])
    surface = Surface(make_mesh(vertices, np.vstack([made.faces, wall]), "s"))
    assert has_hard_edges(surface, CREASE_ANGLE)
