"""Drawings on disk: synthetic ones, the references that people drew, and the most consistent of several references."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ncmodel.chamfer import Lines, chamfer_distance
from ncmodel.errors import InputError


@dataclass(frozen=True)
class Pairing:
    """Which synthetic drawings meet which references.

    Attributes:
        drawings: Name -> picture, of the drawings that have references.
        references: Name -> pictures, in order of their file names.
        without_reference: Names of drawings that no reference matches.
        without_drawing: Names of references that no drawing matches.
    """

    drawings: dict[str, Path]
    references: dict[str, list[Path]]
    without_reference: tuple[str, ...]
    without_drawing: tuple[str, ...]


def find_drawings(folder: str | Path) -> dict[str, Path]:
    """NAME -> picture for every NAME.png in a folder, in order of the names.

    Raises:
        InputError: The folder is missing or holds no PNG file.
    """
    root = _folder(folder, "a folder of drawings, NAME.png each")
    found = {path.stem: path for path in _pictures(root)}
    if not found:
        raise InputError(folder, "no PNG file in it", "drawings, NAME.png each")
    return found


def find_references(folder: str | Path) -> dict[str, list[Path]]:
    """NAME -> its reference drawings: NAME.png and NAME/*.png, in order of the names.

    Raises:
        InputError: The folder is missing or holds no reference.
    """
    root = _folder(folder, "a folder of references, NAME.png or NAME/*.png each")
    found: dict[str, list[Path]] = {}
    for path in _pictures(root):
        found.setdefault(path.stem, []).append(path)
    for child in sorted(root.iterdir()):
        if child.is_dir() and (inside := _pictures(child)):
            found.setdefault(child.name, []).extend(inside)
    if not found:
        raise InputError(folder, "no PNG file in it or one folder below", "references, NAME.png or NAME/*.png each")
    return {name: found[name] for name in sorted(found)}


def pair_up(drawings: str | Path, references: str | Path) -> Pairing:
    """Match the drawings of one folder with the references of another by name.

    Raises:
        InputError: A folder is missing or empty, or no name occurs in both.
    """
    synthetic, human = find_drawings(drawings), find_references(references)
    both = [name for name in synthetic if name in human]
    if not both:
        raise InputError(
            drawings,
            f"no drawing has a reference ({_names(list(synthetic))})",
            f"names as in {references} ({_names(list(human))})",
        )
    return Pairing(
        {name: synthetic[name] for name in both},
        {name: human[name] for name in both},
        tuple(name for name in synthetic if name not in human),
        tuple(name for name in human if name not in synthetic),
    )


def most_consistent(references: Sequence[Lines]) -> int:
    """Index of the reference with the least Chamfer distance to the rest; the first among equals.

    Args:
        references: At least one; thin, silhouettes taken away, all of the same size.
    """
    if not references:
        raise ValueError("no references to choose from")
    count = len(references)
    distances = np.zeros((count, count))
    for i in range(count):
        for j in range(i):
            distances[i, j] = distances[j, i] = chamfer_distance(references[i], references[j])
    return int(np.argmin(distances.sum(axis=1)))


def _names(names: list[str], limit: int = 3) -> str:
    more = f" and {len(names) - limit} more" if len(names) > limit else ""
    return ", ".join(names[:limit]) + more


def _pictures(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.is_file() and path.suffix.lower() == ".png")


def _folder(folder: str | Path, expected: str) -> Path:
    root = Path(folder)
    if not root.is_dir():
        raise InputError(folder, "is a file" if root.exists() else "doesn't exist", expected)
    return root
