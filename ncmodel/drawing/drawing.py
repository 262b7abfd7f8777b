"""A drawing: strokes on a picture plane, what they show, and how they are written."""

from collections import Counter
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

from ncmodel.camera import Camera
from ncmodel.drawing.plan import Plan
from ncmodel.export.files import check_output, write_picture
from ncmodel.export.page import WIDTH, Picture
from ncmodel.export.png import ink
from ncmodel.export.stroke_data import StrokeData, stroke_data, strokes_json
from ncmodel.export.svg import svg
from ncmodel.files import write_bytes
from ncmodel.types import Image, Stroke, Trace

if TYPE_CHECKING:
    import pandas as pd


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

    def save(
        self,
        path: str | Path,
        width: float = WIDTH,
        background: str | None = None,
        *,
        colors: bool = False,
        curve: float = 0.0,
    ) -> None:
        """Write an .svg, .png, .pdf, .dxf or .json file; JSON holds the strokes as `strokes_frame` has them.

        Args:
            path: Where to; the suffix says in which format.
            width: Line width, in pixels of a picture whose shorter side is 768; lines grow with the picture.
            background: "#rrggbb", "white", "black" or "transparent"; None paints none in vector files, white in PNG.
                DXF and JSON have none.
            colors: Whether each family has a pure colour of its own, and no line fades.
            curve: Pixels that curves in SVG and PDF may stray from the strokes; with 0 these stay polylines.

        Raises:
            UsageError: The suffix, the width or the background is something else.
            InputError: There is no such folder.
        """
        check_output(path)
        picture = self.picture(width, background, colors, curve)
        if Path(path).suffix.lower() == ".json":
            write_bytes(path, strokes_json(self.name, self.strokes, self.camera).encode())
        else:
            write_picture(path, picture)

    def strokes_frame(self) -> "pd.DataFrame":
        """The strokes as a table, one a row; the columns are the attributes of `StrokeData`."""
        import pandas as pd

        columns = [column.name for column in fields(StrokeData)]
        rows = stroke_data(self.strokes, self.camera)
        return pd.DataFrame([[getattr(row, name) for name in columns] for row in rows], columns=columns)

    def picture(
        self, width: float = WIDTH, background: str | None = None, colors: bool = False, curve: float = 0.0
    ) -> Picture:
        """The page that is written; arguments as for `save`."""
        solid = self.plan.hidden == "layer"
        return Picture(self.width, self.height, self.strokes, width, background, self.name, solid, colors, curve)

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
