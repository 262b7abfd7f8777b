"""Arrays as files: what is read back is what was written."""

import io
import zipfile
from typing import Any

import cv2
import numpy as np
import pytest

from dataset_tools.build.encoding import npz
from ncmodel.images import png_ink, png_map, png_shaded


def decode(data: bytes) -> Any:
    return np.asarray(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED))


def test_an_archive_reads_back_in_numpy_and_passes_the_zip_check() -> None:
    rng = np.random.default_rng(0)
    ink = np.packbits(rng.random((20, 33, 50)) < 0.1, axis=-1)
    data = npz(ink=ink, shape=np.array([20, 33, 50]), nothing=np.zeros((0, 3)))
    assert zipfile.ZipFile(io.BytesIO(data)).testzip() is None
    with np.load(io.BytesIO(data)) as archive:
        assert sorted(archive) == ["ink", "nothing", "shape"]
        assert np.array_equal(archive["ink"], ink)
        assert archive["shape"].tolist() == [20, 33, 50]
        assert archive["nothing"].shape == (0, 3)


def test_an_archive_has_no_time_in_it() -> None:
    assert npz(a=np.arange(9)) == npz(a=np.arange(9))
    (entry,) = zipfile.ZipFile(io.BytesIO(npz(a=np.arange(9)))).infolist()
    assert entry.date_time == (1980, 1, 1, 0, 0, 0)


def test_drawings_that_repeat_one_another_cost_little() -> None:
    drawing = np.random.default_rng(1).integers(0, 256, 80_000, dtype=np.uint8)
    assert len(npz(ink=np.tile(drawing, (30, 1)))) < 1.5 * drawing.size


def test_maps_keep_16_bits() -> None:
    values = np.linspace(-0.1, 1.1, 500).reshape(10, 50)
    pixels = decode(png_map(values))
    assert pixels.dtype == np.uint16
    assert np.abs(pixels / 65535 - np.clip(values, 0, 1)).max() <= 0.5 / 65535


def test_ink_is_black_on_white() -> None:
    assert decode(png_ink(np.array([[0.0, 1.0, 0.5]]))).tolist() == [[255, 0, 128]]
    assert decode(png_shaded(np.array([[0, 7]], np.uint8))).tolist() == [[0, 7]]


def test_pixels_that_no_picture_holds_are_refused() -> None:
    with pytest.raises((ValueError, cv2.error)):
        png_map(np.zeros((0, 0)))
