"""Pixels and PNG files: the one place where pictures are encoded and decoded.

Pixels are uint8, (H, W) grey or (H, W, 3) RGB, as a PNG file holds them; ink (1 = line) becomes black on white here.
"""

from importlib import resources
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ncmodel.errors import InputError
from ncmodel.files import write_bytes

Pixels = NDArray[np.uint8]

FULL_16 = 65535.0
"""What a 16-bit picture stores for 1."""

_FULL = {"uint8": 255.0, "uint16": FULL_16}
"""What a picture file stores for white."""

_MOST_PIXELS = 1 << 27
"""Of a PNG that is read: A3 at 600 dpi, and almost A2. A small file may unpack to more than the memory holds."""
_PNG_SIZE = 24
"""Bytes up to the end of width and height in a PNG file."""


def from_ink(ink: ArrayLike) -> Pixels:
    """(H, W) ink in [0, 1], 1 = line, as black on white. Booleans are fine."""
    return from_brightness(1.0 - np.asarray(ink, dtype=np.float32))


def from_brightness(values: ArrayLike) -> Pixels:
    """(H, W) or (H, W, 3) values in [0, 1], 1 = white; what lies outside is clipped, NaN is black."""
    clipped = np.clip(np.nan_to_num(np.asarray(values, dtype=np.float32), nan=0.0), 0.0, 1.0)
    return _pixels(np.rint(255.0 * clipped))


def shrink(pixels: Pixels, max_side: int) -> Pixels:
    """The picture scaled down (never up) by area averaging so that no side is longer than `max_side`."""
    height, width = pixels.shape[:2]
    scale = max_side / max(height, width)
    if scale >= 1.0:
        return pixels
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    return _pixels(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))


PNG_LEVEL = 6
"""Of compression: 9 makes line drawings 7 % smaller in five times the time."""

# Prediction (Paeth) plus runs: on shaded and depth maps smaller than what zlib's search finds at ten times the time.
_RUNS = (cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE)
_PAETH = (*_RUNS, cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_PAETH)


def png_bytes(pixels: Pixels, level: int = PNG_LEVEL) -> bytes:
    """The picture as a PNG file's bytes; the same pixels give the same bytes.

    Args:
        pixels: (H, W) grey, (H, W, 3) RGB or (H, W, 4) RGB with opacity.
        level: Of compression, 0..9.
    """
    # OpenCV's order is blue, green, red, opacity.
    stored = pixels if pixels.ndim == 2 else pixels[..., [2, 1, 0, 3][: pixels.shape[2]]]
    return _encode(stored, (cv2.IMWRITE_PNG_COMPRESSION, level))


def png_map(values: ArrayLike) -> bytes:
    """(H, W) values in [0, 1] as a 16-bit PNG file."""
    return _encode(np.rint(np.clip(values, 0.0, 1.0) * FULL_16).astype(np.uint16), _PAETH)


def png_ink(ink: ArrayLike) -> bytes:
    """(H, W) ink in [0, 1], 1 = line, as an 8-bit grey PNG file, black on white, quickly."""
    return _encode(np.rint(255 * (1.0 - np.clip(ink, 0.0, 1.0))).astype(np.uint8), _RUNS)


def png_shaded(pixels: Pixels) -> bytes:
    """(H, W) grey pixels of a shaded picture as an 8-bit PNG file, quickly."""
    return _encode(pixels, _PAETH)


def _encode(stored: NDArray[np.generic], parameters: tuple[int, ...]) -> bytes:
    done, data = cv2.imencode(".png", np.ascontiguousarray(stored), parameters)
    if not done:
        raise ValueError(f"pixels of shape {stored.shape} and type {stored.dtype} can't be written as PNG")
    return bytes(data)


def write_png(path: str | Path, pixels: Pixels) -> None:
    """Write the picture atomically."""
    write_bytes(path, png_bytes(pixels))


def read_grey(path: str | Path) -> NDArray[np.float32]:
    """Read a picture as (H, W) brightness in [0, 1]: colours by luma, transparency over white, 8 or 16 bit.

    Raises:
        InputError: The file is missing, no picture that can be read, or so large that it would fill the memory.
    """
    expected = "a picture (PNG, or another format that OpenCV reads)"
    try:
        data = np.frombuffer(Path(path).read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", expected) from error
    if (size := _png_size(data)) and size[0] * size[1] > _MOST_PIXELS:
        raise InputError(path, f"{size[0]} x {size[1]} pixels", f"a picture of at most {_MOST_PIXELS} pixels")
    stored = _decode(data)
    if stored is None:
        raise InputError(path, f"{data.size} bytes, damaged or no picture", expected)
    full = _FULL.get(stored.dtype.name, 1.0)
    return _brightness((stored / full).astype(np.float32))


def _png_size(data: Pixels) -> tuple[int, int] | None:
    """Width and height that a PNG file says it has."""
    head = data[:_PNG_SIZE].tobytes()
    if not head.startswith(b"\x89PNG\r\n\x1a\n") or len(head) < _PNG_SIZE:
        return None
    return int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")


def _decode(data: Pixels) -> Any:
    """The stored values as OpenCV decodes them, or `None`; without its own complaints on stderr."""
    logging = cv2.utils.logging
    level = logging.getLogLevel()
    logging.setLogLevel(logging.LOG_LEVEL_SILENT)
    try:
        # A JPEG says which way the camera was held; "unchanged" would pass over it.
        turned = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH
        kept = turned if data[:2].tobytes() == b"\xff\xd8" else cv2.IMREAD_UNCHANGED
        return cv2.imdecode(data, kept) if data.size else None
    except cv2.error:
        return None
    finally:
        logging.setLogLevel(level)


def _brightness(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Luma of (H, W), (H, W, 2) grey + alpha, (H, W, 3) BGR or (H, W, 4) BGR + alpha values in [0, 1]."""
    if values.ndim == 2:
        return values
    channels = values.shape[2]
    colour = values[..., : channels - 1] if channels in (2, 4) else values
    luma = colour @ np.array([0.114, 0.587, 0.299], dtype=np.float32) if colour.shape[2] == 3 else colour[..., 0]
    over_white = 1.0 - values[..., -1] * (1.0 - luma) if channels in (2, 4) else luma
    return np.asarray(over_white, dtype=np.float32)


def _pixels(values: Any) -> Pixels:
    return np.asarray(values, dtype=np.uint8)


def letters(size: float) -> Any:
    """Pillow's font of letters of that size in pixels, the same on every machine: the one that matplotlib ships."""
    from PIL import ImageFont

    with resources.as_file(resources.files("matplotlib") / "mpl-data/fonts/ttf/DejaVuSans.ttf") as path:
        return ImageFont.truetype(str(path), size)
