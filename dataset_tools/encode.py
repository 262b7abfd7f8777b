"""Arrays as the bytes of files: the same arrays, the same bytes."""

import io
import lzma
import struct
import zlib

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ncmodel.types import Mesh

FULL_16 = 65535.0
"""What a 16-bit picture stores for 1."""

# Prediction (Paeth) plus runs: on shaded and depth maps smaller than what zlib's search finds at ten times the time.
_PNG = (cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE)
_PNG_MAPS = (*_PNG, cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_PAETH)

# A quick search with a dictionary that spans many drawings: candidates repeat one another almost exactly, which
# deflate, with its window of 32 KiB, can't see. 15 times smaller than deflate at the same speed.
_DICTIONARY = 1 << 22
_LZMA = [
    {
        "id": lzma.FILTER_LZMA1,
        "preset": 0,
        "dict_size": _DICTIONARY,
        "mode": lzma.MODE_FAST,
        "mf": lzma.MF_HC3,
        "nice_len": 273,
        "depth": 4,
    }
]
_LZMA_PROPERTIES = struct.pack("<BI", (2 * 5 + 0) * 9 + 3, _DICTIONARY)  # pb 2, lp 0, lc 3: the encoder's defaults
_ZIP_VERSION, _ZIP_LZMA, _ZIP_END_MARKER, _ZIP_EPOCH = 63, 14, 2, (1 << 5) | 1


def png_map(values: ArrayLike) -> bytes:
    """(H, W) values in [0, 1] as a 16-bit PNG file."""
    return _png(np.rint(np.clip(values, 0.0, 1.0) * FULL_16).astype(np.uint16), _PNG_MAPS)


def png_ink(ink: ArrayLike) -> bytes:
    """(H, W) ink in [0, 1], 1 = line, as an 8-bit grey PNG file, black on white."""
    return _png(np.rint(255 * (1.0 - np.clip(ink, 0.0, 1.0))).astype(np.uint8), _PNG)


def png_pixels(pixels: NDArray[np.uint8]) -> bytes:
    """(H, W) grey pixels as an 8-bit PNG file."""
    return _png(pixels, _PNG_MAPS)


def _png(pixels: NDArray[np.generic], parameters: tuple[int, ...]) -> bytes:
    done, data = cv2.imencode(".png", np.ascontiguousarray(pixels), parameters)
    if not done:
        raise ValueError(f"pixels of shape {pixels.shape} and type {pixels.dtype} can't be written as PNG")
    return bytes(data)


def npz(**arrays: NDArray[np.generic]) -> bytes:
    """Arrays as an .npz file that `numpy.load` reads: a zip archive, without time stamps, compressed by LZMA.

    Python's `zipfile` reads such members, but can write them only at a slow setting; hence the few structures here.

    References:
        PKWARE, .ZIP File Format Specification (APPNOTE) 6.3.10, sections 4.3 and 5.8.
    """
    body, directory = io.BytesIO(), io.BytesIO()
    for name, array in arrays.items():
        plain = io.BytesIO()
        np.lib.format.write_array(plain, np.asarray(array), allow_pickle=False)
        data = plain.getvalue()
        packed = struct.pack("<BBH", 9, 4, len(_LZMA_PROPERTIES)) + _LZMA_PROPERTIES
        packed += lzma.compress(data, format=lzma.FORMAT_RAW, filters=_LZMA)
        file_name = f"{name}.npy".encode()
        sizes = (zlib.crc32(data), len(packed), len(data), len(file_name), 0)
        common = struct.pack("<HHHHHIIIHH", _ZIP_VERSION, _ZIP_END_MARKER, _ZIP_LZMA, 0, _ZIP_EPOCH, *sizes)
        place = struct.pack("<HHHII", 0, 0, 0, 0, body.tell())
        directory.write(b"PK\x01\x02" + struct.pack("<H", _ZIP_VERSION) + common + place + file_name)
        body.write(b"PK\x03\x04" + common + file_name + packed)
    index = directory.getvalue()
    end = struct.pack("<HHHHIIH", 0, 0, len(arrays), len(arrays), len(index), body.tell(), 0)
    return body.getvalue() + index + b"PK\x05\x06" + end


def ply(mesh: Mesh) -> bytes:
    """A mesh as a binary PLY file in double precision, so that it is read back exactly."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(mesh.vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(mesh.faces), dtype=[("corners", "u1"), ("vertices", "<i4", 3)])
    faces["corners"], faces["vertices"] = 3, mesh.faces
    return header.encode() + mesh.vertices.astype("<f8").tobytes() + faces.tobytes()
