"""Training data as arrays: the maps and drawings of the views that ranking pairs speak of.

Views are read when they're asked for and kept in a cache of bounded size, so that a training run's memory doesn't grow
with the number of views.
"""

import hashlib
from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, read_pairs
from ncmodel.errors import InputError
from ncmodel.images import read_grey
from ncmodel.model.letterbox import Square
from ncmodel.nets.presets import BACKGROUND
from ncmodel.types import Image

CACHE_BYTES = 1 << 30
"""Memory that a training run spends on views it has read already."""


def read_training_pairs(path: str | Path) -> list[Pair]:
    """Read a pairs.jsonl to train on.

    Raises:
        InputError: `read_pairs` refuses it, or all its pairs are held out.
    """
    pairs = read_pairs(path)
    if not any(pair.split == "train" for pair in pairs):
        raise InputError(path, f"{len(pairs)} pairs, none to train on", 'pairs with "split": "train"')
    return pairs


class ViewImages:
    """The pictures of a data folder's views, fitted into squares of the sizes that networks want.

    Attributes:
        data: The data folder.
        sizes: Sides of the squares, pixels. A file is decoded once for all of them.
    """

    def __init__(self, data: DataFolder, sizes: Sequence[int], cache_bytes: int = CACHE_BYTES) -> None:
        self.data, self.sizes = data, tuple(sorted(set(sizes)))
        self._cache: OrderedDict[Path, dict[int, NDArray[np.uint16]]] = OrderedDict()
        self._free = cache_bytes

    def maps(self, item: Item, size: int) -> Image:
        """(7, size, size) depth and six shaded maps."""
        return np.stack([self._image(path, size, BACKGROUND) for path in self.data.map_paths(item)])

    def drawing(self, item: Item, index: int, size: int) -> Image:
        """(size, size) ink of one of the eight drawings."""
        # Files hold ink as black on white.
        return 1.0 - self._image(self.data.drawing_path(item, index), size, background=1.0)

    def checksum(self, pairs: Sequence[Pair]) -> str:
        """Tells the pictures that ranking pairs speak of from others, by the files' content: 64 hexadecimal digits.

        Raises:
            InputError: A file can't be read.
        """
        paths = {path for item in {pair.item for pair in pairs} for path in self.data.map_paths(item)}
        paths |= {self.data.drawing_path(pair.item, index) for pair in pairs for index in (pair.better, pair.worse)}
        digest = hashlib.sha256()
        for path in sorted(paths):
            try:
                with open(path, "rb") as file:
                    digest.update(hashlib.file_digest(file, "sha256").digest())
            except OSError as error:
                raise InputError(path, f"can't be read ({error.strerror})", "a picture of a finished view") from error
        return digest.hexdigest()

    def _image(self, path: Path, size: int, background: float) -> Image:
        if path in self._cache:
            self._cache.move_to_end(path)
        else:
            levels = read_grey(path)
            height, width = levels.shape
            fitted = {side: Square(height, width, side).fit(levels, background) for side in self.sizes}
            self._keep(path, {side: np.rint(image * 65535.0).astype(np.uint16) for side, image in fitted.items()})
        return self._cache[path][size].astype(np.float32) / 65535.0

    def _keep(self, path: Path, images: dict[int, NDArray[np.uint16]]) -> None:
        """Cache a file's images (always at least the last one) at the cost of those not used for longest."""
        self._free -= _bytes(images)
        while self._free < 0 and self._cache:
            self._free += _bytes(self._cache.popitem(last=False)[1])
        self._cache[path] = images


def _bytes(images: dict[int, NDArray[np.uint16]]) -> int:
    return sum(image.nbytes for image in images.values())
