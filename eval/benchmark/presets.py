"""What speed costs in accuracy: the same shapes drawn at every preset, each compared with the most accurate one.

Two things depend on the preset: how finely lines are worked out, and, with a trained model, how thoroughly the
thresholds are searched.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from eval.measures.metrics import compare_lines
from eval.measures.thinning import thin_lines
from ncmodel.chamfer import Lines
from ncmodel.drawing.draw import PRESETS, draw
from ncmodel.drawing.drawing import Drawing
from ncmodel.types import LineFamily, Mesh

if TYPE_CHECKING:
    from ncmodel.model.predictor import Model

BEST = "accurate"
"""The preset that the others are compared with."""

NEAR = 1.0
"""Pixels up to which lines of two drawings count as the same."""

REPEATS = 3
"""The fastest of this many runs counts; with a model, which takes longer, the only one."""

MEANS = ("seconds", "f1", "chamfer", "strokes", "kilobytes", "evaluations", "shortfall")


@dataclass(frozen=True)
class Effort:
    """One shape drawn at one preset.

    Attributes:
        shape: Its name.
        preset: How much effort.
        seconds: Processor time from mesh to SVG, all threads together.
        f1: Of its lines against the most accurate drawing's, within `NEAR`.
        chamfer: Symmetric distance to the most accurate drawing, pixels.
        strokes: Polylines in the drawing.
        kilobytes: Of the SVG.
        evaluations: Drawings that a model scored to choose thresholds; 0 without one.
        shortfall: How much lower the chosen drawing's score is than that of the most accurate drawing.
    """

    shape: str
    preset: str
    seconds: float
    f1: float
    chamfer: float
    strokes: float
    kilobytes: float
    evaluations: float = 0.0
    shortfall: float = 0.0


def measure_presets(
    meshes: Sequence[Mesh], advance: Callable[[str], None], model: "Model | None" = None
) -> list[Effort]:
    """Draw every mesh at every preset.

    Args:
        meshes: What to draw.
        advance: Called after each mesh.
        model: Chooses what is drawn; all families at rtsc's thresholds without one.
    """
    found: list[Effort] = []
    counts = model is not None and model.checkpoint.statistics is not None
    presets = [preset for preset in PRESETS if preset != "instant" or counts]  # without numbers it is a draft, or none
    for mesh in meshes:
        runs = {preset: _fastest(mesh, preset, model) for preset in presets}
        best, goal = _lines(runs[BEST][0]), runs[BEST][0].plan.score or 0.0
        for preset, (drawing, seconds) in runs.items():
            near = compare_lines(_lines(drawing), best, NEAR)
            plan, size = drawing.plan, len(drawing.svg()) / 1000.0
            sizes = (len(drawing.strokes), size, plan.evaluations, goal - (plan.score or 0.0))
            found.append(Effort(mesh.name, preset, seconds, near.f1, near.chamfer, *sizes))
        advance(mesh.name)
    return found


def mean_efforts(efforts: Sequence[Effort]) -> list[Effort]:
    """One row a preset: the means over shapes."""
    rows = []
    for preset in dict.fromkeys(effort.preset for effort in efforts):
        mine = [effort for effort in efforts if effort.preset == preset]
        means = (math.fsum(getattr(effort, name) for effort in mine) / len(mine) for name in MEANS)
        rows.append(Effort("mean", preset, *means))
    return rows


def _fastest(mesh: Mesh, preset: str, model: "Model | None") -> tuple[Drawing, float]:
    times = []
    for _ in range(1 if model else REPEATS):
        begin = time.process_time()
        drawing = draw(mesh, lines=None if model else tuple(LineFamily), model=model, preset=preset)
        drawing.svg()
        times.append(time.process_time() - begin)
    return drawing, min(times)


def _lines(drawing: Drawing) -> Lines:
    return Lines.of(thin_lines(drawing.ink()))
