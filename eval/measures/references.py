"""Drawings on disk: synthetic ones, the references that people drew, and the most consistent of several references."""

import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ncmodel.chamfer import Lines, chamfer_distance
from ncmodel.cli.draw_job import CONTACT_SHEET
from ncmodel.errors import InputError
from ncmodel.files import is_clutter

DRAWINGS = (".png",)
INDEX = "references.json"
"""What tells a folder that `ncontours references` wrote: its parts are `PARTS`."""
PARTS = ("references", "meshes", "cameras", "silhouettes")

PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff")
"""Suffixes of what `ncontours draw` writes, and of what people scan."""


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


def find_drawings(folder: str | Path, suffixes: Sequence[str] = DRAWINGS) -> dict[str, Path]:
    """NAME -> picture for every NAME.png in a folder, in order of the names.

    Args:
        folder: Where they lie.
        suffixes: Other suffixes to look for.

    Raises:
        InputError: The folder is missing, holds no such file, or two of one name.
    """
    root = _folder(folder, "a folder of drawings, NAME.png each")
    found: dict[str, Path] = {}
    for name, path in _pictures(root, suffixes):
        if name in found:
            raise InputError(path, f"the name of {found[name].name} too", "one picture of a name")
        found[name] = path
    if not found:
        raise InputError(folder, "no PNG file in it", "drawings, NAME.png each")
    return dict(sorted(found.items()))


def find_references(folder: str | Path) -> dict[str, list[Path]]:
    """NAME -> its reference drawings: NAME.png and NAME/*.png (or JPEG, TIFF), in order of the names.

    Raises:
        InputError: The folder is missing or holds no reference.
    """
    root = _folder(folder, "a folder of references, NAME.png or NAME/*.png each")
    if (root / INDEX).is_file():
        root = _folder(root / "references", "references, NAME/*.png each")
    found: dict[str, list[Path]] = {}
    for name, path in _pictures(root, PICTURES):
        found.setdefault(name, []).append(path)
    for child in sorted(root.iterdir()):
        if child.is_dir() and not is_clutter(child.name):
            for _, path in _pictures(child, PICTURES):
                found.setdefault(_name(child.name), []).append(path)
    if not found:
        expected = "references, NAME.png or NAME/*.png each (or JPEG, TIFF)"
        raise InputError(folder, "no PNG file in it or one folder below", expected)
    return dict(sorted(found.items()))


def known_silhouettes(references: Path) -> Path | None:
    """The silhouettes of the meshes that references show, where they are known: `ncontours references` wrote them."""
    folder = references / "silhouettes"
    known = (references / INDEX).is_file() and folder.is_dir() and any(folder.glob("*.png"))
    return folder if known else None


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


def _pictures(folder: Path, suffixes: Sequence[str]) -> Iterator[tuple[str, Path]]:
    """Names and pictures in a folder, in order of the files' names; neither clutter nor what `draw` adds."""
    for path in sorted(folder.iterdir()):
        meant = path.name != CONTACT_SHEET and not is_clutter(path.name)
        if meant and path.suffix.lower() in suffixes and path.is_file():
            yield _name(path.stem), path


def _name(text: str) -> str:
    """A name by which pictures are matched: some systems store accented letters in two parts, others in one."""
    return unicodedata.normalize("NFC", text)


def _folder(folder: str | Path, expected: str) -> Path:
    root = Path(folder)
    if not root.is_dir():
        raise InputError(folder, "is a file" if root.exists() else "doesn't exist", expected)
    return root
