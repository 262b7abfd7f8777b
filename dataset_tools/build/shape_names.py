"""What shapes are called: after their files' paths, and once named for ever.

The plain name of `chairs/old one.stl` is `chairs_old_one`. Where another file could bear it too (`chairs/old one.obj`),
both get longer ones, so that a name says which file is meant. A data folder remembers which file each of its shapes is:
whatever is added later, they keep their names.
"""

import hashlib
import re
import unicodedata
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath

from dataset_tools.build.manifest import read_json
from ncmodel.data.data_folder import DataFolder

MAX_BYTES = 180
"""Of a name: file systems take 255, and folders of views and their problems add to it."""


def name_shapes(places: Sequence[str], known: Mapping[str, str]) -> dict[str, str]:
    """Name the shapes in mesh files; the order of the files doesn't matter.

    Args:
        places: The files' paths below their folder.
        known: Place -> name, of shapes that have one, whether their file is still there or not.

    Returns:
        Place -> name.
    """
    choices = {place: _choices(place) for place in places if place not in known}
    # Some file systems don't tell capital letters from small ones.
    bearers = Counter(name for names in choices.values() for name in {name.casefold() for name in names})
    taken = {name.casefold() for name in known.values()}
    chosen = {
        place: next(
            (name for name in names if bearers[name.casefold()] == 1 and name.casefold() not in taken), names[-1]
        )
        for place, names in choices.items()
    }
    return {place: known[place] if place in known else chosen[place] for place in places}


def known_names(data: DataFolder, places: Sequence[str]) -> dict[str, str]:
    """Place -> name, of the shapes in a data folder.

    Shapes of folders that were built before places were noted belong to the file that would have been named so then;
    where there is none left, the name stays theirs all the same.
    """
    found: dict[str, str] = {}
    unplaced: dict[str, str] = {}
    for folder in sorted(data.shapes_folder.iterdir()) if data.shapes_folder.is_dir() else ():
        record = read_json(folder / "clean.json") or {}
        if isinstance(record.get("place"), str):
            found[record["place"]] = folder.name
        elif folder.is_dir():
            unplaced[folder.name] = str(record.get("source", ""))
    for name, source in unplaced.items():
        candidates = [
            place
            for place in places
            if place not in found and source in ("", PurePosixPath(place).name) and _may_be_called(place, name)
        ]
        found[candidates[0] if candidates else f"/{name}"] = name  # no place begins with a slash
    return found


def _choices(place: str) -> tuple[str, str, str]:
    """Names for a file, from the plainest to one that no other file has."""
    path = PurePosixPath(place)
    full = file_name(place)
    return file_name(str(path.with_suffix(""))), full, f"{full}-{_short_hash(place)}"


def file_name(text: str) -> str:
    """A text as part of a file name: letters and digits of all scripts, dots and hyphens stay."""
    normal = unicodedata.normalize("NFC", text)
    kept = "".join(c if unicodedata.category(c)[0] in "LMN" or c in ".-" else " " for c in normal)
    name = re.sub(" +", "_", kept).strip("_.") or "shape"
    if len(name.encode()) <= MAX_BYTES:
        return name
    return f"{name.encode()[:MAX_BYTES].decode(errors='ignore')}-{_short_hash(text)}"


def _may_be_called(place: str, name: str) -> bool:
    """Whether a file's shape may have got this name: now, or before letters of other scripts stayed."""
    stem = str(PurePosixPath(place).with_suffix(""))
    plain, full = (re.sub(r"[^A-Za-z0-9.-]+", "_", text).strip("_.") or "shape" for text in (stem, place))
    numbered = re.fullmatch(rf"{re.escape(full)}-\d+", name) is not None
    return name in (*_choices(place), plain, full) or numbered


def _short_hash(text: str) -> str:
    return hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()[:8]
