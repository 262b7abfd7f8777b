"""Training data as arrays: the maps and drawings of the views that ranking pairs speak of.

Views are read when they're asked for and kept in a cache of bounded size, so that a training run's memory doesn't grow
with the number of views.
"""

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, read_pairs
from ncmodel.errors import InputError
from ncmodel.images import read_grey
from ncmodel.model.letterbox import Square
from ncmodel.model.maps import network_maps
from ncmodel.nets.presets import BACKGROUND, CURVATURE_MAPS, MAPS, Percentile
from ncmodel.scene.view import View
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
        inputs: Names of the maps. Curvature maps have no files: they are computed from the mesh.
        percentile: What curvature maps are measured in.
    """

    def __init__(
        self,
        data: DataFolder,
        sizes: Sequence[int],
        cache_bytes: int = CACHE_BYTES,
        inputs: Sequence[str] = MAPS,
        percentile: Percentile = "view",
    ) -> None:
        self.data, self.sizes = data, tuple(sorted(set(sizes)))
        self.inputs, self.percentile = tuple(inputs), percentile
        self._cache: OrderedDict[Path, dict[int, NDArray[np.uint16]]] = OrderedDict()
        self._free = cache_bytes
        self._opened: tuple[Item, View] | None = None

    def maps(self, item: Item, size: int) -> Image:
        """(K, size, size) the maps of `inputs`."""
        folder = self.data.view_folder(item)
        return np.stack(
            [
                self._image(folder / f"{name}.png", size, BACKGROUND, partial(self._curvature, item, name))
                if name in CURVATURE_MAPS
                else self._image(folder / f"{name}.png", size, BACKGROUND)
                for name in self.inputs
            ]
        )

    def drawing(self, item: Item, index: int, size: int) -> Image:
        """(size, size) ink of one of the eight drawings."""
        # Files hold ink as black on white.
        return 1.0 - self._image(self.data.drawing_path(item, index), size, background=1.0)

    def checksum(self, pairs: Sequence[Pair]) -> str:
        """Tells the pictures that ranking pairs speak of from others, by the files' content: 64 hexadecimal digits.

        Raises:
            InputError: A file can't be read.
        """
        items = {pair.item for pair in pairs}
        paths = {path for item in items for path in self.data.map_paths(item) if path.stem in self.inputs}
        if set(self.inputs) & set(CURVATURE_MAPS):
            paths |= {self.data.camera_path(item) for item in items}
            paths |= {self.data.mesh_path(item.shape) for item in items}
        paths |= {self.data.drawing_path(pair.item, index) for pair in pairs for index in (pair.better, pair.worse)}
        digest = hashlib.sha256()
        for path in sorted(paths):
            try:
                with open(path, "rb") as file:
                    digest.update(hashlib.file_digest(file, "sha256").digest())
            except OSError as error:
                raise InputError(path, f"can't be read ({error.strerror})", "a picture of a finished view") from error
        return digest.hexdigest()

    def _curvature(self, item: Item, name: str) -> Image:
        """(H, W) a curvature map. The item's view is kept for the next one: computing curvature takes long."""
        if self._opened is None or self._opened[0] != item:
            self._opened = item, self.data.open_view(item)
        return np.asarray(network_maps(self._opened[1], [name], self.percentile)[0])

    def _image(self, path: Path, size: int, background: float, make: Callable[[], Image] | None = None) -> Image:
        if path in self._cache:
            self._cache.move_to_end(path)
        else:
            levels = read_grey(path) if make is None else make()
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
