"""What is scored is what is written: the picture that the ranking module judges is the drawing that `draw` makes."""

from collections.abc import Callable

import numpy as np
import pytest
import torch

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw_view
from ncmodel.drawing.plan import Plan
from ncmodel.mesh.load import make_mesh
from ncmodel.model.letterbox import Square
from ncmodel.model.maps import line_maps, network_maps
from ncmodel.model.predictor import SEEN_SIDE
from ncmodel.model.score import DrawingScore
from ncmodel.nets.presets import RankingDims
from ncmodel.nets.ranking import RankingModule
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, Floats, LineFamily, Thresholds
from tests.helpers import analytic

INK_TOLERANCE = 0.03
"""Ink that differs at the ranking module's resolution, as a share of the drawing's ink."""


def bumpy_torus() -> View:
    vertices, faces = analytic.torus(120, 60)
    bumps = 1 + 0.2 * np.sin(14 * vertices[:, :1]) * np.cos(11 * vertices[:, 2:])
    mesh = make_mesh(vertices * bumps, faces, "bumpy")
    return View(Surface(mesh), Camera.orbit(mesh.vertices, size=(SEEN_SIDE, SEEN_SIDE)))


def hills() -> View:
    def height(x: Floats, y: Floats) -> Floats:
        return np.asarray(0.1 * np.cos(9 * x) * np.cos(7 * y) + 0.05 * np.sin(16 * x + 3 * y))

    mesh = make_mesh(*analytic.height_field(height, cells=60), "hills")
    return View(Surface(mesh), Camera.orbit(mesh.vertices, elevation=40, size=(SEEN_SIDE, SEEN_SIDE)))


@pytest.mark.parametrize("make", [bumpy_torus, hills])
@pytest.mark.parametrize("share", [1.0, 0.6, 0.3, 0.05])
def test_what_is_scored_is_what_is_written(make: Callable[[], View], share: float) -> None:
    view = make()
    lines = line_maps(view)
    score = DrawingScore(RankingModule(RankingDims(size=192, width=2, blocks=(1, 1))), network_maps(view), lines)
    t = [score.fading[index].threshold(share) for index in range(4)]
    scored = score.drawings(torch.tensor([t], dtype=torch.float32), boundaries=True)[0, 0].numpy()
    values = {family.value: value for family, value in zip(FILTERED_FAMILIES, t, strict=True)}
    families = (LineFamily.CONTOURS, LineFamily.BOUNDARIES, *FILTERED_FAMILIES)
    ink = draw_view(view, Plan(families, Thresholds(unit="p90").with_values(**values))).ink()
    height, width = ink.shape
    written = Square(height, width, 192).fit(ink[None], 0.0)[0]
    assert written.sum() > 50
    assert np.abs(scored - written).sum() < INK_TOLERANCE * written.sum()
