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
    image = _paper(picture)
    for group, strokes in picture.groups():
        image = _group_ink(picture, group, strokes, image)
    return np.maximum(image, _labels_ink(picture)) if picture.labels else image


def _paper(picture: Picture) -> Image:
    """(H, W) without ink."""
    return np.zeros((int(picture.height), int(picture.width)), dtype=np.float32)


def _group_ink(picture: Picture, group: str, strokes: Sequence[Stroke], onto: Image) -> Image:
    """The ink of one group, by maximum with what is there."""
    dashes, width = picture.dashes_of(group, pixels=True), picture.width_of(group)
    if dashes is not None:
        # The round end of a line adds half its width, at both ends of a dash.
        strokes = dashed(strokes, dashes[0] - width, dashes[1] + width)
    points = np.concatenate([np.stack([s.points[:-1], s.points[1:]], axis=1) for s in strokes])
    alpha = np.concatenate([np.stack([s.alpha[:-1], s.alpha[1:]], axis=1) for s in strokes])
    return draw_segments(points, np.ones_like(alpha) if picture.colours else alpha, width, onto.shape, onto=onto)


def _labels_ink(picture: Picture) -> Image:
    """(H, W) ink of the words."""
    from PIL import Image as Canvas
    from PIL import ImageDraw

    from ncmodel.images import letters

    canvas = Canvas.new("L", (int(picture.width), int(picture.height)))
    draw = ImageDraw.Draw(canvas)
    for label in picture.labels:
        draw.text(label.place, label.text, fill=255, font=letters(label.size), anchor="ms")
    return np.asarray(canvas, dtype=np.float32) / np.float32(255)


def strokes_ink(strokes: Sequence[Stroke], camera: Camera, width: float = WIDTH) -> Image:
    """(H, W) ink of strokes in a camera's picture, as drawings have them; `width` as `Picture.line_width`."""
    return ink(Picture(camera.width, camera.height, strokes, width))


def png(picture: Picture) -> bytes:
    """A PNG file: grey on white, colours on a background, or black with transparency."""
    from ncmodel.images import png_bytes

    if picture.colours:
        return png_bytes(_coloured(picture), PNG_LEVEL)
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


def _coloured(picture: Picture) -> NDArray[np.uint8]:
    """(H, W, 3) pixels, or (H, W, 4) on transparent paper: each group in its colour over those before it."""
    paper, clear = _paper(picture), picture.background == "transparent"
    light = np.full((*paper.shape, 3), 0.0 if clear else np.array(picture.inks[0]) / 255, dtype=np.float32)
    opacity = np.full((*paper.shape, 1), 0.0 if clear else 1.0, dtype=np.float32)
    layers = [(picture.colour_of(g), _group_ink(picture, g, strokes, paper)) for g, strokes in picture.groups()]
    for colour, cover in [*layers, *([(picture.inks[1], _labels_ink(picture))] if picture.labels else [])]:
        share = cover[..., None]
        light += share * (np.array(colour, dtype=np.float32) / 255 - light)
        opacity += share * (1.0 - opacity)
    if not clear:
        return _bytes(light)
    return _bytes(np.concatenate([light / np.maximum(opacity, 1e-6), opacity], axis=-1))


def _bytes(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.asarray(np.round(values * 255), dtype=np.uint8)
