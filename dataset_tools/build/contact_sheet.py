"""Contact sheets of a data folder: what was made of each view, at a glance."""

import json
from collections.abc import Sequence
from pathlib import Path

from dataset_tools.build.store import Store
from ncmodel.errors import InputError
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
    root = Store(data_dir).root / "views"
    folders = [root / name for name in names] or sorted(path for path in root.glob("*") if path.is_dir())
    if not folders:
        raise InputError(data_dir, "no view in it", "a folder with views that are done")
    rows = [_row(folder) for folder in folders]
    return contact_sheet([tile for row in rows for tile in row], max(len(row) for row in rows), thumb)


def _row(folder: Path) -> list[Tile]:
    try:
        medoids = json.loads((folder / "selection.json").read_text(encoding="utf-8"))["medoids"]
    except (OSError, ValueError, KeyError) as error:
        raise InputError(folder, "no readable selection.json in it", "a view that is done") from error
    renders = [Tile(_pixels(path), folder.name) for path in sorted((folder / "renders").glob("*.png"))]
    drawings = [Tile(_pixels(folder / "drawings" / f"{i}.png"), f"candidate {n}") for i, n in enumerate(medoids)]
    return renders + drawings


def _pixels(path: Path) -> Pixels:
    return from_brightness(read_grey(path))
