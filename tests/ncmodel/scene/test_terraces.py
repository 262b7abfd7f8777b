"""Height maps rounded to levels are drawn as what they were before; real steps and everything else stay as they are."""

import numpy as np
import pytest

from ncmodel.drawing.draw import draw
from ncmodel.drawing.drawing import Drawing
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.surface import Surface
from ncmodel.scene.terraces import without_terraces
from ncmodel.types import Floats, Mesh
from tests.helpers import analytic
from tests.helpers.analytic import grid_faces
from tests.helpers.dirty import joined, moved

SIDE = 128
X, Z = np.meshgrid(np.linspace(0.0, 1.0, SIDE), np.linspace(0.0, 1.0, SIDE), indexing="ij")
HILLS = (np.sin(5.0 * X) * np.cos(4.0 * Z) + 0.8 * np.sin(9.0 * X + 7.0 * Z) + 2.0) / 4.0
ROW, COLUMN = np.indices((SIDE, SIDE))
TURN = np.linalg.qr(np.array([[3.0, 1.0, 2.0], [-1.0, 4.0, 1.0], [2.0, -2.0, 5.0]]))[0]


def terrain(heights: Floats) -> Mesh:
    """Heights above a square of side 1."""
    vertices = np.stack([X.ravel(), heights.ravel(), Z.ravel()], axis=1)
    return Mesh(vertices, grid_faces(SIDE, SIDE))


def smoothed(mesh: Mesh) -> Mesh:
    return without_terraces(Surface(mesh)).mesh


def measured(drawing: Drawing) -> tuple[int, float]:
    """How many strokes, and how long they are together."""
    lengths = [np.linalg.norm(np.diff(stroke.points, axis=0), axis=1).sum() for stroke in drawing.strokes]
    return len(lengths), float(sum(lengths))


@pytest.mark.parametrize(("levels", "relief"), [(255, 0.2), (64, 0.2), (30, 0.1)])
def test_a_rounded_terrain_is_drawn_nearly_as_it_was(levels: int, relief: float) -> None:
    before, length_before = measured(draw(terrain(relief * HILLS), size=384))
    rounded = np.round(levels * HILLS) * relief / levels
    drawing = draw(terrain(rounded), size=384)
    count, length = measured(drawing)
    assert count <= 3 * before
    assert abs(length / length_before - 1.0) < 0.5
    assert any("smoothed heights that were rounded to" in note for note in drawing.notes)
    raw, _ = measured(draw(Surface(terrain(rounded)), size=384))
    assert raw > 2 * count


@pytest.mark.parametrize(
    ("turn", "scale", "decimals"),
    [(np.eye(3), 1.0, 12), (np.eye(3)[[2, 0, 1]], 30.0, 4), (TURN, 1.0, 12), (TURN, 1000.0, 3)],
)
def test_any_turn_scale_and_file_will_do(turn: Floats, scale: float, decimals: int) -> None:
    mesh = terrain(np.round(100.0 * HILLS) * 0.002)
    turned = make_mesh(np.round(scale * mesh.vertices @ turn.T, decimals).astype(np.float32), mesh.faces)
    level = 0.002 / np.ptp(scale * mesh.vertices @ turn.T, axis=0).max() * scale
    result = smoothed(turned)
    assert "smoothed heights that were rounded to 81 levels" in result.notes[0]
    off = np.linalg.norm(result.vertices - turned.vertices, axis=1)
    assert 0.3 * level < off.max() < 1.01 * level
    wanted = (0.2 * HILLS.ravel() - mesh.vertices[:, 1]) / 0.002
    inside = np.ravel((np.minimum(ROW, COLUMN) > 3) & (np.maximum(ROW, COLUMN) < SIDE - 4))
    found = (result.vertices - turned.vertices) @ (turn @ [0.0, 1.0, 0.0]) / level
    # Nearer to what was rounded than rounding left it, which is off by 0.29 levels in the mean.
    assert np.sqrt(np.mean((found - wanted)[inside] ** 2)) < 0.25


def test_a_solid_keeps_its_base() -> None:
    top, base = terrain(np.round(100.0 * HILLS) * 0.002 + 0.0317), terrain(np.zeros((SIDE, SIDE)))
    solid = make_mesh(*joined((top.vertices, top.faces), (base.vertices, base.faces[:, ::-1])))
    result = smoothed(solid)
    change = np.abs(result.vertices - solid.vertices)[:, 1] > 0.0
    assert change[: SIDE**2].any()
    assert not change[SIDE**2 :].any()


EDGE = np.minimum.reduce([ROW, COLUMN, SIDE - 1 - ROW, SIDE - 1 - COLUMN])
BLOCKS = np.random.default_rng(0).integers(0, 14, (16, 16)).repeat(8, axis=0).repeat(8, axis=1)


@pytest.mark.parametrize(
    "steps",
    [EDGE // 4, EDGE // 4 * 3, EDGE // 2, ROW // 5, ROW // 5 * 4, BLOCKS, 7 * BLOCKS],
    ids=["pyramid", "steep pyramid", "fine pyramid", "ramp", "stairs", "low houses", "towers"],
)
def test_real_steps_stay(steps: Floats) -> None:
    mesh = terrain(steps / 256.0)
    assert smoothed(mesh) is mesh


@pytest.mark.parametrize(
    "mesh",
    [
        terrain(0.2 * HILLS),
        make_mesh(*analytic.torus()),
        make_mesh(*analytic.sphere()),
        make_mesh(np.round(analytic.icosphere(5)[0], 2), analytic.icosphere(5)[1]),
        make_mesh(*joined(analytic.plane(48), moved(analytic.torus(), (0.0, 0.3, 0.0)))),
    ],
    ids=["terrain", "torus", "sphere", "sphere of two decimals", "plate"],
)
def test_everything_else_stays(mesh: Mesh) -> None:
    assert smoothed(mesh) is mesh
