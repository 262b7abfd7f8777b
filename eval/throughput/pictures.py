"""A data folder to measure on: views of made-up relief, as large as real ones; there is nothing to learn from them."""

from pathlib import Path

import cv2
import numpy as np

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.data.pairs import Pair
from ncmodel.images import png_ink, png_map
from ncmodel.types import Image

SIDE = 768
"""Pixels, as data folders are built."""


def write_views(root: Path, count: int, seed: int = 0) -> list[Pair]:
    """Write `count` views, a fifth of them held out, and return the pairs among their drawings.

    Args:
        root: Folder to write to.
        count: How many.
        seed: Of the relief.
    """
    rng, data, pairs = np.random.default_rng(seed), DataFolder(root), []
    for number in range(count):
        item = Item(f"relief{number}", "0")
        folder = data.view_folder(item)
        (folder / "drawings").mkdir(parents=True)
        height = _relief(rng)
        for level, path in enumerate(data.map_paths(item)):
            # Depth first, then shading that gets smoother.
            path.write_bytes(png_map(height if level == 0 else _shaded(height, level)))
        for index in range(DRAWINGS):
            data.drawing_path(item, index).write_bytes(png_ink(_contours(height, index + 2)))
        split = "validation" if number % 5 == 4 else "train"
        pairs += [Pair(item, 0, other, split) for other in range(1, DRAWINGS)]  # type: ignore[arg-type]
    return pairs


def _relief(rng: np.random.Generator) -> Image:
    """(SIDE, SIDE) heights in 0..1 of a round piece of ground, 1 around it."""
    v, u = (np.mgrid[:SIDE, :SIDE] + 0.5) / SIDE * 2 - 1
    rough = cv2.GaussianBlur(rng.normal(size=(SIDE, SIDE)), (0, 0), 20) * 15
    inside = u**2 + v**2 < 0.8
    return np.asarray(np.where(inside, np.clip(0.5 + 0.3 * rough, 0, 1), 1.0), dtype=np.float32)


def _shaded(height: Image, level: int) -> Image:
    """The relief lit from the front, smoothed."""
    down, across = np.gradient(cv2.GaussianBlur(height, (0, 0), 2.0 * level) * SIDE / 8)
    return np.asarray(np.where(height < 1, 1 / np.sqrt(1 + down**2 + across**2), 1.0), dtype=np.float32)


def _contours(height: Image, count: int) -> Image:
    """(SIDE, SIDE) ink of so many contour lines."""
    steps = np.floor(height * count)
    edges = (np.diff(steps, axis=0, prepend=0) != 0) | (np.diff(steps, axis=1, prepend=0) != 0)
    return np.asarray(edges, dtype=np.float32)
