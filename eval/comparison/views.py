"""The views that are compared, what they are judged by, and how they are opened."""

import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import blake2b
from pathlib import Path
from typing import Literal, Protocol, get_args

from dataset_tools.simulation.artists import ArtistDrawings, crowd_artists
from eval.measures.evaluation import Settings, Target
from eval.measures.references import find_references
from eval.measures.scans import read_lines
from ncmodel.camera import Camera
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair
from ncmodel.errors import ArgumentError, InputError
from ncmodel.scene.orientation import turn_outwards
from ncmodel.scene.seams import sew_seams
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Image

Which = Literal["held-out", "validation", "train", "all"]
"""Views of shapes that aren't trained on, of those that watch over training, of those trained on, of all shapes."""

STATED_WIDTH = 768
"""Tolerances are in pixels of pictures this wide, and grow with the picture."""


class References(Protocol):
    """What drawings are judged by."""

    @property
    def simulated(self) -> bool:
        """Whether programs drew them."""

    def of(self, item: Item) -> dict[str, Image]:
        """The references of an item, label -> (H, W) ink; none if it has none."""

    def identity(self, item: Item) -> str:
        """Tells them from others."""


@dataclass(frozen=True)
class SimulatedReferences:
    """What simulated artists draw of every view.

    Attributes:
        root: The data folder; drawings are kept there.
    """

    root: Path
    simulated: bool = True

    def of(self, item: Item) -> dict[str, Image]:
        """See `References.of`."""
        return {str(number): read_lines(path) for number, path in enumerate(self._artists().paths(item))}

    def identity(self, item: Item) -> str:
        """See `References.identity`."""
        return self._artists().folder.name

    def _artists(self) -> ArtistDrawings:
        return ArtistDrawings(DataFolder(self.root), crowd_artists())


@dataclass(frozen=True)
class FolderReferences:
    """What people drew: NAME.png or NAME/*.png each.

    Attributes:
        folder: Where they lie.
        paths: Name of the view -> pictures.
    """

    folder: Path
    paths: Mapping[str, Sequence[Path]]
    simulated: bool = False

    @staticmethod
    def found_in(folder: Path) -> "FolderReferences":
        """The references in a folder.

        Raises:
            InputError: There is none.
        """
        return FolderReferences(folder, find_references(folder))

    def of(self, item: Item) -> dict[str, Image]:
        """See `References.of`."""
        return {path.relative_to(self.folder).as_posix(): read_lines(path) for path in self._paths(item)}

    def identity(self, item: Item) -> str:
        """See `References.identity`."""
        digest = blake2b(digest_size=8)
        for path in self._paths(item):
            digest.update(path.read_bytes())
        return digest.hexdigest()

    def has(self, item: Item) -> bool:
        """Whether an item has any."""
        return bool(self._paths(item))

    def check(self, data: DataFolder, items: Iterable[Item]) -> None:
        """Read all references of some views before hours are spent on them.

        Raises:
            InputError: One can't be read, isn't lines on paper, or hasn't the size of its view.
        """
        for item in items:
            camera = Camera.load(data.camera_path(item))
            for label, ink in self.of(item).items():
                if ink.shape != (camera.height, camera.width):
                    found = f"{ink.shape[1]} x {ink.shape[0]} pixels"
                    view = f"{camera.width} x {camera.height}, as {data.camera_path(item)} has"
                    raise InputError(self.folder / label, found, view)

    def _paths(self, item: Item) -> Sequence[Path]:
        return self.paths.get(unicodedata.normalize("NFC", item.name), ())


def references_of(where: str, data: DataFolder) -> SimulatedReferences | FolderReferences:
    """The references that the command line names: "simulated", or a folder's path.

    Raises:
        InputError: The folder is missing or holds no reference.
    """
    return SimulatedReferences(data.root) if where == "simulated" else FolderReferences.found_in(Path(where))


def views_to_compare(
    data: DataFolder, pairs: Sequence[Pair], references: References, which: str, shapes: Sequence[str] = ()
) -> list[Item]:
    """The views that have references, of the shapes asked for.

    Args:
        data: The data folder.
        pairs: Ranking pairs: shapes with pairs of the split "train" are trained on.
        references: What drawings are judged by.
        which: One of `Which`.
        shapes: Only views of these; of all by default.

    Raises:
        ArgumentError: There is no such choice, no such shape, or no such view.
        InputError: It isn't a data folder, or a reference can't be used.
    """
    if which not in get_args(Which):
        raise ArgumentError("views", repr(which), f"one of {', '.join(get_args(Which))}")
    used = {split: {pair.item.shape for pair in pairs if pair.split == split} for split in ("train", "validation")}
    items = data.items()
    if unknown := sorted(set(shapes) - {item.shape for item in items}):
        raise ArgumentError("shapes", ", ".join(unknown), f"shapes of {data.root}")
    if shapes:
        items = [item for item in items if item.shape in shapes]
    asked = [item for item in items if which == "all" or (item.shape not in used["train"] and which == "held-out")]
    asked += [item for item in items if item.shape in used.get(which, ())]
    if not asked:
        raise ArgumentError("views", f"{which}, and no such view among {len(items)} in {data.root}", "others, or all")
    if isinstance(references, FolderReferences):
        drawn = [item for item in asked if references.has(item)]
        if not drawn:
            names = f"names as {asked[0].name}.png or {asked[0].name}/*.png, of {len(asked)} views ({which})"
            raise InputError(references.folder, f"no reference for any view, but for {min(references.paths)}", names)
        references.check(data, drawn)
        return drawn
    return asked


def open_as_drawn(data: DataFolder, item: Item) -> View:
    """An item's view as `ncontours draw` sees it: seams sewn, faces turned outwards."""
    camera = Camera.load(data.camera_path(item))
    return View(turn_outwards(sew_seams(Surface(data.load_mesh(item.shape))), camera.eye), camera)


def target_of(view: View, name: str, references: Mapping[str, Image], settings: Settings, whole: bool) -> Target:
    """What all drawings of a view are judged by.

    Args:
        view: The view.
        name: The view's.
        references: Label -> (H, W) ink.
        settings: How drawings are compared; the tolerance is stated for pictures `STATED_WIDTH` pixels wide.
        whole: Keep silhouettes, which are taken away from all drawings otherwise.
    """
    tolerance = settings.tolerance_pixels * view.camera.width / STATED_WIDTH
    fitting = replace(settings, tolerance_pixels=tolerance)
    return Target.of(name, references, fitting, None if whole else view.buffers.hit)
