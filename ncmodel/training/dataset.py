"""Training data as it lies on disk: ranking pairs, and the maps and drawings of the views they speak of.

Views are read when they're asked for and kept in a cache of bounded size, so that a training run's memory doesn't grow
with the number of views.
"""

import json
from collections import Counter, OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ncmodel.data.item import DRAWINGS, Item
from ncmodel.errors import InputError
from ncmodel.images import read_grey
from ncmodel.model.letterbox import Square
from ncmodel.nets.presets import BACKGROUND
from ncmodel.types import Image

CACHE_BYTES = 1 << 30
"""Memory that a training run spends on views it has read already."""

MAP_FILES = ("depth.png", *(f"shaded_{level}.png" for level in range(6)))

_PAIR_KEYS = ("shape", "view", "better", "worse", "split")


@dataclass(frozen=True)
class Pair:
    """Participants found drawing `better` of an item better than drawing `worse`.

    Attributes:
        better: Index 0..7 of the drawing.
        worse: Index 0..7 of the other one.
        split: "train" or "validation".
    """

    item: Item
    better: int
    worse: int
    split: Literal["train", "validation"]


def read_pairs(path: str | Path) -> list[Pair]:
    """Read a pairs.jsonl.

    Raises:
        InputError: The file can't be read, a line isn't a pair, or a shape is both trained on and held out.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", "a file of ranking pairs") from error
    except UnicodeDecodeError as error:
        raise InputError(path, f"not UTF-8 text ({error.reason})", "a file of ranking pairs") from error
    pairs = [_pair(f"{path}:{row}", line) for row, line in enumerate(text.splitlines(), 1) if line.strip()]
    if not any(pair.split == "train" for pair in pairs):
        raise InputError(path, f"{len(pairs)} pairs, none to train on", 'pairs with "split": "train"')
    both = {p.item.shape for p in pairs if p.split == "train"} & {p.item.shape for p in pairs if p.split != "train"}
    if both:
        raise InputError(path, f"shape {min(both)!r} is in both splits", "each shape trained on or held out")
    return pairs


def _pair(where: str, line: str) -> Pair:
    """One line of a pairs.jsonl."""
    expected = f"an object with {', '.join(_PAIR_KEYS)}"
    try:
        record = json.loads(line)
    except ValueError as error:
        raise InputError(where, f"not JSON ({error})", expected) from error
    if not isinstance(record, dict) or not set(_PAIR_KEYS) <= set(record):
        raise InputError(where, f"found {line[:80]}", expected)
    item = Item(_name(where, "shape", record["shape"]), _name(where, "view", record["view"]))
    better, worse = (_index(where, key, record[key]) for key in ("better", "worse"))
    if better == worse:
        raise InputError(where, f"better and worse are both {better}", "two different drawings")
    if record["split"] not in ("train", "validation"):
        raise InputError(where, f"split is {record['split']!r}", '"train" or "validation"')
    return Pair(item, better, worse, record["split"])


def _name(where: str, key: str, value: Any) -> str:
    """A part of a folder name, which must not lead out of the folder."""
    text = str(value) if isinstance(value, int | str) and not isinstance(value, bool) else ""
    if not text or "/" in text or "\\" in text or "\0" in text:
        raise InputError(where, f"{key} is {value!r}", "a name or a number")
    return text


def _index(where: str, key: str, value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < DRAWINGS:
        raise InputError(where, f"{key} is {value!r}", f"a drawing 0..{DRAWINGS - 1}")
    return value


def best_drawings(pairs: Sequence[Pair]) -> dict[Item, int]:
    """Each item's best drawing: the one that wins most pairs and, among several, has the lowest index."""
    wins = Counter((pair.item, pair.better) for pair in pairs)
    best: dict[Item, int] = {}
    for (item, drawing), _ in sorted(wins.items(), key=lambda entry: (-entry[1], entry[0])):
        best.setdefault(item, drawing)
    return best


class DataFolder:
    """The views of a DATA_DIR, fitted into squares of the sizes that networks want.

    Attributes:
        root: The DATA_DIR.
        sizes: Sides of the squares, pixels. A file is decoded once for all of them.
    """

    def __init__(self, root: str | Path, sizes: Sequence[int], cache_bytes: int = CACHE_BYTES) -> None:
        self.root, self.sizes = Path(root), tuple(sorted(set(sizes)))
        self._cache: OrderedDict[tuple[Item, str], dict[int, NDArray[np.uint16]]] = OrderedDict()
        self._free = cache_bytes

    def require(self, items: Sequence[Item], pairs_path: str | Path) -> None:
        """Check that every item's view folder exists; what is in it is checked when it's read.

        Raises:
            InputError: A folder is missing.
        """
        if not (self.root / "views").is_dir():
            raise InputError(self.root, "no folder 'views' in it", "a data folder")
        for item in items:
            if not (self.root / "views" / item.name).is_dir():
                raise InputError(
                    pairs_path, f"item {item.name!r} is unknown", f"a folder {self.root}/views/{item.name}"
                )

    def maps(self, item: Item, size: int) -> Image:
        """(7, size, size) depth and six shaded maps."""
        return np.stack([self._image(item, name, size, BACKGROUND) for name in MAP_FILES])

    def drawing(self, item: Item, index: int, size: int) -> Image:
        """(size, size) ink of one of the eight drawings."""
        # Files hold ink as black on white.
        return 1.0 - self._image(item, f"drawings/{index}.png", size, background=1.0)

    def _image(self, item: Item, name: str, size: int, background: float) -> Image:
        key = (item, name)
        if key in self._cache:
            self._cache.move_to_end(key)
        else:
            levels = read_grey(self.root / "views" / item.name / name)
            height, width = levels.shape
            fitted = {side: Square(height, width, side).fit(levels, background) for side in self.sizes}
            self._keep(key, {side: np.rint(image * 65535.0).astype(np.uint16) for side, image in fitted.items()})
        return self._cache[key][size].astype(np.float32) / 65535.0

    def _keep(self, key: tuple[Item, str], images: dict[int, NDArray[np.uint16]]) -> None:
        """Cache a file's images (always at least the last one) at the cost of those not used for longest."""
        self._free -= _bytes(images)
        while self._free < 0 and self._cache:
            self._free += _bytes(self._cache.popitem(last=False)[1])
        self._cache[key] = images


def _bytes(images: dict[int, NDArray[np.uint16]]) -> int:
    return sum(image.nbytes for image in images.values())
