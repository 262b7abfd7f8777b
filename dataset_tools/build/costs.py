"""What the data set costs: a view by stage, its distances the obvious ways, and a build with more workers."""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.spatial import cKDTree

from dataset_tools.build.build import build_dataset
from dataset_tools.build.config import BuildConfig
from dataset_tools.build.mesh_files import find_sources
from dataset_tools.build.runners import runner_for
from dataset_tools.build.tasks import view_files
from dataset_tools.build.worker_process import WorkerProcess
from dataset_tools.candidates.candidates import draw_candidates
from dataset_tools.candidates.viewpoints import camera_at, choose_azimuths
from ncmodel.chamfer import chamfer_matrix, distance_to
from ncmodel.processes import peak_memory
from ncmodel.readers.ply import ply_bytes
from ncmodel.report.part import Part
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Mask, Mesh

TREE_PAIRS = 40
"""Pairs of drawings that the way by KD-trees is timed on; all of them would take minutes."""

VIEW_FACES = 50_000
BUILD_SHAPES = 12
"""Sizes of what `ncontours bench` measures."""

STEPS = 4
"""How often `dataset_parts` says that it is getting on."""

REPEATS = 3
"""The fastest run of a view counts."""


@dataclass(frozen=True)
class ViewCost:
    """One view of a mesh, everything but cleaning.

    Attributes:
        faces: Of the mesh.
        cpu_seconds: Processor time of the whole, the shape's own stages included.
        stages: Stage -> seconds on the clock.
        output_bytes: Of the view's files.
        peak_bytes: Largest resident memory of a process that makes this view and nothing else.
    """

    faces: int
    cpu_seconds: float
    stages: dict[str, float]
    output_bytes: int
    peak_bytes: int


@dataclass(frozen=True)
class BuildCost:
    """One build from mesh files to views: cleaning, duplicates, start-up of the workers, all.

    Attributes:
        workers: Processes.
        shapes: Meshes built, two views each.
        seconds: On the clock.
    """

    workers: int
    shapes: int
    seconds: float


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
    """Make a view's files in memory, in a process of its own with one thread, once to warm it up."""
    config = config or BuildConfig()
    worker = WorkerProcess()
    try:
        return worker.call(_fastest_view, (mesh, config), config.limits.making(REPEATS + 1))
    finally:
        worker.close()


def _fastest_view(task: tuple[Mesh, BuildConfig]) -> ViewCost:
    costs = [_view_cost(*task) for _ in range(REPEATS + 1)]
    return min(costs[1:], key=lambda cost: cost.cpu_seconds)


def _view_cost(mesh: Mesh, config: BuildConfig) -> ViewCost:
    begin, surface = time.process_time(), Surface(mesh)
    files = view_files(surface, 0, config)
    seconds = time.process_time() - begin
    size = sum(len(data) for data in files.values())
    return ViewCost(len(mesh.faces), seconds, surface.trace.seconds(), size, peak_memory())


def measure_builds(
    meshes: Sequence[Mesh], workers: Sequence[int], advance: Callable[[str], None], config: BuildConfig | None = None
) -> list[BuildCost]:
    """Build the same shapes with different numbers of workers, each time into a new folder.

    Args:
        meshes: The shapes, which must differ.
        workers: Numbers of processes.
        advance: Called after each build.
        config: The settings.
    """
    costs = []
    with TemporaryDirectory() as folder:
        place = Path(folder) / "meshes"
        place.mkdir()
        for number, mesh in enumerate(meshes):
            (place / f"{number}.ply").write_bytes(ply_bytes(mesh))
        sources, settings = find_sources(place), config or BuildConfig()
        with runner_for(1) as runner:  # compiles what is compiled on first use
            build_dataset(sources[:1], Path(folder) / "first", settings, runner)
        for count in workers:
            with runner_for(count) as runner:
                build = build_dataset(sources, Path(folder) / f"data{count}", settings, runner)
            costs.append(BuildCost(count, len(meshes), build.seconds))
            advance(f"{count} workers")
    return costs


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
    fields = np.stack([distance_to(mask)[inked] for mask in masks])
    mean = (fields @ ink.T) / ink.sum(axis=1)
    return np.asarray((mean + mean.T) / 2, dtype=np.float64)


def by_gathering(masks: Mask) -> Floats:
    """A distance transform a drawing, its values gathered at every other drawing's pixels."""
    pixels = [np.flatnonzero(mask) for mask in masks]
    mean = np.array([[field[at].mean() for at in pixels] for field in (distance_to(m).ravel() for m in masks)])
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


def view_rows(cost: ViewCost) -> list[list[str]]:
    """One row a stage of a view, the slowest first, and the whole."""
    stages = sorted(cost.stages.items(), key=lambda entry: -entry[1])
    head = [["stage of a view", "ms"], *([name.replace("_", " "), f"{1000 * s:.1f}"] for name, s in stages)]
    return [*head, ["all, processor time", f"{1000 * cost.cpu_seconds:.0f}"]]


def distance_rows(costs: Sequence[DistanceCost]) -> list[list[str]]:
    """One row a way to the distances between all candidates."""
    head = ["264 x 264 distances", "seconds", "differs by, px"]
    return [head, *([cost.way, f"{cost.cpu_seconds:.2f}", f"{cost.difference:.1e}"] for cost in costs)]


def build_rows(costs: Sequence[BuildCost]) -> list[list[str]]:
    """One row a number of workers."""
    rows = [["workers", "shapes", "seconds", "times as fast"]]
    for cost in costs:
        rows.append(
            [str(cost.workers), str(cost.shapes), f"{cost.seconds:.1f}", f"{costs[0].seconds / cost.seconds:.2f}"]
        )
    return rows


def dataset_parts(mesh: Mesh, shapes: Sequence[Mesh], advance: Callable[[str], None]) -> list[Part]:
    """What a view of the data set costs, its distances the obvious ways, and what a second worker brings.

    Args:
        mesh: What one view is made of.
        shapes: What builds are made of.
        advance: Called after each of the `STEPS`.
    """
    view = measure_view(mesh)
    advance("a view")
    distances = compare_distances(mesh)
    advance("distances")
    builds = measure_builds(shapes, (1, 2), advance)
    of_view = (
        f"One view of {view.faces:,} faces, all but cleaning, on one thread: {view.cpu_seconds:.2f} s of processor, "
        f"{view.peak_bytes / 1e6:.0f} MB of memory at most, {view.output_bytes / 1e6:.2f} MB of files. "
        "Stages on the clock; the fastest of several runs."
    )
    of_ways = "Processor time. KD-trees are timed on some of the pairs and multiplied."
    of_builds = "Meshes to finished views on the clock: reading, cleaning, start-up of the workers, everything."
    ways, speeds = [asdict(way) for way in distances], [asdict(build) for build in builds]
    return [
        Part("view", "A view of the data set", of_view, view_rows(view), asdict(view)),
        Part("distances", "Distances between candidates", of_ways, distance_rows(distances), ways),
        Part("builds", "Workers", of_builds, build_rows(builds), speeds),
    ]
