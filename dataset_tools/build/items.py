"""The items of a data folder that participants vote on: which there are, and where their pictures lie."""

from pathlib import Path

from dataset_tools.questionnaires.identical_drawings import Twins, different, find_twins
from ncmodel.errors import InputError
from ncmodel.data.item import DRAWINGS, Item


def list_items(data_dir: Path) -> list[Item]:
    """All finished views of a data folder, sorted.

    Raises:
        InputError: It isn't a data folder, or none of its views is finished.
    """
    found = [
        Item(*folder.name.rsplit("_", 1))
        for folder in sorted((data_dir / "views").glob("*_*"))
        if not folder.name.startswith(".") and (folder / "selection.json").is_file()
    ]
    if not found:
        what = "no finished view" if data_dir.is_dir() else "no such folder"
        raise InputError(data_dir, what, "a folder that `ncontours dataset build` wrote")
    return found


def items_to_ask_about(data_dir: Path) -> list[Item]:
    """The items whose drawings aren't all one and the same, sorted.

    Raises:
        InputError: There is none.
    """
    found = [item for item in list_items(data_dir) if len(different(item_twins(data_dir, item))) > 1]
    if not found:
        raise InputError(data_dir, "the eight drawings of every view are one", "drawings to choose from")
    return found


def view_folder(data_dir: Path, item: Item) -> Path:
    """The folder of an item."""
    return data_dir / "views" / item.name


def drawing_path(data_dir: Path, item: Item, index: int) -> Path:
    """The picture of candidate 0..7."""
    return view_folder(data_dir, item) / "drawings" / f"{index}.png"


def item_twins(data_dir: Path, item: Item) -> Twins:
    """Which of an item's drawings are the same picture.

    Raises:
        InputError: One can't be read.
    """
    return find_twins([drawing_path(data_dir, item, index) for index in range(DRAWINGS)])


def render_paths(data_dir: Path, item: Item) -> list[Path]:
    """The shaded views that participants see beside the drawings, in order.

    Raises:
        InputError: There is none.
    """
    folder = view_folder(data_dir, item) / "renders"
    paths = sorted(folder.glob("*.png"), key=lambda path: (len(path.stem), path.stem))
    if not paths:
        raise InputError(folder, "no picture", "renders of the shape")
    return paths


def own_render(data_dir: Path, item: Item) -> Path:
    """The shaded view from where the drawings are seen: the middle one of those that participants see.

    Raises:
        InputError: There is none.
    """
    paths = render_paths(data_dir, item)
    return paths[len(paths) // 2]


def item_fingerprint(data_dir: Path, item: Item) -> bytes:
    """The files that say which drawings an item has.

    Raises:
        InputError: One can't be read.
    """
    folder = view_folder(data_dir, item)
    parts = []
    for name in ("camera.json", "selection.json"):
        try:
            parts.append((folder / name).read_bytes())
        except OSError as error:
            raise InputError(folder / name, f"can't be read ({error.strerror})", "a finished view") from error
    return b"".join(parts)
