"""Drawings as an illustrator makes them: each line once and in one stroke, the same at any size."""

import numpy as np
import pytest
from scipy.ndimage import binary_dilation, binary_erosion
from scipy.spatial import cKDTree

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw, draw_view
from ncmodel.drawing.drawing import Drawing
from ncmodel.drawing.plan import Plan
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, LineFamily, Stroke, Thresholds
from tests.helpers import analytic


@pytest.fixture(scope="module")
def pebble() -> Surface:
    """A smooth shape with a waist: lines of several families run along its outline."""
    vertices, faces = analytic.icosphere(5)
    x, y, z = vertices.T
    waist = 1.0 - 0.35 * np.exp(-30.0 * y**2) + 0.03 * np.sin(9.0 * x) * np.cos(7.0 * z)
    return Surface(make_mesh(vertices * np.stack([0.6 * waist, np.ones_like(y), 0.6 * waist], axis=1), faces))


def samples(strokes: tuple[Stroke, ...]) -> Floats:
    """(N, 2) points at most half a pixel apart."""
    parts = []
    for stroke in strokes:
        steps = np.linalg.norm(np.diff(stroke.points, axis=0), axis=1)
        at = np.concatenate([[0.0], np.cumsum(steps)])
        place = np.linspace(0.0, at[-1], max(int(2 * at[-1]), 2))
        parts.append(np.stack([np.interp(place, at, column) for column in stroke.points.T], axis=1))
    return np.concatenate(parts)


def doubled(drawing: Drawing) -> float:
    """The share of lines of curvature within 2.5 pixels of a contour."""
    contours = samples(tuple(s for s in drawing.strokes if s.family == "contours"))
    others = samples(tuple(s for s in drawing.strokes if s.family != "contours"))
    return float((cKDTree(contours).query(others)[0] < 2.5).mean())


def test_lines_along_the_outline_are_drawn_once(pebble: Surface) -> None:
    found, drawn = draw(pebble, thresholds=Thresholds()), draw(pebble)
    assert doubled(found) > 0.5
    assert doubled(drawn) < 0.15
    assert len(drawn.strokes) < 0.4 * len(found.strokes)
    # No place is left blank: what was drawn has ink still, or was a crumb.
    off = cKDTree(samples(drawn.strokes)).query(samples(found.strokes))[0]
    assert (off < 3.5).mean() > 0.92


@pytest.mark.parametrize("size", [384, 1536])
def test_the_same_lines_are_drawn_at_any_size(pebble: Surface, size: int) -> None:
    usual, other = draw(pebble), draw(pebble, size=size)
    there, here = samples(usual.strokes), samples(other.strokes) * 768.0 / size
    assert (cKDTree(there).query(here)[0] < 3.5).mean() > 0.97
    assert (cKDTree(here).query(there)[0] < 3.5).mean() > 0.97


def test_drawing_twice_gives_the_same(pebble: Surface) -> None:
    assert draw(pebble).svg() == draw(Surface(pebble.mesh)).svg()


def test_who_names_families_gets_short_lines_too(pebble: Surface) -> None:
    families = "contours,boundaries,creases,suggestive,apparent"
    assert len(draw(pebble, lines=families).strokes) > len(draw(pebble).strokes)


def shelf(boards: int, thickness: float) -> Surface:
    """Thin boards between two thin sides, each a box of its own."""
    box, faces = analytic.cube()
    low, size = box.min(axis=0), np.ptp(box, axis=0)
    places = [((side, 0.0, 0.0), (thickness, 2.0, 0.6)) for side in (0.0, 1.0)]
    places += [((0.0, height, 0.0), (1.0 + thickness, thickness, 0.6)) for height in np.linspace(0.0, 1.9, boards)]
    vertices = [(box - low) / size * np.array(extent) + np.array(corner) for corner, extent in places]
    numbered = [faces + number * len(box) for number in range(len(places))]
    return Surface(make_mesh(np.concatenate(vertices), np.concatenate(numbered)))


def test_the_outline_of_thin_boards_is_whole() -> None:
    surface = shelf(6, 0.012)
    drawn = draw(surface, azimuth=87.0, elevation=12.0, size=512)
    hit = np.pad(surface.scene.render(drawn.camera).hit, 1)
    row, column = np.nonzero(hit & ~binary_erosion(hit))
    off = cKDTree(samples(drawn.strokes)).query(np.stack([column - 0.5, row - 0.5], axis=1))[0]
    assert off.max() < 2.0


def test_a_rim_that_is_outline_is_drawn_though_boundaries_are_not() -> None:
    """A bowl, upside down: below, its outline is its rim."""
    vertices, faces = analytic.icosphere(4)
    upper = vertices[faces].mean(axis=1)[:, 1] > 0.0
    view = View(Surface(make_mesh(vertices, faces[upper])), Camera.orbit(vertices, elevation=-25.0, size=(256, 256)))
    closed, left_open = (
        draw_view(view, Plan((LineFamily.CONTOURS,), finished=True, rims=rims)) for rims in (True, False)
    )
    edge = np.argwhere(binary_dilation(view.buffers.hit) & ~view.buffers.hit)[:, ::-1] + 0.5
    near = [cKDTree(samples(drawing.strokes)).query(edge)[0] < 3.0 for drawing in (closed, left_open)]
    assert near[0].mean() > 0.99
    assert near[1].mean() < 0.75
    whole = draw_view(view, Plan((LineFamily.CONTOURS, LineFamily.BOUNDARIES), finished=True, rims=True))
    assert len(samples(closed.strokes)) < 0.9 * len(samples(whole.strokes))  # not the rim's far side, which is inside
