"""What speed costs in accuracy: the same shapes drawn at every preset, each compared with the most accurate one."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from eval.metrics import Lines, compare_lines
from eval.raster import thin_lines
from ncmodel.draw import PRESETS, Drawing, draw
from ncmodel.types import Mesh

BEST = "accurate"
"""The preset that the others are compared with."""

NEAR = 1.0
"""Pixels up to which lines of two drawings count as the same."""

REPEATS = 3


@dataclass(frozen=True)
class Effort:
    """One shape drawn at one preset.

    Attributes:
        shape: Its name.
        preset: How finely it was drawn.
        seconds: Processor time from mesh to SVG, all threads together; the fastest of several runs.
        f1: Of its lines against the most accurate drawing's, within `NEAR`.
        chamfer: Symmetric distance to the most accurate drawing, pixels.
        strokes: Polylines in the drawing.
        kilobytes: Of the SVG.
    """

    shape: str
    preset: str
    seconds: float
    f1: float
    chamfer: float
    strokes: int
    kilobytes: float


def measure_presets(meshes: Sequence[Mesh], advance: Callable[[str], None]) -> list[Effort]:
    """Draw every mesh at every preset, all families of lines.

    Args:
        meshes: What to draw.
        advance: Called after each mesh.
    """
    found = []
    for mesh in meshes:
        draw(mesh, detail=PRESETS[BEST])  # compiles what is compiled on first use
        runs = {preset: _fastest(mesh, preset) for preset in PRESETS}
        best = _lines(runs[BEST][0])
        for preset, (drawing, seconds) in runs.items():
            measures = compare_lines(_lines(drawing), best, NEAR)
            size = len(drawing.svg()) / 1000.0
            found.append(Effort(mesh.name, preset, seconds, measures.f1, measures.chamfer, len(drawing.strokes), size))
        advance(mesh.name)
    return found


def mean_efforts(efforts: Sequence[Effort]) -> list[Effort]:
    """One row a preset: the means over shapes."""
    presets = dict.fromkeys(effort.preset for effort in efforts)
    rows = []
    for preset in presets:
        of = [effort for effort in efforts if effort.preset == preset]

        def mean(name: str, of: Sequence[Effort] = of) -> float:
            return math.fsum(getattr(effort, name) for effort in of) / len(of)

        strokes = round(mean("strokes"))
        rows.append(Effort("mean", preset, mean("seconds"), mean("f1"), mean("chamfer"), strokes, mean("kilobytes")))
    return rows


def _fastest(mesh: Mesh, preset: str) -> tuple[Drawing, float]:
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        drawing = draw(mesh, detail=PRESETS[preset])
        drawing.svg()
        times.append(time.process_time() - begin)
    return drawing, min(times)


def _lines(drawing: Drawing) -> Lines:
    return Lines.of(thin_lines(drawing.ink()))
