"""What making a view costs, stage by stage, and what the distances would cost the obvious ways."""

import resource
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial import cKDTree

from dataset_tools.candidates import draw_candidates
from dataset_tools.chamfer import chamfer_matrix, distance_field
from dataset_tools.settings import BuildConfig
from dataset_tools.views import camera_at, choose_azimuths
from dataset_tools.work import view_files
from ncmodel.geometry.surface import Surface
from ncmodel.geometry.view import View
from ncmodel.types import Floats, Mask, Mesh

TREE_PAIRS = 40
"""Pairs of drawings that the way by KD-trees is timed on; all of them would take minutes."""


@dataclass(frozen=True)
class ViewCost:
    """One view of a mesh, everything but cleaning.

    Attributes:
        faces: Of the mesh.
        cpu_seconds: Processor time of the whole, the shape's own stages included.
        stages: Stage -> seconds on the clock.
        output_bytes: Of the view's files.
        peak_bytes: Largest resident memory of this process so far.
    """

    faces: int
    cpu_seconds: float
    stages: dict[str, float]
    output_bytes: int
    peak_bytes: int


@dataclass(frozen=True)
class DistanceCost:
    """One way to compute all distances between a view's candidates.

    Attributes:
        way: Its name.
        cpu_seconds: Processor time, for all pairs.
        difference: Largest difference from the layered way, pixels; NaN where only some pairs were computed.
    """

    way: str
    cpu_seconds: float
    difference: float


def measure_view(mesh: Mesh, config: BuildConfig | None = None) -> ViewCost:
    """Make a view's files in memory. Run it once before, so that compiled code is loaded."""
    begin, surface = time.process_time(), Surface(mesh)
    files = view_files(surface, 0, config or BuildConfig())
    seconds = time.process_time() - begin
    # Kilobytes on Linux, bytes on macOS.
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    size = sum(len(data) for data in files.values())
    return ViewCost(len(mesh.faces), seconds, surface.trace.seconds(), size, peak)


def compare_distances(mesh: Mesh, config: BuildConfig | None = None) -> list[DistanceCost]:
    """Time the ways to the matrix of distances on one view's candidates."""
    config = config or BuildConfig()
    camera = camera_at(mesh, choose_azimuths(mesh.name, 1, config.seed)[0], (config.width, config.height))
    candidates = draw_candidates(View(Surface(mesh), camera), config.levels)
    masks = np.stack([candidates.masks[member].any(axis=0) for member in candidates.members])
    layered, seconds = _timed(lambda: chamfer_matrix(candidates.masks, candidates.members))
    costs = [DistanceCost("layers", seconds, 0.0)]
    for way, function in (("one product", by_product), ("transform a drawing", by_gathering)):
        matrix, seconds = _timed(partial(function, masks))
        costs.append(DistanceCost(way, seconds, float(np.abs(matrix - layered).max())))
    pairs = len(masks) * (len(masks) - 1) // 2
    distances, seconds = _timed(lambda: by_trees(masks, TREE_PAIRS))
    rows, columns = np.triu_indices(len(masks), 1)
    chosen = np.linspace(0, pairs - 1, TREE_PAIRS).astype(int)
    difference = float(np.abs(distances - layered[rows[chosen], columns[chosen]]).max())
    costs.append(DistanceCost("KD-tree a pair", seconds * pairs / TREE_PAIRS, difference))
    return costs


def by_product(masks: Mask) -> Floats:
    """A distance transform a drawing, all sums as one matrix product over the inked pixels. Drawings aren't empty."""
    inked = masks.any(axis=0)
    ink = masks[:, inked].astype(np.float32)
    fields = np.stack([distance_field(mask)[inked] for mask in masks])
    mean = (fields @ ink.T) / ink.sum(axis=1)
    return np.asarray((mean + mean.T) / 2, dtype=np.float64)


def by_gathering(masks: Mask) -> Floats:
    """A distance transform a drawing, its values gathered at every other drawing's pixels."""
    pixels = [np.flatnonzero(mask) for mask in masks]
    mean = np.array([[field[at].mean() for at in pixels] for field in (distance_field(m).ravel() for m in masks)])
    return np.asarray((mean + mean.T) / 2, dtype=np.float64)


def by_trees(masks: Mask, count: int) -> Floats:
    """(count,) distances of pairs spread over all, each by two KD-trees of its own."""
    rows, columns = np.triu_indices(len(masks), 1)
    chosen = np.linspace(0, len(rows) - 1, count).astype(int)
    return np.array([_by_tree(masks[rows[pair]], masks[columns[pair]]) for pair in chosen])


def _by_tree(a: Mask, b: Mask) -> float:
    one, other = np.argwhere(a), np.argwhere(b)
    forth, back = cKDTree(other).query(one)[0].mean(), cKDTree(one).query(other)[0].mean()
    return float(forth + back) / 2


def _timed(function: Callable[[], Floats]) -> tuple[Floats, float]:
    begin = time.process_time()
    result = function()
    return result, time.process_time() - begin
