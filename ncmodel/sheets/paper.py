"""Paper: its sizes, margins and scales, as a caller writes them."""

import math
import re
from dataclasses import dataclass

from ncmodel.errors import ArgumentError
from ncmodel.export.page import MILLIMETRES

SIZES = {
    "A0": (841.0, 1189.0),
    "A1": (594.0, 841.0),
    "A2": (420.0, 594.0),
    "A3": (297.0, 420.0),
    "A4": (210.0, 297.0),
    "A5": (148.0, 210.0),
    "A6": (105.0, 148.0),
    "letter": (215.9, 279.4),
    "legal": (215.9, 355.6),
    "tabloid": (279.4, 431.8),
}
"""Names of papers -> width and height upright, millimetres."""
LANDSCAPE = "-landscape"
LARGEST = 5000.0
"""Millimetres of the longest side of a paper."""

_UNITS = {"mm": 1.0, "cm": 10.0, "in": 25.4, "pt": 25.4 / 72.0, "px": MILLIMETRES}
_NUMBER = r"(\d+(?:\.\d*)?|\.\d+)"


@dataclass(frozen=True)
class Paper:
    """A paper and what is left empty along its edges.

    Attributes:
        width: Millimetres.
        height: Likewise.
        margin: Likewise, on each side.
    """

    width: float
    height: float
    margin: float

    def __post_init__(self) -> None:
        if not (0.0 < self.width <= LARGEST and 0.0 < self.height <= LARGEST):
            raise ArgumentError("page", f"{self.width:g} x {self.height:g} mm", f"sides of up to {LARGEST:g} mm")
        if not 2.0 * self.margin < min(self.width, self.height):
            found = f"{self.margin:g} mm on a page of {self.width:g} x {self.height:g} mm"
            raise ArgumentError("margin", found, "less than half of its shorter side")

    @property
    def inside(self) -> tuple[float, float]:
        """Width and height within the margins, millimetres."""
        return self.width - 2.0 * self.margin, self.height - 2.0 * self.margin


def paper_of(page: str, margin: str = "10mm") -> Paper:
    """A paper by its name, or its sides.

    Args:
        page: "A4", "letter", "A3-landscape", "200x300mm".
        margin: "10mm", "0.5in".

    Raises:
        ArgumentError: It is no paper, or nothing is left within its margins.
    """
    upright, lies = page.removesuffix(LANDSCAPE), page.endswith(LANDSCAPE)
    sides = {name.lower(): size for name, size in SIZES.items()}.get(upright.lower())
    written = re.fullmatch(rf"{_NUMBER}x{_NUMBER}(mm|cm|in)", upright)
    if sides is None and written is None:
        raise ArgumentError("page", repr(page), f"{', '.join(SIZES)}, one of them with {LANDSCAPE}, or 200x300mm")
    if written is not None:
        unit = _UNITS[written[3]]
        sides = float(written[1]) * unit, float(written[2]) * unit
    assert sides is not None, "one of both was found"
    width, height = reversed(sides) if lies else sides
    return Paper(width, height, length("margin", margin))


def length(name: str, text: str) -> float:
    """Millimetres of "10mm", "1cm", "0.5in", "36pt" or "96px".

    Args:
        name: Of the parameter.
        text: What it is given as.

    Raises:
        ArgumentError: It is no length.
    """
    found = re.fullmatch(rf"{_NUMBER} ?({'|'.join(_UNITS)})", text.strip())
    if found is None:
        raise ArgumentError(name, repr(text), f"a number and a unit of {', '.join(_UNITS)}")
    return float(found[1]) * _UNITS[found[2]]


def ratio(text: str) -> float:
    """Length on paper of what is 1 long, from "1:2" or "5:1".

    Raises:
        ArgumentError: It is no scale.
    """
    found = re.fullmatch(rf"{_NUMBER}:{_NUMBER}", text.strip())
    value = float(found[1]) / float(found[2]) if found and float(found[2]) > 0.0 else 0.0
    if not 0.0 < value < math.inf:
        raise ArgumentError("scale", repr(text), "paper:shape, as 1:2")
    return value
