"""Pictures for people: tiles with captions, contact sheets of them, and pictures that pages embed."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ncmodel.errors import printable
from ncmodel.images import Pixels, letters, png_bytes, shrink

GAP = 12
"""Pixels between the thumbnails of a contact sheet."""
LABEL_SIZE = 15
"""Pixels of a contact sheet's letters."""
LABEL_COLOUR = 40
HIGHLIGHT_COLOUR = (0, 114, 178)
"""Blue of the frame around a highlighted thumbnail: told apart from grey and black by the colour-blind too."""


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

    font = letters(LABEL_SIZE)
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
    return np.asarray(sheet, dtype=np.uint8)


def data_uri(pixels: Pixels, max_side: int | None = None) -> str:
    """The picture as a `data:` URI that a page can embed, scaled down to `max_side` if given."""
    small = pixels if max_side is None else shrink(pixels, max_side)
    return "data:image/png;base64," + base64.b64encode(png_bytes(small)).decode("ascii")


def _fitting(text: str, font: Any, width: int) -> str:
    """`text` on one line, cut with an ellipsis where it is wider than `width` pixels."""
    text = printable(text)
    if font.getlength(text) <= width:
        return text
    keep = len(text)
    while keep and font.getlength(text[:keep] + "…") > width:
        keep -= 1
    return text[:keep] + "…"
