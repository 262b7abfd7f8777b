"""Drawings as pixels: their ink, and PNG files."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ncmodel.camera import Camera
from ncmodel.export.dashes import dashed
from ncmodel.export.page import WIDTH, Picture
from ncmodel.export.rasterize import draw_segments
from ncmodel.types import Image, Stroke

PNG_LEVEL = 4
"""Of compression: drawings are written while somebody waits."""


def ink(picture: Picture) -> Image:
    """(H, W) ink in [0, 1]."""
    image = np.zeros((picture.height, picture.width), dtype=np.float32)
    for family, strokes in picture.groups():
        dashes, width = picture.dashes_of(family, pixels=True), picture.width_of(family)
        if dashes is not None:
            # The round end of a line adds half its width, at both ends of a dash.
            strokes = dashed(strokes, dashes[0] - width, dashes[1] + width)
        points = np.concatenate([np.stack([s.points[:-1], s.points[1:]], axis=1) for s in strokes])
        alpha = np.concatenate([np.stack([s.alpha[:-1], s.alpha[1:]], axis=1) for s in strokes])
        image = draw_segments(points, alpha, width, image.shape, onto=image)
    return image


def strokes_ink(strokes: Sequence[Stroke], camera: Camera, width: float = WIDTH) -> Image:
    """(H, W) ink of strokes in a camera's picture, as drawings have them; `width` as `Picture.line_width`."""
    return ink(Picture(camera.width, camera.height, strokes, width))


def png(picture: Picture) -> bytes:
    """A PNG file: grey on white, colours on a background, or black with transparency."""
    from ncmodel.images import png_bytes

    cover = ink(picture)
    paper, line = (np.array(c, dtype=np.float32) / 255 for c in picture.inks)
    if picture.background == "transparent":
        pixels = np.zeros((*cover.shape, 4), dtype=np.uint8)
        pixels[..., 3] = _bytes(cover)
    elif len(set(paper.tolist())) == 1:
        pixels = _bytes(paper[0] + cover * (line[0] - paper[0]))
    else:
        pixels = _bytes(paper + cover[..., None] * (line - paper))
    return png_bytes(pixels, PNG_LEVEL)


def _bytes(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.asarray(np.round(values * 255), dtype=np.uint8)
