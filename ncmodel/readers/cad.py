"""STEP and IGES (.step, .stp, .iges, .igs): surfaces of CAD programs, tessellated by Open CASCADE (extra `cad`)."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

from ncmodel.readers.content import Content, NotAMeshError
from ncmodel.readers.gltf import read_gltf

SUFFIXES: dict[str, Literal["step", "iges"]] = {".step": "step", ".stp": "step", ".iges": "iges", ".igs": "iges"}
"""And the format that each means."""

_LINEAR = 0.001
"""How far triangles stray from a curve, of its length."""
_ANGULAR = 0.1
"""Radians between neighbouring pieces of a curve."""


def read_cad(path: Path, data: bytes) -> Content:
    """The parts of an assembly in their places, in metres; these formats don't say which axis is up.

    Args:
        path: The file's, whose suffix is one of `SUFFIXES`.
        data: What is in it.

    Raises:
        NotAMeshError: It has no surfaces.
        ValueError: The file isn't what its suffix says, or cascadio isn't installed.
    """
    kind = SUFFIXES[path.suffix.lower()]
    try:
        import cascadio
    except ImportError as error:
        raise ValueError(f"cascadio is missing, pip install 'neural-contours[cad]' ({error})") from error
    with _unheard():
        made = cascadio.load(
            data, file_type=kind, tol_linear=_LINEAR, tol_angular=_ANGULAR, tol_relative=True, use_parallel=False
        )
    if not made:
        raise ValueError(f"Open CASCADE finds no {kind.upper()} in it, or nothing with a surface")
    content = read_gltf(path.with_suffix(".glb"), made)
    if len(content.faces) == 0:
        raise NotAMeshError("no surfaces")
    return content


@contextmanager
def _unheard() -> Iterator[None]:
    """Keep what Open CASCADE writes, past Python, off both streams: one of them may be for JSON."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [(stream, os.dup(stream)) for stream in (1, 2)]
    silence = os.open(os.devnull, os.O_WRONLY)
    try:
        for stream, _ in kept:
            os.dup2(silence, stream)
        yield
    finally:
        for stream, copy in kept:
            os.dup2(copy, stream)
            os.close(copy)
        os.close(silence)
