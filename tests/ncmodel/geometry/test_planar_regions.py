"""Flats, and that no line of curvature lies on them."""

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.geometry.planar_regions import flat_faces
from ncmodel.scene.creases import split_at_creases
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, Floats, Ints, LineFamily, Mask, Mesh
from tests.helpers import analytic

SIDES, BANDS = 32, 6


def flats(mesh: Mesh) -> Mask:
    surface = Surface(mesh)
    return flat_faces(mesh.vertices, surface.faces, surface.rings)


def pill() -> Mesh:
    """A disc with an upper rim rounded by narrow bands and a sharp lower one; no vertex lies inside top and bottom."""
    turn = np.linspace(0, np.pi / 2, BANDS + 1)
    radius = np.append(0.4 + 0.1 * np.sin(turn), 0.5)
    height = np.append(0.1 * np.cos(turn), -0.1)
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    wobble = 1 + 0.2 * np.cos(3 * angle)
    rings = [
        np.stack([r * wobble * np.sin(angle), 0 * angle + h, r * wobble * np.cos(angle)], 1)
        for r, h in zip(radius, height, strict=True)
    ]
    i, j = np.arange(SIDES), np.roll(np.arange(SIDES), -1)
    low, high = 0, SIDES - 1
    top = []
    while high - low > 1:  # slivers from side to side
        top += [[low, low + 1, high], [low + 1, high - 1, high]]
        low, high = low + 1, high - 1
    cap = np.array([face for face in top if len(set(face)) == 3])
    walls = [
        np.concatenate([np.stack([i, i + SIDES, j + SIDES], 1), np.stack([i, j + SIDES, j], 1)]) + n * SIDES
        for n in range(len(rings) - 1)
    ]
    return Mesh(np.concatenate(rings), np.concatenate([cap, *walls, cap[:, ::-1] + (len(rings) - 1) * SIDES]))


def test_flats_are_told_from_what_surrounds_them() -> None:
    mesh = split_at_creases(Surface(pill()), 40.0).mesh
    heights = mesh.vertices[mesh.faces][:, :, 1]
    level = np.ptp(heights, axis=1) < 1e-9
    assert level.sum() == 2 * (SIDES - 2)
    np.testing.assert_array_equal(flats(mesh), level)


def test_a_plane_is_flat() -> None:
    assert flats(Mesh(*analytic.plane(4))).all()


@pytest.mark.parametrize("geometry", [analytic.icosphere(3), analytic.torus(32, 16), analytic.cylinder(8, 24)])
def test_facets_of_curved_surfaces_are_not(geometry: tuple[Floats, Ints]) -> None:
    assert not flats(Mesh(*geometry)).any()


@pytest.mark.parametrize("family", FILTERED_FAMILIES)
def test_lines_of_curvature_keep_off_flats(family: LineFamily) -> None:
    surface = split_at_creases(Surface(pill()), 40.0)
    view = View(surface, Camera((1.0, 1.2, 2.0)))
    every, kept = view.lines(family), view.candidates(family)
    flat = flat_faces(surface.mesh.vertices, surface.faces, surface.rings)
    assert not flat[kept.face].any()
    assert len(kept) == (~flat[every.face]).sum()
    if family is LineFamily.SUGGESTIVE:
        assert len(kept) < len(every)


def test_smooth_surfaces_are_not_searched_for_flats() -> None:
    view = View(Surface(Mesh(*analytic.torus(32, 16))), Camera((1.0, 1.2, 2.0)))
    view.visible(LineFamily.SUGGESTIVE)
    assert "flat_faces" not in view.trace.seconds()
