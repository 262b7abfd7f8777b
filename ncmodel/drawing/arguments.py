"""What a caller may ask of a drawing: brought into one form, or refused in one line."""

import math
from collections.abc import Iterable, Mapping
from numbers import Real
from typing import Any

from ncmodel.drawing.thresholding import check_thresholds
from ncmodel.errors import UsageError
from ncmodel.types import FILTERED_FAMILIES, LineFamily, Thresholds

Lines = Iterable[LineFamily | str]
"""Families or their names; as one string, separated by commas."""


def families(lines: Lines) -> tuple[LineFamily, ...]:
    """The families, each once.

    Raises:
        UsageError: One is unknown.
    """
    names = lines.replace(" ", "").split(",") if isinstance(lines, str) else lines
    if not isinstance(names, Iterable):
        raise UsageError(f"lines: found {lines!r}, expected some of {', '.join(LineFamily)}")
    return tuple(dict.fromkeys(map(_family, names)))


def _family(name: LineFamily | str) -> LineFamily:
    try:
        return LineFamily(name)
    except ValueError:
        raise UsageError(f"lines: unknown family {name!r}, expected some of {', '.join(LineFamily)}") from None


def thresholds_of(values: Thresholds | Mapping[str, float | None] | None) -> Thresholds | None:
    """Thresholds, also from a mapping of those that aren't rtsc's defaults.

    Raises:
        UsageError: One can't be compared with anything, or its family has no threshold.
    """
    if isinstance(values, Mapping):
        names = {str(name): value for name, value in values.items()}
        strange = [name for name in names if name not in set(FILTERED_FAMILIES)]
        if strange:
            raise UsageError(f"thresholds: found {strange[0]!r}, expected some of {', '.join(FILTERED_FAMILIES)}")
        values = Thresholds().with_values(**names)
    if values is None:
        return None
    expect("thresholds", values, Thresholds, "Thresholds or a dictionary of them")
    for family in FILTERED_FAMILIES:
        value = values.of(family)
        if value is not None:
            number(f"thresholds: {family}", value, "a number >= 0", finite=False)
    check_thresholds(values)
    return values


def size_of(size: int | tuple[int, int]) -> tuple[int, int]:
    """(width, height), of a square for one number.

    Raises:
        UsageError: Not one or two whole numbers.
    """
    given: Any = size
    sides = (given, given) if isinstance(given, Real) else tuple(given) if isinstance(given, Iterable) else ()
    if len(sides) != 2 or not all(isinstance(side, Real) and float(side).is_integer() for side in sides):
        raise UsageError(f"size: found {size!r}, expected pixels, or a width and a height")
    return int(sides[0]), int(sides[1])


def number(name: str, value: Any, expected: str, finite: bool = True) -> None:
    """Raise if a value isn't a number.

    Raises:
        UsageError: It isn't, or it isn't finite where it should be.
    """
    if not isinstance(value, Real) or (finite and not math.isfinite(value)):
        raise UsageError(f"{name}: found {value!r}, expected {expected}")


def expect(name: str, value: Any, kind: type | tuple[type, ...], expected: str) -> None:
    """Raise if a value is of another kind.

    Raises:
        UsageError: It is.
    """
    if not isinstance(value, kind):
        raise UsageError(f"{name}: found {type(value).__name__}, expected {expected}")
