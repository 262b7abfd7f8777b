"""Drawings as PNG."""

import cv2
import numpy as np

from ncmodel.export.page import Picture
from ncmodel.export.png import ink, png
from ncmodel.types import Floats


def decoded(picture: Picture) -> Floats:
    return np.asarray(cv2.imdecode(np.frombuffer(png(picture), np.uint8), cv2.IMREAD_UNCHANGED), dtype=np.float64)


def test_png_is_black_on_white_coloured_or_transparent(picture: Picture) -> None:
    cover = ink(picture)
    np.testing.assert_allclose(decoded(picture), 255 * (1 - cover), atol=0.51)
    grey = decoded(Picture(200, 200, picture.strokes, 6.0, "#808080"))
    np.testing.assert_allclose(grey, 128 * (1 - cover), atol=0.51)
    red = decoded(Picture(200, 200, picture.strokes, 6.0, "#ff8000"))
    np.testing.assert_allclose(red, (1 - cover)[..., None] * [0, 128, 255], atol=0.51)
    clear = decoded(Picture(200, 200, picture.strokes, 6.0, "transparent"))
    np.testing.assert_allclose(clear[..., 3], 255 * cover, atol=0.51)
    assert (clear[..., :3] == 0).all()
