"""Training data as arrays: the maps and drawings of the views that ranking pairs speak of.

Views are read when they're asked for and kept, scaled and compressed, in a cache of bounded size, so that a training
run's memory doesn't grow with the number of views. Compressed, ten times as many fit, and come back in a fifth of the
time that decoding their files takes.
"""

import hashlib
import zlib
from collections import OrderedDict
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, read_pairs
from ncmodel.errors import InputError
from ncmodel.images import read_grey
from ncmodel.model.letterbox import Square
from ncmodel.nets.presets import BACKGROUND, CURVATURE_MAPS, MAPS, Percentile
from ncmodel.types import Image

if TYPE_CHECKING:
    from ncmodel.scene.view import View

CACHE_BYTES = 1 << 30
"""Memory that a training run spends on views it has read already."""

WHITE = 65535
"""The level of 1."""

ENOUGH_VIEWS = 25
"""Held-out views by which passes can be told apart: an accuracy on them is uncertain by 0.1."""

Levels = NDArray[np.uint16]
"""Pictures as they are kept and handed on: brightness in 0..`WHITE`, for a drawing's ink dark, as in its file."""


def read_training_pairs(path: str | Path) -> list[Pair]:
    """Read a pairs.jsonl to train on.

    Raises:
        InputError: `read_pairs` refuses it, or all its pairs are held out.
    """
    pairs = read_pairs(path)
    if not any(pair.split == "train" for pair in pairs):
        raise InputError(path, f"{len(pairs)} pairs, none to train on", 'pairs with "split": "train"')
    return pairs


def validation_notes(pairs: Sequence[Pair]) -> list[str]:
    """What is wrong with the held-out pairs, where they are too few to choose the best pass by."""
    views = len({pair.item for pair in pairs if pair.split == "validation"})
    if not views:
        return ["no view is held out: there is nothing to choose the best pass by, and the last one is kept"]
    if views >= ENOUGH_VIEWS:
        return []
    some = f"{views} view{'s are' if views > 1 else ' is'} held out"
    unsure = f"an accuracy on them is uncertain by {0.5 / views**0.5:.2f}, and the best pass is chosen almost by chance"
    return [f"{some}: {unsure}; expected at least {ENOUGH_VIEWS} (crowd aggregate --held-out)"]


class ViewImages:
    """The pictures of a data folder's views, fitted into squares of the sizes that networks want.

    Attributes:
        data: The data folder.
        sizes: Sides of the squares, pixels. A file is decoded once for all of them.
        cache_bytes: Memory that may be spent on views that have been read already.
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
        self._cache: OrderedDict[Path, dict[int, bytes]] = OrderedDict()
        self.cache_bytes = self._free = cache_bytes
        self._opened: tuple[Item, View] | None = None

    def for_one_of(self, workers: int) -> "ViewImages":
        """The same for one of several processes that share the memory, with nothing read yet."""
        return ViewImages(self.data, self.sizes, self.cache_bytes // workers, self.inputs, self.percentile)

    def maps(self, item: Item, size: int) -> Image:
        """(K, size, size) the maps of `inputs`, in 0..1."""
        return self.map_levels(item, size).astype(np.float32) / np.float32(WHITE)

    def drawing(self, item: Item, index: int, size: int) -> Image:
        """(size, size) ink of one of the eight drawings, in 0..1."""
        # Files hold ink as black on white.
        return 1.0 - self.drawing_levels(item, index, size).astype(np.float32) / np.float32(WHITE)

    def map_levels(self, item: Item, size: int) -> Levels:
        """(K, size, size) the maps of `inputs`, as they are kept."""
        folder = self.data.view_folder(item)
        return np.stack(
            [
                self._levels(folder / f"{name}.png", size, BACKGROUND, partial(self._curvature, item, name))
                if name in CURVATURE_MAPS
                else self._levels(folder / f"{name}.png", size, BACKGROUND)
                for name in self.inputs
            ]
        )

    def drawing_levels(self, item: Item, index: int, size: int) -> Levels:
        """(size, size) one of the eight drawings, as it is kept."""
        return self._levels(self.data.drawing_path(item, index), size, background=1.0)

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
        from ncmodel.model.maps import network_maps

        if self._opened is None or self._opened[0] != item:
            self._opened = item, self.data.open_view(item)
        return np.asarray(network_maps(self._opened[1], [name], self.percentile)[0])

    def _levels(self, path: Path, size: int, background: float, make: Callable[[], Image] | None = None) -> Levels:
        if path in self._cache:
            self._cache.move_to_end(path)
        else:
            picture = read_grey(path) if make is None else make()
            height, width = picture.shape
            fitted = {side: Square(height, width, side).fit(picture, background) for side in self.sizes}
            levels: dict[int, Levels] = {
                side: np.rint(image * float(WHITE)).astype(np.uint16) for side, image in fitted.items()
            }
            self._keep(path, {side: zlib.compress(image.tobytes(), level=1) for side, image in levels.items()})
            return levels[size]
        kept = np.frombuffer(zlib.decompress(self._cache[path][size]), dtype=np.uint16)
        return np.asarray(kept.reshape(size, size))

    def _keep(self, path: Path, images: dict[int, bytes]) -> None:
        """Cache a file's images (always at least the last one) at the cost of those not used for longest."""
        self._free -= _bytes(images)
        while self._free < 0 and self._cache:
            self._free += _bytes(self._cache.popitem(last=False)[1])
        self._cache[path] = images


def _bytes(images: dict[int, bytes]) -> int:
    return sum(len(image) for image in images.values())
