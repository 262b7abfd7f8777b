"""What a caller may ask of a drawing, in Python or at the command line: in one form, or refused in one line."""

import math
from collections.abc import Iterable, Mapping
from numbers import Real
from typing import Any, cast, get_args

from ncmodel.drawing.plan import CRUMB, DEFAULT_FAMILIES, Hidden, Plan
from ncmodel.errors import ArgumentError
from ncmodel.types import FILTERED_FAMILIES, LineFamily, Thresholds

Lines = Iterable[LineFamily | str]
"""Families or their names; as one string, separated by commas."""

ThresholdValues = Thresholds | Mapping[str, float | None] | str
"""Thresholds, or those of them that aren't the defaults: {"ridges": 0.2}, or "ridges=0.2,apparent=off"."""

OFF = "off"
"""Instead of a threshold: leaves the family out."""


def plan_of(
    lines: Lines | None = None,
    thresholds: ThresholdValues | None = None,
    detail: float = 1.0,
    min_length: float = 0.0,
    hidden: str = "none",
) -> Plan:
    """The plan that draws what was asked for.

    Whoever names thresholds sees what they leave, as it is found; whoever names families, all of their lines.

    Args:
        lines: The families; by default `DEFAULT_FAMILIES` and those that are given a threshold by name.
        thresholds: rtsc's defaults unless given.
        detail: Share of the lines inside the outline that is drawn, in 0..1.
        min_length: Pixels, at 768, of the shortest strokes, at least 0.
        hidden: What becomes of lines behind the surface: "none", "dashed" or "layer".

    Raises:
        ArgumentError: A family is unknown or has no threshold, a threshold can't be compared with anything, or a number
            is outside its range.
    """
    _check_range("detail", detail, 1.0, "a share from 0 (the outline) to 1 (all lines)")
    _check_range("min_length", min_length, math.inf, "pixels >= 0")
    if hidden not in get_args(Hidden):
        raise ArgumentError("hidden", repr(hidden), f"one of {', '.join(get_args(Hidden))}")
    if thresholds is None or isinstance(thresholds, Thresholds):
        named, values = {}, thresholds or Thresholds()
    else:
        named = _named(thresholds)
        values = Thresholds().with_values(**{family.value: value for family, value in named.items()})
    _check_thresholds(values)
    families = families_of(lines) if lines is not None else tuple(dict.fromkeys((*DEFAULT_FAMILIES, *named)))
    finished = thresholds is None
    crumb = CRUMB if finished and lines is None else 0.0
    return Plan(
        families,
        values,
        finished=finished,
        crumb=crumb,
        detail=float(detail),
        min_length=float(min_length),
        hidden=cast(Hidden, hidden),
    )


def families_of(lines: Lines) -> tuple[LineFamily, ...]:
    """The families, each once.

    Raises:
        ArgumentError: One is unknown, or there is none.
    """
    names = [name.strip() for name in lines.split(",") if name.strip()] if isinstance(lines, str) else lines
    if not isinstance(names, Iterable):
        raise ArgumentError("lines", repr(lines), f"some of {','.join(LineFamily)}")
    found = tuple(dict.fromkeys(map(_family, names)))
    if isinstance(lines, str) and not found:
        raise ArgumentError("lines", "no family", f"some of {','.join(LineFamily)}")
    return found


def _family(name: LineFamily | str) -> LineFamily:
    try:
        return LineFamily(name)
    except ValueError:
        raise ArgumentError("lines", repr(name), f"some of {','.join(LineFamily)}") from None


def _named(thresholds: Mapping[str, Any] | str) -> dict[LineFamily, float | None]:
    """Family -> threshold, as given; None leaves the family out."""
    expected = f"FAMILY=VALUE with {','.join(FILTERED_FAMILIES)}"
    if isinstance(thresholds, str):
        parts = [part.partition("=") for part in thresholds.split(",") if part.strip()]
        odd = next(("".join(part) for part in parts if not part[1]), None)
        if odd is not None:
            raise ArgumentError("thresholds", repr(odd.strip()), expected)
        pairs: Iterable[tuple[str, Any]] = [(name.strip(), _value(name, text.strip())) for name, _, text in parts]
    elif isinstance(thresholds, Mapping):
        pairs = [(str(name), None if value == OFF else value) for name, value in thresholds.items()]
    else:
        raise ArgumentError("thresholds", type(thresholds).__name__, "Thresholds or a dictionary of them")
    values: dict[LineFamily, float | None] = {}
    for name, value in pairs:
        if name not in set(FILTERED_FAMILIES):
            raise ArgumentError("thresholds", repr(name), expected)
        values[LineFamily(name)] = value
    return values


def _value(name: str, text: str) -> float | None:
    try:
        return None if text == OFF else float(text)
    except ValueError:
        raise ArgumentError("thresholds", f"{name.strip()}={text}", "a number or off") from None


def _check_thresholds(thresholds: Thresholds) -> None:
    """Raise if a threshold can't be compared with anything; an infinite one leaves no line."""
    for family in FILTERED_FAMILIES:
        value: Any = thresholds.value(family)
        if value is not None and not (isinstance(value, Real) and float(value) >= 0.0):
            raise ArgumentError("thresholds", f"{family}={value!r}", "a number >= 0")


def _check_range(name: str, value: Any, largest: float, expected: str) -> None:
    """Raise if a value isn't a number from 0 to `largest`."""
    number(name, value, expected)
    if not 0.0 <= value <= largest:
        raise ArgumentError(name, repr(value), expected)


def size_of(size: int | tuple[int, int] | str) -> tuple[int, int]:
    """(width, height), of a square for one number; "WxH" is understood, too.

    Raises:
        ArgumentError: Not one or two whole numbers.
    """
    given: Any = size
    if isinstance(given, str):
        parts = given.lower().split("x")
        given = [int(part) for part in parts] if all(part.strip().isdecimal() for part in parts) else []
        given = given * 2 if len(given) == 1 else given
    sides = (given, given) if isinstance(given, Real) else tuple(given) if isinstance(given, Iterable) else ()
    if len(sides) != 2 or not all(isinstance(side, Real) and float(side).is_integer() for side in sides):
        raise ArgumentError("size", repr(size), "pixels, N or WxH")
    return int(sides[0]), int(sides[1])


def number(name: str, value: Any, expected: str) -> None:
    """Raise if a value isn't a finite number.

    Raises:
        ArgumentError: It isn't.
    """
    if not isinstance(value, Real) or not math.isfinite(value):
        raise ArgumentError(name, repr(value), expected)


def expect(name: str, value: Any, kind: type | tuple[type, ...], expected: str) -> None:
    """Raise if a value is of another kind.

    Raises:
        ArgumentError: It is.
    """
    if not isinstance(value, kind):
        raise ArgumentError(name, type(value).__name__, expected)
