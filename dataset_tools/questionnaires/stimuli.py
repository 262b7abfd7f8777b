"""The pictures that participants receive: of one size, without metadata, under names that say nothing."""

import os
import shutil
import struct
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np

from ncmodel.images import Pixels, from_brightness, png_bytes, read_grey

DRAWING_LEVELS = 16
"""Grey levels of a drawing: as many as thin lines need, and files a third smaller than with 256."""

TIME_STAMP = 946684800
"""When all picture files claim to have been written (2000-01-01): a file's age could tell what it is."""

_PADDING = b"npAd"  # a private, ancillary PNG chunk: readers skip it
_CHUNK_OVERHEAD = 12


def frame(path: Path, size: tuple[int, int], levels: int = 256) -> Pixels:
    """A picture as (H, W) grey pixels, scaled to fit `size` = (width, height) and centred on white.

    Raises:
        InputError: It can't be read.
    """
    brightness = read_grey(path)
    height, width = brightness.shape
    scale = min(size[0] / width, size[1] / height)
    inner = (min(size[0], max(1, round(width * scale))), min(size[1], max(1, round(height * scale))))
    resized = cv2.resize(brightness, inner, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
    canvas = np.ones((size[1], size[0]), dtype=np.float32)
    left, top = (size[0] - inner[0]) // 2, (size[1] - inner[1]) // 2
    canvas[top : top + inner[1], left : left + inner[0]] = np.rint(resized * (levels - 1)) / (levels - 1)
    return from_brightness(canvas)


def pad_png(png: bytes, length: int) -> bytes:
    """A PNG file filled up to `length` bytes (at least 12 more than it has), its pixels as they were."""
    if length < len(png) + _CHUNK_OVERHEAD:
        raise ValueError(f"{len(png)} bytes don't fit into {length} with a chunk's {_CHUNK_OVERHEAD}")
    content = bytes(length - len(png) - _CHUNK_OVERHEAD)
    chunk = struct.pack(">I", len(content)) + _PADDING + content + struct.pack(">I", zlib.crc32(_PADDING + content))
    return png[:-12] + chunk + png[-12:]  # the last 12 bytes are the end chunk


class ImagePool:
    """Writes pictures once each, under as many names as they are shown.

    Every showing gets its own opaque name, so that a name can't be met again in another question; the files are hard
    links to one, so a picture takes its space once. All files of a kind are of one length in bytes.

    Args:
        folder: Where the pictures go.
        aside: A folder on the same file system for what is being made.
    """

    def __init__(self, folder: Path, aside: Path) -> None:
        self._folder, self._aside = folder, aside
        self._made: dict[tuple[Path, tuple[int, int]], Path] = {}
        self._longest: dict[tuple[int, int], int] = {}
        self._names: list[tuple[str, Path]] = []

    def add(self, name: str, source: Path, size: tuple[int, int], levels: int = 256) -> None:
        """Show the picture `source` at `size` (width, height) under `name`.

        Raises:
            InputError: It can't be read.
        """
        made = self._made.get((source, size))
        if made is None:
            data = png_bytes(frame(source, size, levels))
            made = self._aside / f"{len(self._made)}.{size[0]}x{size[1]}"
            made.write_bytes(data)
            self._made[source, size] = made
            self._longest[size] = max(self._longest.get(size, 0), len(data))
        self._names.append((name, made))

    def write(self) -> None:
        """Write all that was added."""
        for (_, size), made in self._made.items():
            made.write_bytes(pad_png(made.read_bytes(), self._longest[size] + _CHUNK_OVERHEAD))
            os.utime(made, (TIME_STAMP, TIME_STAMP))
        for name, made in self._names:
            try:
                os.link(made, self._folder / name)
            except OSError:  # a file system without hard links, or too many to one file
                shutil.copy2(made, self._folder / name)


@contextmanager
def image_pool(folder: Path) -> Iterator[ImagePool]:
    """A pool that has written its pictures to `folder` when the block ends well."""
    with tempfile.TemporaryDirectory(prefix=".pictures-", dir=folder.parent) as aside:
        pool = ImagePool(folder, Path(aside))
        yield pool
        pool.write()
