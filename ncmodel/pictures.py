"""Pictures for people: 8-bit pixels from ink or brightness, data URIs, contact sheets.

Pixels are uint8, (H, W) grey or (H, W, 3) RGB, as a PNG file holds them; ink (1 = line) becomes black on white here.
"""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ncmodel.errors import InputError
from ncmodel.files import write_bytes

Pixels = NDArray[np.uint8]

_FULL = {"uint8": 255.0, "uint16": 65535.0}
"""What a picture file stores for white."""

GAP = 12
"""Pixels between the thumbnails of a contact sheet."""

LABEL_SIZE = 15
"""Pixels of a contact sheet's letters."""

LABEL_COLOUR = 40
HIGHLIGHT_COLOUR = (0, 114, 178)
"""Blue of the frame around a highlighted thumbnail: told apart from grey and black by the colour-blind too."""


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


def png_bytes(pixels: Pixels) -> bytes:
    """The picture as a PNG file's bytes; the same pixels give the same bytes."""
    stored = pixels if pixels.ndim == 2 else pixels[..., ::-1]  # cv2's order is BGR
    done, data = cv2.imencode(".png", np.ascontiguousarray(stored), [cv2.IMWRITE_PNG_COMPRESSION, PNG_LEVEL])
    if not done:
        raise ValueError(f"pixels of shape {pixels.shape} and type {pixels.dtype} can't be written as PNG")
    return bytes(data)


def data_uri(pixels: Pixels, max_side: int | None = None) -> str:
    """The picture as a `data:` URI that a page can embed, scaled down to `max_side` if given."""
    small = pixels if max_side is None else shrink(pixels, max_side)
    return "data:image/png;base64," + base64.b64encode(png_bytes(small)).decode("ascii")


def write_png(path: str | Path, pixels: Pixels) -> None:
    """Write the picture atomically."""
    write_bytes(path, png_bytes(pixels))


def read_grey(path: str | Path) -> NDArray[np.float32]:
    """Read a picture as (H, W) brightness in [0, 1]: colours by luma, transparency over white, 8 or 16 bit.

    Raises:
        InputError: The file is missing or no picture that can be read.
    """
    expected = "a picture (PNG, or another format that OpenCV reads)"
    try:
        data = np.frombuffer(Path(path).read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", expected) from error
    stored = _decode(data)
    if stored is None:
        raise InputError(path, f"{data.size} bytes, damaged or no picture", expected)
    full = _FULL.get(stored.dtype.name, 1.0)
    return _brightness((stored / full).astype(np.float32))


def _decode(data: Pixels) -> Any:
    """The stored values as OpenCV decodes them, or `None`; without its own complaints on stderr."""
    logging = cv2.utils.logging
    level = logging.getLogLevel()
    logging.setLogLevel(logging.LOG_LEVEL_SILENT)
    try:
        return cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if data.size else None
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


@dataclass(frozen=True, eq=False)
class Tile:
    """One picture with its caption, in a report's grid or on a contact sheet.

    Attributes:
        pixels: uint8 (H, W) or (H, W, 3).
        caption: A short line below it.
        alt: What the picture shows, for those who can't see it; the caption by default.
        highlight: Frame it (the chosen one, the winner).
    """

    pixels: Pixels
    caption: str = ""
    alt: str = ""
    highlight: bool = False

    def __post_init__(self) -> None:
        colour = self.pixels.ndim == 3 and self.pixels.shape[2] == 3
        if self.pixels.dtype != np.uint8 or not (self.pixels.ndim == 2 or colour) or self.pixels.size == 0:
            raise ValueError(
                f"pixels are {self.pixels.dtype} of shape {self.pixels.shape}, expected uint8 (H, W) or (H, W, 3)"
            )


def contact_sheet(tiles: Sequence[Tile], columns: int = 8, thumb: int = 192) -> Pixels:
    """All tiles as one (H, W, 3) picture: a grid of labelled thumbnails on white.

    Args:
        tiles: In reading order; none gives a blank sheet.
        columns: Thumbnails in a row.
        thumb: Longest side of a thumbnail, pixels.
    """
    from PIL import Image as Canvas
    from PIL import ImageDraw

    font = _font()
    cell_height = thumb + LABEL_SIZE + 8 + GAP
    rows = max(1, -(-len(tiles) // columns))
    used = max(1, min(columns, len(tiles)))
    sheet = Canvas.new("RGB", (GAP + used * (thumb + GAP), GAP + rows * cell_height), "white")
    draw = ImageDraw.Draw(sheet)
    for number, tile in enumerate(tiles):
        left = GAP + (number % columns) * (thumb + GAP)
        top = GAP + (number // columns) * cell_height
        small = Canvas.fromarray(shrink(tile.pixels, thumb)).convert("RGB")
        sheet.paste(small, (left + (thumb - small.width) // 2, top + (thumb - small.height) // 2))
        frame, width = (HIGHLIGHT_COLOUR, 3) if tile.highlight else ((224, 224, 224), 1)
        draw.rectangle(
            (left - width, top - width, left + thumb + width - 1, top + thumb + width - 1), None, frame, width
        )
        label = _fitting(tile.caption, font, thumb)
        draw.text((left, top + thumb + 5), label, fill=(LABEL_COLOUR,) * 3, font=font)
    return _pixels(np.asarray(sheet))


def _font() -> Any:
    from PIL import ImageFont

    # The font that matplotlib ships: the same letters on every machine, beyond ASCII too.
    with resources.as_file(resources.files("matplotlib") / "mpl-data/fonts/ttf/DejaVuSans.ttf") as path:
        return ImageFont.truetype(str(path), LABEL_SIZE)


def _fitting(text: str, font: Any, width: int) -> str:
    """`text`, cut with an ellipsis where it is wider than `width` pixels."""
    if font.getlength(text) <= width:
        return text
    keep = len(text)
    while keep and font.getlength(text[:keep] + "…") > width:
        keep -= 1
    return text[:keep] + "…"


def _pixels(values: Any) -> Pixels:
    return np.asarray(values, dtype=np.uint8)
