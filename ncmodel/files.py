"""Files that are there whole or not at all, and those that nobody means."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ncmodel.errors import InputError


def is_clutter(name: str) -> bool:
    """Whether a file or folder of this name is hidden or left behind by a system (`._a.obj`, `.trash`, `__MACOSX`)."""
    return name.startswith(".") or name == "__MACOSX"


@contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """A path aside to write to, renamed to `path` when the block ends well and removed when it doesn't.

    The name aside keeps the suffix, so that writers which go by the suffix work.

    Raises:
        InputError: There is no such folder, or the path is one.
        OSError: The folder can't be written.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(path, f"there is no folder {target.parent}", "a folder that exists")
    if target.is_dir():
        raise InputError(path, "a folder", "a file's name")
    try:
        handle, name = tempfile.mkstemp(prefix=".tmp-", suffix=target.suffix, dir=target.parent or ".")
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(target)) from error  # nobody knows the name aside
    os.close(handle)
    aside = Path(name)
    try:
        yield aside
        # mkstemp's files are private; the finished one gets the usual permissions.
        umask = os.umask(0)
        os.umask(umask)
        aside.chmod(0o666 & ~umask)
        os.replace(aside, target)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise


def write_text(path: str | Path, text: str) -> None:
    """Write UTF-8 text atomically, with line feeds as line ends."""
    with atomic(path) as aside:
        aside.write_text(text, encoding="utf-8", newline="\n")


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write bytes atomically."""
    with atomic(path) as aside:
        aside.write_bytes(data)
