"""Reports: one HTML file with everything in it, which opens from disk without a network.

A report is a title and sections; a section holds blocks: text, facts, tables, grids of pictures, plots, links to
other pages, and parts that fold away. The page's template decides how they look; those who write reports only say what
is in them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, Literal

from ncmodel.files import write_text
from ncmodel.images import Pixels
from ncmodel.report.contact_sheet import Tile, data_uri
from ncmodel.report.plots import Plot

GRID_PICTURE_SIDE = 512
"""Pictures in a grid are embedded with this longest side at most: sharp at twice the size they are shown at."""


@dataclass(frozen=True)
class Text:
    """A paragraph.

    Attributes:
        text: Plain text.
        tone: "note" for asides, "warning" for what the reader must know (simulated votes, failed items).
    """

    kind: ClassVar[str] = "text"
    text: str
    tone: Literal["plain", "note", "warning"] = "plain"


@dataclass(frozen=True)
class Facts:
    """Names with their values: settings, versions, counts."""

    kind: ClassVar[str] = "facts"
    items: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Cell:
    """A table's cell.

    Attributes:
        text: What is shown.
        value: What the column is sorted by; a cell with a value is set to the right, as numbers are.
        best: Shown in bold.
        note: Smaller, behind the text: an interval, a unit.
    """

    text: str
    value: float | None = None
    best: bool = False
    note: str = ""


@dataclass(frozen=True)
class Table:
    """A table that the reader can sort by any column; the first cell of a row names it.

    Attributes:
        columns: Headings.
        rows: Cells or plain strings, as many as there are columns.
        caption: What the table shows.
    """

    kind: ClassVar[str] = "table"
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell | str]]
    caption: str = ""

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows):
            if len(row) != len(self.columns):
                raise ValueError(f"row {number} has {len(row)} cells for {len(self.columns)} columns")

    @property
    def cells(self) -> list[list[Cell]]:
        """The rows with plain strings made cells."""
        return [[cell if isinstance(cell, Cell) else Cell(cell) for cell in row] for row in self.rows]


@dataclass(frozen=True)
class Grid:
    """Pictures side by side.

    Attributes:
        tiles: The pictures, in reading order.
        title: A heading above them.
        columns: How many in a row on a wide screen; as many as fit by default.
        max_side: Longest side of the embedded pictures, pixels.
    """

    kind: ClassVar[str] = "grid"
    tiles: Sequence[Tile]
    title: str = ""
    columns: int | None = None
    max_side: int = GRID_PICTURE_SIDE

    def uri(self, pixels: Pixels) -> str:
        """A tile's pixels as embedded in the page."""
        return data_uri(pixels, self.max_side)


@dataclass(frozen=True)
class Fold:
    """Blocks behind a line that the reader opens: long lists, details."""

    kind: ClassVar[str] = "fold"
    summary: str
    blocks: "Sequence[Block]"


@dataclass(frozen=True)
class Links:
    """Other pages of the report, files beside it.

    Attributes:
        items: What is there, and where from this page: a relative path.
    """

    kind: ClassVar[str] = "links"
    items: Sequence[tuple[str, str]]


Block = Text | Facts | Table | Grid | Plot | Links | Fold


@dataclass(frozen=True)
class Section:
    """A headed part of a report."""

    title: str
    blocks: Sequence[Block] = field(default_factory=list)


def render(title: str, sections: Sequence[Section], lead: str = "", reload: int | None = None) -> str:
    """The report as an HTML document.

    Args:
        title: Heading and window title.
        sections: Its parts.
        lead: A paragraph below the heading: what this is, what was measured.
        reload: Seconds after which the page loads itself anew, for one that is written again and again.
    """
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("ncmodel.report", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    template = environment.get_template("report.html.j2")
    return template.render(title=title, sections=sections, lead=lead, reload=reload)


def write_report(
    path: str | Path, title: str, sections: Sequence[Section], lead: str = "", reload: int | None = None
) -> None:
    """Write the report as one HTML file, atomically; parameters as `render` has them."""
    write_text(path, render(title, sections, lead, reload))
