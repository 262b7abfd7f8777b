"""What the default model learns from: the numbers of a view's 256 drawings, and how far artists' drawings are."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import blake2b
from pathlib import Path

import cv2
import numpy as np

from dataset_tools.artists.motif import Motif
from dataset_tools.build.encoding import npz
from dataset_tools.build.runners import Runner
from dataset_tools.candidates.k_medoids import select
from dataset_tools.candidates.viewpoints import camera_at, choose_azimuths
from dataset_tools.collection.families import make_shape
from dataset_tools.simulation.artists import Artist, crowd_artists
from dataset_tools.simulation.participants import COMPARED_SIDE, distances_between
from ncmodel.arrays import read_arrays
from ncmodel.camera import DEFAULT_SIZE
from ncmodel.chamfer import chamfer_matrix
from ncmodel.data.item import Item
from ncmodel.drawing.settings import LayeredDrawings, Levels, draw_layers
from ncmodel.files import write_bytes
from ncmodel.limits import Limits
from ncmodel.mesh.load import load_mesh, make_mesh
from ncmodel.model.statistics import Statistics, statistics
from ncmodel.progress import Progress, silent
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Image, Ints, Mesh

SIZE = (DEFAULT_SIZE, DEFAULT_SIZE)

LIMITS = Limits(seconds=600.0, memory_gb=8.0)
"""Of one shape."""


@dataclass(frozen=True, eq=False)
class MeasuredView:
    """One view.

    Attributes:
        item: Which.
        statistics: The numbers of its 256 drawings.
        distances: (A, 256) symmetric Chamfer distances from artists' drawings, in shares of the picture's side.
        shown: (8,) the settings that a questionnaire shows: the medoids.
    """

    item: Item
    statistics: Statistics
    distances: Floats
    shown: Ints

    def save(self, folder: Path) -> None:
        """Write FOLDER/SHAPE_VIEW.npz, whole or not at all."""
        numbers = {"drawings": self.statistics.drawings, "view": self.statistics.view, "distances": self.distances}
        single = {key: part.astype(np.float32) for key, part in numbers.items()}
        write_bytes(folder / f"{self.item.name}.npz", npz(shown=self.shown, **single))

    @staticmethod
    def load(path: Path) -> "MeasuredView":
        """Read what `save` wrote.

        Raises:
            InputError: It is something else.
        """
        drawings, view, distances, shown = read_arrays(
            path, ("drawings", "view", "distances", "shown"), "a measured view"
        )
        return MeasuredView(Item.named(path.stem), Statistics(drawings, Levels().members, view), distances, shown)


@dataclass(frozen=True)
class ShapeTask:
    """The views of one shape.

    Attributes:
        source: A mesh file, or the name of a made shape.
        views: How many.
        folder: Where they are written.
    """

    source: str
    views: int
    folder: str

    @property
    def shape(self) -> str:
        """The shape's name."""
        return Path(self.source).stem

    @property
    def items(self) -> list[Item]:
        """All views."""
        return [Item(self.shape, str(number)) for number in range(self.views)]

    @property
    def missing(self) -> list[Item]:
        """The views that aren't there yet."""
        return [item for item in self.items if not (Path(self.folder) / f"{item.name}.npz").is_file()]


def measure_all(tasks: Sequence[ShapeTask], runner: Runner, progress: Progress = silent) -> dict[str, str]:
    """Measure all views that are missing; returns the shapes that failed, with reasons."""
    failed: dict[str, str] = {}
    missing = [task for task in tasks if task.missing]
    with progress("measuring views", len(tasks)) as advance:
        for task in tasks[: len(tasks) - len(missing)]:
            advance(task.shape)
        for outcome in runner.run(measure_shape, missing, LIMITS):
            if outcome.result is None:
                failed[outcome.task.shape] = outcome.reason
            advance(outcome.task.shape)
    return failed


def measure_shape(task: ShapeTask) -> int:
    """Measure the views of a shape that are missing; returns how many those were."""
    missing = task.missing
    if missing:
        surface = Surface(_mesh(task))
        for item in missing:
            measure_view(surface, item).save(Path(task.folder))
    return len(missing)


def _mesh(task: ShapeTask) -> Mesh:
    if not Path(task.source).suffix:
        made = make_shape(task.source)
        return make_mesh(made.vertices, made.faces, task.shape)
    return replace(load_mesh(task.source), name=task.shape)


def measure_view(surface: Surface, item: Item) -> MeasuredView:
    """Measure one view, seen as views of data folders are."""
    azimuth = choose_azimuths(item.shape, int(item.view) + 1)[int(item.view)]
    view = View(surface, camera_at(surface.mesh, azimuth, SIZE))
    drawings = draw_layers(view, Levels())
    members = drawings.levels.members
    numbers = statistics(drawings.masks, members, view.depth, view.shaded)
    shown = select(chamfer_matrix(drawings.masks, members)).medoids
    return MeasuredView(item, numbers, distances_to(drawings, artists_drawings(view, item, crowd_artists())), shown)


def artists_drawings(view: View, item: Item, artists: Sequence[Artist]) -> list[Image]:
    """(H, W) ink of what each artist draws of a view; the same as in a data folder's drawings of that name."""
    motif = Motif(view)
    own = int.from_bytes(blake2b(item.name.encode(), digest_size=4).digest(), "big")
    return [artist.draw(motif, np.random.default_rng([artist.seed, own])) for artist in artists]


def distances_to(drawings: LayeredDrawings, drawn: Sequence[Image]) -> Floats:
    """(A, 256) how far artists' drawings are from those of all settings, as participants see them."""
    layers = np.stack([cv2.resize(ink, (COMPARED_SIDE,) * 2, interpolation=cv2.INTER_AREA) for ink in drawings.ink])
    unions = (layers[member].max(axis=0) for member in drawings.levels.members)
    return distances_between(drawn, unions)
