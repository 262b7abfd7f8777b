"""Pictures as files: which formats there are, and each one's writer."""

from collections.abc import Callable, Sequence
from pathlib import Path

from ncmodel.errors import UsageError
from ncmodel.export.dxf import dxf
from ncmodel.export.page import Picture
from ncmodel.export.pdf import pdf
from ncmodel.export.png import png
from ncmodel.export.svg import svg
from ncmodel.files import check_writable, write_bytes

PICTURES = (".svg", ".png", ".pdf")
"""The file formats of pictures."""
SUFFIXES = (*PICTURES, ".dxf", ".json")
"""The file formats that a drawing is written in: pictures, lines for CAD, and strokes as data."""
CURVED = (".svg", ".pdf")
"""The file formats that have curves."""
RECORDED = (".svg", ".pdf")
"""The file formats that keep how a picture was made."""
PAGES = (".svg", ".pdf", ".dxf")
"""The file formats that have a size on paper."""

_WRITERS: dict[str, Callable[[Picture], bytes]] = {
    ".svg": lambda picture: svg(picture).encode(),
    ".png": png,
    ".pdf": pdf,
    ".dxf": dxf,
}


def write_picture(path: str | Path, picture: Picture) -> None:
    """Write an .svg, .png, .pdf or .dxf file; a page with a size on paper isn't written as pixels.

    Raises:
        UsageError: The suffix is something else.
        InputError: There is no such folder.
    """
    check_output(path, PAGES if picture.physical else tuple(_WRITERS))
    write_bytes(path, _WRITERS[Path(path).suffix.lower()](picture))


def check_output(path: str | Path, suffixes: Sequence[str] = SUFFIXES) -> None:
    """Raise if no drawing can be written there.

    Args:
        path: Where to.
        suffixes: Of the formats that there are for it.

    Raises:
        UsageError: The suffix is none of `suffixes`.
        InputError: There is no such folder, or the path is a device.
    """
    if Path(path).suffix.lower() not in suffixes:
        found = f"the suffix is {Path(path).suffix!r}" if Path(path).suffix else "no suffix"
        raise UsageError(f"{path}: {found}, expected {', '.join(suffixes)}, or an existing folder")
    check_writable(path)
