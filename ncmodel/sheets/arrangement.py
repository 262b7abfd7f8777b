"""Where views go on a sheet: in third-angle projection each beside the side that it shows, in first-angle opposite.

Views in a row share their heights, those in a column their widths, so that edges line up.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ncmodel.camera import VIEWS, Camera
from ncmodel.errors import ArgumentError

ANGLES = ("third", "first")
GAP = 60.0
"""Pixels between rows and columns; all of these are for views that fill `VIEW_SIDE`."""
LABEL = 20.0
"""Pixels of letters, and as much below them as above."""
VIEW_SIDE = 768
"""Pixels of the frame in which the largest view just fits with its margin."""

_BESIDE = {"front": (0, 0), "left": (-1, 0), "right": (1, 0), "top": (0, -1), "bottom": (0, 1)}
"""View -> column and row in third-angle projection; those of first angle are on the other side."""


@dataclass(frozen=True)
class Cell:
    """A view's place on a sheet.

    Attributes:
        name: What it is called there; "" for a view without a label.
        camera: The view.
        extent: How far it reaches from its frame's middle: left, top, right and bottom, pixels, the first two negative.
        column: From the left.
        row: From the top.
    """

    name: str
    camera: Camera
    extent: tuple[float, float, float, float]
    column: int = 0
    row: int = 0


@dataclass(frozen=True)
class Arrangement:
    """Cells at a common scale.

    Attributes:
        cells: One at least.
    """

    cells: tuple[Cell, ...]

    @property
    def label(self) -> float:
        """Pixels below each row for its labels."""
        return 2.0 * LABEL if any(cell.name for cell in self.cells) else 0.0

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, pixels."""
        columns, rows = self._lines(0), self._lines(1)
        return columns[-1][1], rows[-1][1] + self.label

    def middle(self, cell: Cell) -> tuple[float, float]:
        """Where the middle of a cell's frame is, pixels from the arrangement's upper left corner."""
        columns, rows = self._lines(0), self._lines(1)
        return columns[cell.column][0], rows[cell.row][0]

    def foot(self, cell: Cell) -> tuple[float, float]:
        """The middle of the base line of a cell's label."""
        return self.middle(cell)[0], self._lines(1)[cell.row][1] + 1.5 * LABEL

    def _lines(self, axis: int) -> list[tuple[float, float]]:
        """Of each column (0) or row (1): where its views have their middles, and where it ends."""
        lines: list[tuple[float, float]] = []
        end = 0.0
        between = GAP + (self.label if axis else 0.0)
        for index in range(1 + max((cell.column, cell.row)[axis] for cell in self.cells)):
            own = [cell.extent for cell in self.cells if (cell.column, cell.row)[axis] == index]
            start = end + between if lines else 0.0
            middle = start - min(extent[axis] for extent in own)
            end = middle + max(extent[axis + 2] for extent in own)
            lines.append((middle, end))
        return lines


def names_of(views: str | Iterable[str]) -> tuple[str, ...]:
    """The views, each once.

    Raises:
        ArgumentError: One is unknown, or there is none.
    """
    given = [name.strip() for name in views.split(",")] if isinstance(views, str) else list(views)
    names = tuple(dict.fromkeys(name for name in given if name))
    odd = next((name for name in names if name not in VIEWS), None)
    if odd is not None or not names:
        raise ArgumentError("views", "no view" if odd is None else repr(odd), f"some of {','.join(VIEWS)}")
    return names


def places(names: Sequence[str], angle: str = "third") -> dict[str, tuple[int, int]]:
    """Column and row of each view, from the upper left, without empty columns and rows.

    `back` is next to the side view on the right; `iso` is in the corner between the top and a side.

    Raises:
        ArgumentError: The angle is neither "third" nor "first".
    """
    if angle not in ANGLES:
        raise ArgumentError("angle", repr(angle), f"one of {', '.join(ANGLES)}")
    side = 1 if angle == "third" else -1
    found = {name: (side * column, side * row) for name, (column, row) in _BESIDE.items()} | {
        "back": (2, 0),
        "iso": (side, -side),
    }
    chosen = {name: found[name] for name in names}
    columns, rows = (sorted({place[axis] for place in chosen.values()}) for axis in (0, 1))
    return {name: (columns.index(column), rows.index(row)) for name, (column, row) in chosen.items()}
