"""The data folder, DATA_DIR: where everything in it lies, which items it has, and how a view of it is opened."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ncmodel.data.item import DRAWINGS, Item
from ncmodel.errors import InputError
from ncmodel.parsing import parse_json

if TYPE_CHECKING:
    from ncmodel.scene.view import View
    from ncmodel.types import Mesh

MAPS = ("depth.png", *(f"shaded_{level}.png" for level in range(6)))
"""What the model sees of a view, in the order of its channels."""


class DataFolder:
    """A data folder.

    Attributes:
        root: The DATA_DIR; needn't exist.
        config_path: The settings that it was built with.
        index_path: The table of its views.
        duplicates_path: The shapes that were left out as duplicates.
        shapes_folder: Where a folder for each shape lies.
        views_folder: Where a folder for each view lies.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root)
        self.config_path = self.root / "config.toml"
        self.index_path = self.root / "index.csv"
        self.duplicates_path = self.root / "duplicates.json"
        self.shapes_folder = self.root / "shapes"
        self.views_folder = self.root / "views"

    @staticmethod
    def of_view(folder: Path) -> "tuple[DataFolder, Item]":
        """The data folder that DATA_DIR/views/SHAPE_VIEW belongs to, and which of its items that is.

        Raises:
            InputError: The name isn't SHAPE_VIEW.
        """
        place = folder.resolve()
        try:
            return DataFolder(place.parents[1]), Item.named(place.name)
        except (ValueError, IndexError) as error:
            raise InputError(folder, "a name that isn't SHAPE_VIEW", "a folder DATA_DIR/views/SHAPE_VIEW") from error

    def shape_folder(self, shape: str) -> Path:
        """Where a shape's mesh and cleaning report lie."""
        return self.shapes_folder / shape

    def mesh_path(self, shape: str) -> Path:
        """A shape's cleaned mesh."""
        return self.shape_folder(shape) / "mesh.ply"

    def view_folder(self, item: Item) -> Path:
        """Where all that belongs to an item lies."""
        return self.views_folder / item.name

    def camera_path(self, item: Item) -> Path:
        """The camera that an item is seen by."""
        return self.view_folder(item) / "camera.json"

    def selection_path(self, item: Item) -> Path:
        """Which candidates an item's drawings are."""
        return self.view_folder(item) / "selection.json"

    def medoids(self, item: Item) -> list[int]:
        """Which of the candidates an item's eight drawings are.

        Raises:
            InputError: The file that says so can't be read.
        """
        path, expected = self.selection_path(item), "what `ncontours dataset build` wrote"
        try:
            found = parse_json(path.read_text(encoding="utf-8"))["medoids"]
            medoids = [int(number) for number in found]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InputError(path, f"can't be read ({type(error).__name__})", expected) from error
        if len(medoids) != DRAWINGS:
            raise InputError(path, f"{len(medoids)} medoids", f"{DRAWINGS}, {expected}")
        return medoids

    def map_paths(self, item: Item) -> list[Path]:
        """The pictures `MAPS` of an item."""
        return [self.view_folder(item) / name for name in MAPS]

    def drawing_path(self, item: Item, index: int) -> Path:
        """The picture of an item's drawing 0..7."""
        return self.view_folder(item) / "drawings" / f"{index}.png"

    def drawing_paths(self, item: Item) -> list[Path]:
        """The pictures of all drawings of an item."""
        return [self.drawing_path(item, index) for index in range(DRAWINGS)]

    def render_paths(self, item: Item) -> list[Path]:
        """The shaded views that participants see beside the drawings, in order.

        Raises:
            InputError: There is none.
        """
        folder = self.view_folder(item) / "renders"
        paths = sorted(folder.glob("*.png"), key=lambda path: (len(path.stem), path.stem))
        if not paths:
            raise InputError(folder, "no picture", "renders of the shape")
        return paths

    def own_render(self, item: Item) -> Path:
        """The shaded view from where the drawings are seen: the middle one of those that participants see.

        Raises:
            InputError: There is none.
        """
        paths = self.render_paths(item)
        return paths[len(paths) // 2]

    def items(self) -> list[Item]:
        """All finished views, in the order of their folders' names.

        Raises:
            InputError: It isn't a data folder, or none of its views is finished.
        """
        # What begins with a dot is a build's or an editor's; what has no underscore is nobody's view.
        folders = sorted(path for path in self.views_folder.glob("?*_?*") if not path.name.startswith("."))
        found = [item for item in (Item.named(path.name) for path in folders) if self.selection_path(item).is_file()]
        if not found:
            what = "no finished view" if self.root.is_dir() else "no such folder"
            raise InputError(self.root, what, "a folder that `ncontours dataset build` wrote")
        return found

    def require(self, items: Iterable[Item], asked_by: str | Path) -> None:
        """Check that every item's folder is there; what is in it is checked when it's read.

        Args:
            items: Any items.
            asked_by: The file that speaks of them.

        Raises:
            InputError: A folder is missing.
        """
        if not self.views_folder.is_dir():
            raise InputError(self.root, "no folder 'views' in it", "a data folder")
        for item in items:
            folder = self.view_folder(item)
            if not folder.is_dir():
                raise InputError(asked_by, f"item {item.name!r} is unknown", f"a folder {folder}")

    def load_mesh(self, shape: str) -> "Mesh":
        """A shape's cleaned mesh, under the shape's name.

        Raises:
            MeshError: There is none.
        """
        from ncmodel.mesh.load import load_mesh

        return replace(load_mesh(self.mesh_path(shape)), name=shape)

    def open_view(self, item: Item, size: tuple[int, int] | None = None) -> "View":
        """The geometry of an item, ready to be drawn.

        Args:
            item: The item.
            size: (width, height) to see it at; its own by default.

        Raises:
            InputError: Its mesh or its camera can't be read.
        """
        from ncmodel.camera import Camera
        from ncmodel.scene.surface import Surface
        from ncmodel.scene.view import View

        camera = Camera.load(self.camera_path(item))
        return View(Surface(self.load_mesh(item.shape)), camera.resized(*size) if size else camera)
