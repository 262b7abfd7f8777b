"""Files that are there whole or not at all, and those that nobody means."""

import fcntl
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from ncmodel.errors import InputError

_ASIDE = ".tmp-ncontours-"
"""Files that are being written are called so."""


_CLUTTER = {"__macosx", "$recycle.bin", "system volume information", "@eadir", "lost+found"}
"""Folders that systems add to others, in small letters."""


def is_clutter(name: str) -> bool:
    """Whether a file or folder of this name is hidden or left behind by a system (`._a.obj`, `.trash`, `__MACOSX`)."""
    return name.startswith((".", "~$")) or name.lower() in _CLUTTER


@contextmanager
def atomic(path: str | Path, private: bool = False) -> Iterator[Path]:
    """A path aside to write to, renamed to `path` when the block ends well and removed when it doesn't.

    The name aside keeps the suffix, so that writers which go by the suffix work. A file that is replaced keeps its
    permissions; of a link, what it leads to is replaced; into a pipe the finished content is written. What a process
    that was killed has left aside is removed by the next one that writes to that folder.

    Args:
        path: Where to.
        private: A file that wasn't there before is its owner's alone.

    Raises:
        InputError: There is no such folder, or the path is one, or a device.
        OSError: The folder can't be written.
    """
    target, mode = _destination(Path(path))
    into_pipe = mode is not None and stat.S_ISFIFO(mode)
    folder = Path(tempfile.gettempdir()) if into_pipe else target.parent
    _remove_leftovers(os.path.abspath(folder))
    try:
        handle, aside = _locked_aside(folder, target.suffix)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(target)) from error  # nobody knows the name aside
    try:
        yield aside
        if into_pipe:
            with aside.open("rb") as finished, target.open("wb") as pipe:
                shutil.copyfileobj(finished, pipe)
            aside.unlink()
        else:
            # Files aside are private; the finished one gets the usual permissions, or those of the one before.
            aside.chmod((0o600 if private else _usual_mode()) if mode is None else mode & 0o777)
            os.replace(aside, target)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise
    finally:
        os.close(handle)


def check_writable(path: str | Path) -> None:
    """Raise if `atomic` couldn't write there, before time is spent on what is to be written.

    Raises:
        InputError: There is no such folder, or the path is one, or a device.
    """
    _destination(Path(path))


def _destination(path: Path) -> tuple[Path, int | None]:
    """Where what is written to `path` goes, and the mode of what is there now, if anything is."""
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        mode = None
    if mode is not None and stat.S_ISFIFO(mode):
        return path, mode  # a shell's pipe is a link that leads to no path
    target = Path(os.path.realpath(path)) if path.is_symlink() else path
    if not target.parent.is_dir():
        raise InputError(path, f"there is no folder {target.parent}", "a folder that exists")
    if mode is not None and stat.S_ISDIR(mode):
        raise InputError(path, "a folder", "a file's name")
    if mode is not None and not stat.S_ISREG(mode):
        raise InputError(path, "a device", "a file's name, or a pipe")
    return target, mode


def _locked_aside(folder: Path, suffix: str) -> tuple[int, Path]:
    """A new private file, and its handle: as long as that is open, the file is somebody's."""
    while True:
        handle, name = tempfile.mkstemp(prefix=_ASIDE, suffix=suffix, dir=folder)
        _lock(handle)
        if os.fstat(handle).st_nlink:
            return handle, Path(name)
        os.close(handle)  # taken for a leftover before it was locked


def _lock(handle: int, how: int = 0) -> bool:
    """Lock a file; False if somebody else has, or on a file system without locks, where no leftover is known."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | how)
    except OSError:
        return False
    return True


@cache
def _remove_leftovers(folder: str) -> None:
    """Remove the files aside that no living process has locked; once a process, for folders may hold many files."""
    with suppress(OSError):
        names = [entry.path for entry in os.scandir(folder) if entry.name.startswith(_ASIDE)]
        for name in names:
            with suppress(OSError):  # somebody else's, or gone
                handle = os.open(name, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
                try:
                    if _lock(handle, fcntl.LOCK_NB):
                        os.unlink(name)
                finally:
                    os.close(handle)


def _usual_mode() -> int:
    umask = os.umask(0)
    os.umask(umask)
    return 0o666 & ~umask


def write_text(path: str | Path, text: str) -> None:
    """Write UTF-8 text atomically, with line feeds as line ends."""
    with atomic(path) as aside:
        aside.write_text(text, encoding="utf-8", newline="\n")


def write_bytes(path: str | Path, data: bytes, private: bool = False) -> None:
    """Write bytes atomically; `private` as for `atomic`."""
    with atomic(path, private) as aside:
        aside.write_bytes(data)
