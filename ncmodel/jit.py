"""Compiled functions, and where the compiled code is kept from one start to the next.

numba recompiles a function when its own file changes, but not when another file does whose functions and constants it
has compiled in: after an upgrade it would go on with a mixture of both versions. So each module's code is kept in a
folder named after the contents of all files of the package that the module imports, directly or not.

The folder lies beside the module, in `__pycache__`; where that can't be written (an installation of another user's), in
the user's cache; and if that can't be either, code is compiled anew at every start, which a warning says. A folder
named by the environment variable NUMBA_CACHE_DIR goes before all.
"""

import atexit
import hashlib
import os
import re
import shutil
import tempfile
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

PACKAGE = Path(__file__).parent

Function = TypeVar("Function", bound=Callable[..., Any])

_IMPORT = re.compile(r"^(?:from|import) ncmodel\.([\w.]+)", re.MULTILINE)


def kernel(function: Function) -> Function:
    """Compile a function on first use and keep the code; it runs without Python's lock and divides as NumPy does."""
    source = Path(function.__code__.co_filename)
    config: Any = numba.config
    chosen = config.CACHE_DIR
    # numba asks where to keep a function's code when it is decorated, and never again.
    config.CACHE_DIR = str(_folder(source, chosen))
    try:
        return cast(Function, numba.njit(cache=True, nogil=True, error_model="numpy")(function))
    finally:
        config.CACHE_DIR = chosen


@cache
def _folder(source: Path, chosen: str) -> Path:
    """Where the compiled functions of a module are kept."""
    name = f"{source.stem}-{fingerprint(source)}"
    for root in _roots(source, chosen):
        folder = root / name
        try:
            fresh = not folder.exists()
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError:
            continue
        if fresh and not chosen:
            _drop_others(folder, source.stem)
        return folder
    return _passing_folder() / name


def _roots(source: Path, chosen: str) -> Iterator[Path]:
    if chosen:
        yield Path(chosen) / "ncontours"
        return
    yield source.parent / "__pycache__"
    place = hashlib.sha256(str(PACKAGE).encode()).hexdigest()[:8]
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    yield Path(home) / "ncontours" / place


def _drop_others(folder: Path, module: str) -> None:
    """Remove what earlier versions of a module left beside its folder."""
    for old in folder.parent.glob(f"{module}-{'[0-9a-f]' * 16}"):
        if old != folder:
            shutil.rmtree(old, ignore_errors=True)


@cache
def _passing_folder() -> Path:
    """A private folder that goes when the process ends."""
    warnings.warn(
        "compiled code can't be kept, so every start takes longer: neither the installation nor the user's cache can "
        "be written; set NUMBA_CACHE_DIR to a folder that can",
        RuntimeWarning,
        stacklevel=2,
    )
    folder = tempfile.mkdtemp(prefix="ncontours")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def fingerprint(source: Path) -> str:
    """Of the contents of a file and of all files of the package that it imports, directly or not."""
    digest = hashlib.sha256()
    for path in sorted(_imported(source)):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def _imported(source: Path) -> set[Path]:
    found, queue = {source}, [source]
    while queue:
        for name in _IMPORT.findall(queue.pop().read_text(encoding="utf-8")):
            path = PACKAGE.joinpath(*name.split(".")).with_suffix(".py")
            if path.is_file() and path not in found:
                found.add(path)
                queue.append(path)
    return found
