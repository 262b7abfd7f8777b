"""The mesh files that a data folder is made from: where they lie, their upward axes, their content."""

import csv
import hashlib
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from dataset_tools.build.config import UPWARD
from dataset_tools.build.manifest import file_checksum
from dataset_tools.build.shape_names import known_names, name_shapes
from ncmodel.data.data_folder import DataFolder
from ncmodel.errors import InputError
from ncmodel.files import is_clutter
from ncmodel.mesh.load import SUFFIXES
from ncmodel.parsing import parse_json
from ncmodel.readers.gltf import beside

UP_COLUMNS = ("file", "up")


@dataclass(frozen=True)
class Source:
    """A shape and the mesh file that it comes from.

    Attributes:
        name: The shape's.
        path: Of the file.
        place: Path below the mesh folder, with slashes.
    """

    name: str
    path: Path
    place: str


def find_sources(mesh_dir: str | Path, data_dir: str | Path | None = None) -> list[Source]:
    """The mesh files below a folder, in the order of their paths; a shape is named after its path.

    Linked folders are followed, each folder once. What systems leave behind (names that begin with a dot, `__MACOSX`)
    is no input, nor is what a data folder below it holds.

    Args:
        mesh_dir: The folder.
        data_dir: The data folder that they are for: shapes keep the names that they have in it.

    Raises:
        InputError: There is none, or a folder can't be read.
    """
    root = Path(mesh_dir)
    paths = sorted(_mesh_paths(root)) if root.is_dir() else []
    if not paths:
        raise InputError(root, "no mesh file" if root.is_dir() else "no such folder", f"files *{' *'.join(SUFFIXES)}")
    places = {path.relative_to(root).as_posix(): path for path in paths}
    names = name_shapes(list(places), known_names(DataFolder(data_dir), list(places)) if data_dir else {})
    return [Source(names[place], path, place) for place, path in places.items()]


def _mesh_paths(root: Path) -> Iterator[Path]:
    """The mesh files below a folder; a link that leads nowhere is among them, so that it is told."""
    folders, links, seen = [root], list[Path](), set[Path]()
    while folders or links:
        folder = folders.pop() if folders else links.pop(0)  # linked ones last: what lies here has its own path
        if folder.resolve() in seen:
            continue
        seen.add(folder.resolve())
        try:
            names = sorted(os.listdir(folder))
        except OSError as error:
            raise InputError(folder, f"can't be read ({error.strerror})", "a folder of meshes") from error
        for name in names:
            path = folder / name
            if is_clutter(name) or _is_made(path):
                continue
            if path.is_dir():
                (links if path.is_symlink() else folders).append(path)
            elif path.suffix.lower() in SUFFIXES and (path.is_file() or path.is_symlink()):
                yield path


def _is_made(path: Path) -> bool:
    """Whether it is a folder that builds write."""
    data = DataFolder(path.parent)
    return path in (data.shapes_folder, data.views_folder) and data.config_path.is_file()


def content_checksum(path: Path) -> str:
    """SHA-256 of a mesh file, and of the buffers that it names if it is a .gltf; "" where it can't be read."""
    try:
        parts = [file_checksum(part) for part in (path, *_buffers(path))]
    except OSError:
        return ""
    return parts[0] if len(parts) == 1 else hashlib.sha256("".join(parts).encode()).hexdigest()


def read_up_table(path: str | Path) -> tuple[str, ...]:
    """Rules about upward axes from a table (CSV) with the columns `file` (a path or a pattern of paths) and `up`.

    Returns:
        Rules as `BuildConfig.up_rules` holds them.

    Raises:
        InputError: It isn't such a table.
    """
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            table = csv.DictReader(file)
            rows = list(table)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(path, f"can't be read ({error})", "a table (CSV)") from error
    if not set(UP_COLUMNS) <= set(table.fieldnames or ()):
        raise InputError(path, f"columns {table.fieldnames}", f"columns {', '.join(UP_COLUMNS)}")
    for number, row in enumerate(rows, 2):
        if not row["file"] or row["up"] not in UPWARD:
            raise InputError(path, f"row {number} has file {row['file']!r}, up {row['up']!r}", "a file and y or z")
    return tuple(f"{row['file']}={row['up']}" for row in rows)


def _buffers(path: Path) -> Iterator[Path]:
    """Files that a .gltf keeps its numbers in."""
    if path.suffix.lower() != ".gltf":
        return
    try:
        uris = [str(buffer.get("uri", "")) for buffer in parse_json(path.read_bytes()).get("buffers", [])]
        files = [beside(uri, path) for uri in uris if uri and not uri.startswith("data:")]
    except (ValueError, AttributeError):
        return  # whoever reads it says what is wrong
    yield from files
