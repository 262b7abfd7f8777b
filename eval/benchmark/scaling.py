"""How long the geometry takes from ten thousand to millions of faces, stage by stage, and how that grows."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dataset_tools.simulation.shapes import bumpy_torus
from ncmodel.camera import Camera
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import LineFamily, Mesh

SIZES = (10_000, 30_000, 100_000, 300_000)
LARGE_SIZES = (1_000_000, 2_000_000)
"""Face counts; the large ones take minutes and up to 4 GB."""

REPEATS = 10
IN_PICTURES = ("rays", "hidden lines", "shading")
"""What the fastest of `REPEATS` runs counts for, each with a new surface and view; for the stages that work on pictures
and take longer than all others together, of two. A first run also pays for memory that the process hasn't had yet."""

CLASSIC: Mapping[str, Mapping[int, float]] = {
    "normals": {100_000: 6.0, 1_000_000: 66.0},
    "point areas": {100_000: 2.2, 1_000_000: 27.0},
    "curvature": {100_000: 28.0, 1_000_000: 272.0},
    "derivative": {100_000: 49.0, 1_000_000: 466.0},
    "per view": {100_000: 4.0, 1_000_000: 27.0},
    "extraction": {100_000: 2.3, 1_000_000: 32.0},
}
"""Milliseconds that the classic C++ program takes for the same stages on one thread of the same kind of machine."""

EXTRACTED = (
    LineFamily.CONTOURS,
    LineFamily.SUGGESTIVE,
    LineFamily.RIDGES,
    LineFamily.VALLEYS,
    LineFamily.APPARENT,
)


@dataclass(frozen=True)
class Scaling:
    """Times of one stage.

    Attributes:
        stage: What was timed.
        milliseconds: Faces -> processor time, all threads together.
    """

    stage: str
    milliseconds: Mapping[int, float]

    @property
    def exponent(self) -> float:
        """The p of time ~ faces^p, by least squares over the sizes; 1 is linear growth; NaN for one size."""
        if len(self.milliseconds) < 2:
            return math.nan
        faces, times = (np.log(list(values)) for values in (self.milliseconds.keys(), self.milliseconds.values()))
        return float(np.polyfit(faces, times, 1)[0])


def stages(surface: Surface, view: View) -> dict[str, Callable[[], object]]:
    """What is timed, in an order in which each stage finds what it needs ready."""
    return {
        "normals": lambda: surface.normals,
        "point areas": lambda: surface.point_areas,
        "curvature": lambda: surface.curvature,
        "derivative": lambda: surface.dcurv,
        "feature size": lambda: surface.feature_size,
        "corners by vertex": lambda: surface.rings,
        "per view": lambda: (view.n_dot_v, view.kr, view.sc_num, view.q1, view.dt1q1),
        "extraction": lambda: [view.lines(family) for family in EXTRACTED],
        "rays": lambda: view.buffers,
        "hidden lines": lambda: [view.visible(family) for family in EXTRACTED],
        "shading": lambda: view.shaded,
    }


def measure_scaling(sizes: Sequence[int], advance: Callable[[str], None]) -> list[Scaling]:
    """Time every stage at every size.

    Args:
        sizes: Face counts.
        advance: Called after each size.
    """
    _time_once(bumpy_torus(2_000))  # compiles what is compiled on first use
    found: dict[str, dict[int, float]] = {}
    for size in sizes:
        mesh = bumpy_torus(size)
        for stage, milliseconds in _fastest(mesh).items():
            found.setdefault(stage, {})[len(mesh.faces)] = milliseconds
        advance(f"{len(mesh.faces):,} faces")
    return [Scaling(stage, milliseconds) for stage, milliseconds in found.items()]


def _fastest(mesh: Mesh) -> dict[str, float]:
    runs = [_time_once(mesh, IN_PICTURES if repeat >= 2 else ()) for repeat in range(REPEATS)]
    return {stage: min(run[stage] for run in runs if stage in run) for stage in runs[0]}


def _time_once(mesh: Mesh, left_out: Sequence[str] = ()) -> dict[str, float]:
    surface = Surface(mesh)
    view = View(surface, Camera.orbit(mesh.vertices))
    times = {}
    for name, compute in stages(surface, view).items():
        if name in left_out:
            continue
        begin = time.process_time()
        compute()
        times[name] = 1000.0 * (time.process_time() - begin)
    return times
