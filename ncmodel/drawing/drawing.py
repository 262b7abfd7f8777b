"""A drawing: strokes on a picture plane, what they show, and how they are written."""

from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

from ncmodel.camera import Camera
from ncmodel.drawing.plan import Plan
from ncmodel.errors import UsageError
from ncmodel.export.page import WIDTH, Picture
from ncmodel.export.pdf import pdf
from ncmodel.export.png import ink, png
from ncmodel.export.svg import svg
from ncmodel.files import check_writable, write_bytes
from ncmodel.types import Image, Stroke, Trace

SUFFIXES = (".svg", ".png", ".pdf")
"""The file formats that a drawing is written in."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """Strokes on a picture plane; shows itself in a notebook.

    Attributes:
        camera: What it was drawn through, and its size.
        strokes: The lines.
        name: The shape's name.
        plan: What it shows.
        notes: What the reader should know about how it came to be.
        trace: What was computed, and how long it took.
    """

    camera: Camera
    strokes: tuple[Stroke, ...]
    name: str = "drawing"
    plan: Plan = field(default_factory=Plan)
    notes: tuple[str, ...] = ()
    trace: Trace = field(default_factory=Trace)

    @property
    def width(self) -> int:
        """Pixels."""
        return self.camera.width

    @property
    def height(self) -> int:
        """Pixels."""
        return self.camera.height

    def ink(self, width: float = WIDTH) -> Image:
        """(H, W) ink in [0, 1].

        Args:
            width: Line width, in pixels of a picture whose shorter side is 768; lines grow with the picture.
        """
        return ink(self.picture(width))

    def svg(self, width: float = WIDTH, background: str | None = None) -> str:
        """The drawing as an SVG document; arguments as for `save`."""
        return svg(self.picture(width, background))

    def save(self, path: str | Path, width: float = WIDTH, background: str | None = None) -> None:
        """Write an .svg, .png or .pdf file.

        Args:
            path: Where to; the suffix says in which format.
            width: Line width, in pixels of a picture whose shorter side is 768; lines grow with the picture.
            background: "#rrggbb", "white", "black" or "transparent"; None paints none in vector files, white in PNG.

        Raises:
            UsageError: The suffix, the width or the background is something else.
            InputError: There is no such folder.
        """
        check_output(path)
        writers = {".svg": lambda p: svg(p).encode(), ".png": png, ".pdf": pdf}
        write_bytes(path, writers[Path(path).suffix.lower()](self.picture(width, background)))

    def picture(self, width: float = WIDTH, background: str | None = None) -> Picture:
        """The strokes with a line width and a background."""
        return Picture(self.width, self.height, self.strokes, width, background, self.name, self.plan.hidden == "layer")

    def sorted_for_pen(self) -> Self:
        """The same drawing with each group's strokes in an order that keeps the pen's way in the air short."""
        from ncmodel.export.linesort import pen_order

        groups = dict.fromkeys(stroke.group for stroke in self.strokes)
        ordered = [pen_order([s for s in self.strokes if s.group == group]) for group in groups]
        return replace(self, strokes=tuple(stroke for strokes in ordered for stroke in strokes))

    def __repr__(self) -> str:
        counts = Counter(stroke.group for stroke in self.strokes)
        lines = ", ".join(f"{count} {family}" for family, count in counts.items()) or "none"
        return f"Drawing({self.name!r}, {self.width} x {self.height}, strokes: {lines})"

    def _repr_svg_(self) -> str:
        # On white paper: black lines on a notebook's dark page wouldn't show.
        return self.svg(background="white")


def check_output(path: str | Path) -> None:
    """Raise if no drawing can be written there.

    Raises:
        UsageError: The suffix is none of `SUFFIXES`.
        InputError: There is no such folder, or the path is a device.
    """
    if Path(path).suffix.lower() not in SUFFIXES:
        found = f"the suffix is {Path(path).suffix!r}" if Path(path).suffix else "no suffix"
        raise UsageError(f"{path}: {found}, expected {', '.join(SUFFIXES)}, or an existing folder")
    check_writable(path)
