"""The mesh files that a data folder is made from: their names as shapes, their upward axes, their content."""

import csv
import hashlib
import itertools
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from dataset_tools.build.config import UPWARD
from dataset_tools.build.manifest import file_checksum
from ncmodel.errors import InputError
from ncmodel.mesh.gltf import beside
from ncmodel.mesh.load import SUFFIXES

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


def find_sources(mesh_dir: str | Path) -> list[Source]:
    """The mesh files below a folder, in the order of their paths; a shape is named after its path.

    Raises:
        InputError: There is none.
    """
    root = Path(mesh_dir)
    paths = sorted(path for path in root.rglob("*") if path.suffix.lower() in SUFFIXES and path.is_file())
    if not paths:
        raise InputError(root, "no mesh file" if root.is_dir() else "no such folder", f"files *{' *'.join(SUFFIXES)}")
    names: dict[str, Source] = {}
    for path in paths:
        relative = path.relative_to(root)
        plain, full = _file_name(str(relative.with_suffix(""))), _file_name(str(relative))
        numbered = (f"{full}-{number}" for number in itertools.count(2))
        # Several paths may come down to one name; no shape may take another's place.
        name = next(name for name in itertools.chain((plain, full), numbered) if name not in names)
        names[name] = Source(name, path, relative.as_posix())
    return list(names.values())


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
        uris = [str(buffer.get("uri", "")) for buffer in json.loads(path.read_bytes()).get("buffers", [])]
        files = [beside(uri, path) for uri in uris if uri and not uri.startswith("data:")]
    except (ValueError, AttributeError):
        return  # whoever reads it says what is wrong
    yield from files


def _file_name(text: str) -> str:
    """A text as part of a file name."""
    return re.sub(r"[^A-Za-z0-9.-]+", "_", text).strip("_.") or "shape"
