"""Contact sheets of a data folder: what was made of each view, at a glance."""

from collections.abc import Sequence
from pathlib import Path

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.images import Pixels, from_brightness, read_grey
from ncmodel.report.contact_sheet import Tile, contact_sheet


def data_sheet(data_dir: str | Path, names: Sequence[str] = (), thumb: int = 170) -> Pixels:
    """Views in rows: the renders, then the selected drawings under their candidates' numbers.

    Args:
        data_dir: The data folder.
        names: SHAPE_VIEW, which ones; all by default.
        thumb: Longest side of a picture, pixels.

    Raises:
        InputError: There is no such view.
    """
    data = DataFolder(data_dir)
    items = [DataFolder.of_view(data.views_folder / name)[1] for name in names] or data.items()
    rows = [_row(data, item) for item in items]
    return contact_sheet([tile for row in rows for tile in row], max(len(row) for row in rows), thumb)


def _row(data: DataFolder, item: Item) -> list[Tile]:
    medoids = data.medoids(item)
    renders = [Tile(_pixels(path), item.name) for path in data.render_paths(item)]
    drawings = [Tile(_pixels(data.drawing_path(item, i)), f"candidate {n}") for i, n in enumerate(medoids)]
    return renders + drawings


def _pixels(path: Path) -> Pixels:
    return from_brightness(read_grey(path))
