"""Files of arrays (npz)."""

import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncmodel.errors import InputError

_DAMAGES = (OSError, EOFError, KeyError, TypeError, ValueError, NotImplementedError, zipfile.BadZipFile, zlib.error)


def read_arrays(path: Path, names: Sequence[str], expected: str) -> list[NDArray[Any]]:
    """Some arrays of an npz.

    Args:
        path: The file.
        names: The arrays' names.
        expected: What the file should be, for the message.

    Raises:
        InputError: The file is missing or damaged, or has no such arrays.
    """
    try:
        # numpy leaves a file open that it finds damaged.
        with path.open("rb") as stream, np.load(stream) as file:
            return [file[name] for name in names]
    except _DAMAGES as error:
        raise InputError(path, f"can't be read ({type(error).__name__})", expected) from error
