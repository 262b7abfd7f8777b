"""A page: strokes with their widths and shades, the same in SVG, PDF and PNG.

Vector files hold one group a family, faint families first. A stroke that tapers is cut into pieces of one shade each;
everything else is one path. Shades are colours between ink and paper, not opacities, and blended so that the stronger
one shows where strokes cross or pieces overlap, as they do by `OVERLAP`: a PNG is composited so; opacities would add.
Programs that know no blending paint the later stroke over the earlier one. Paper is left unpainted unless a background
is asked for; PNG files are black on white then.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ncmodel.errors import ArgumentError
from ncmodel.export.colours import BLACK, PURE, WHITE, Colour, colour
from ncmodel.export.tapers import pieces, whole
from ncmodel.types import HIDDEN_GROUP, Floats, LineFamily, Stroke

WIDTH = 2.5
"""Line width at 768 pixels, unless told otherwise."""
REFERENCE_SIDE = 768
"""The shorter side, in pixels, at which widths are stated; they grow with it."""
RELATIVE_WIDTH = {LineFamily.RIDGES.value: 0.8, LineFamily.VALLEYS.value: 0.8, HIDDEN_GROUP: 0.8}
"""Widths of groups relative to the others': ridges and valleys as rtsc draws them, 2 pixels where others have 2.5."""
DASH, SPACE = 3.0, 2.0
"""Lengths of the dashes of hidden lines and of what is between them, in widths."""

_GROUPS = (
    HIDDEN_GROUP,
    "image",
    "valleys",
    "ridges",
    "suggestive",
    "apparent",
    "intersections",
    "creases",
    "boundaries",
    "contours",
)
MILLIMETRES = 25.4 / 96.0
"""Per pixel, which is CSS's 1/96 inch, in all vector files."""
_LUMA = (0.299, 0.587, 0.114)


def page_scale(width: float, height: float) -> float:
    """How much larger lengths are than those stated for a picture whose shorter side is `REFERENCE_SIDE`."""
    return min(width, height) / REFERENCE_SIDE


def line_width(family: str, width: float, height: float, at_reference: float = WIDTH) -> float:
    """The width of a family's lines in a picture, pixels.

    Args:
        family: Its name.
        width: Of the picture, pixels.
        height: Likewise.
        at_reference: Width of lines where the shorter side is `REFERENCE_SIDE`.
    """
    return at_reference * RELATIVE_WIDTH.get(family, 1.0) * page_scale(width, height)


def legible_width(width: int, height: int) -> float:
    """The line width, stated for `REFERENCE_SIDE`, at which no line of a small picture is thinner than a pixel.

    It is `WIDTH` from 384 pixels on.
    """
    return max(WIDTH, 1.0 / (min(RELATIVE_WIDTH.values()) * page_scale(width, height)))


@dataclass(frozen=True)
class Label:
    """A word on a page.

    Attributes:
        text: What it says.
        place: Pixels, the middle of its base line.
        size: Pixels from line to line.
    """

    text: str
    place: tuple[float, float]
    size: float


@dataclass(frozen=True, eq=False)
class Picture:
    """Strokes on a page, ready to be written.

    Attributes:
        width: Pixels, whole ones if it becomes a PNG.
        height: Likewise.
        strokes: What is drawn.
        line_width: Pixels, for a picture whose shorter side is `REFERENCE_SIDE`.
        background: "#rrggbb", "white", "black"; None leaves the paper as it is (white, in a PNG) and "transparent" does
            so in a PNG, too.
        title: What is shown.
        solid: Whether hidden lines are solid in vector files, and not dashed.
        colours: Whether each group has a pure colour of its own, and no line fades.
        curve: Pixels that curves may stray from the strokes, in SVG and PDF; with 0 these stay polylines.
        physical: Whether the page has a size on paper, which files tell in units of length.
        labels: Words on it.
        record: How it was made, as JSON, for files that keep it; nothing by default.

    Raises:
        ArgumentError: The line width isn't a positive number, or the background is none of these.
    """

    width: float
    height: float
    strokes: Sequence[Stroke]
    line_width: float = WIDTH
    background: str | None = None
    title: str = "drawing"
    solid: bool = False
    colours: bool = False
    curve: float = 0.0
    physical: bool = False
    labels: tuple[Label, ...] = ()
    record: str = ""

    def __post_init__(self) -> None:
        if not 0.0 < self.line_width < np.inf:
            raise ArgumentError("width", str(self.line_width), "a positive number of pixels")
        colour(self.background)

    def width_of(self, family: str) -> float:
        """The width of a family's lines, in this picture's pixels."""
        return line_width(family, self.width, self.height, self.line_width)

    def dashes_of(self, group: str, pixels: bool = False) -> tuple[float, float] | None:
        """Lengths of dashes and of what is between them, in this picture's pixels; None for solid lines.

        Args:
            group: A family, or the hidden lines.
            pixels: Whether the file has no layers to tell lines apart.
        """
        if group != HIDDEN_GROUP or (self.solid and not pixels):
            return None
        width = self.width_of(group)
        return DASH * width, SPACE * width

    @property
    def inks(self) -> tuple[Colour, Colour]:
        """The colours of paper and lines: black on light paper, white on dark paper."""
        paper = colour(self.background) or WHITE
        return paper, BLACK if np.dot(paper, _LUMA) >= 127.5 else WHITE

    def colour_of(self, group: str) -> Colour:
        """The colour of a group's strongest lines."""
        return PURE.get(group, self.inks[1]) if self.colours else self.inks[1]

    def paths(self, group: str, strokes: Sequence[Stroke]) -> Iterator[tuple[Floats, Colour]]:
        """What vector files paint of a group's strokes: points (n, 2) and their colour."""
        if self.colours:
            for points in whole(strokes):
                yield points, self.colour_of(group)
        else:
            for points, opacity in pieces(strokes, self.width_of(group)):
                # The last piece of a taper may be a point, which shows nothing and has no curve.
                if len(points) > 1 or not self.curve:
                    yield points, self.shade(opacity)

    def shade(self, opacity: float) -> Colour:
        """The colour of a line of an opacity in [0, 1], where groups have no colours of their own."""
        paper, line = self.inks
        red, green, blue = (round(p + opacity * (q - p)) for p, q in zip(paper, line, strict=True))
        return red, green, blue

    @property
    def blending(self) -> str:
        """The blend mode, in CSS, in which the stronger of two shades shows."""
        return "darken" if self.inks[1] == BLACK else "lighten"

    def groups(self) -> Iterator[tuple[str, list[Stroke]]]:
        """Families that have visible strokes, and hidden lines, with their strokes, in the order of painting."""
        present = {stroke.group for stroke in self.strokes}
        for group in [name for name in _GROUPS if name in present] + sorted(present.difference(_GROUPS)):
            yield group, [stroke for stroke in self.strokes if stroke.group == group]
