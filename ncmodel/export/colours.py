"""Colours of paper and lines."""

import re

from ncmodel.errors import ArgumentError
from ncmodel.types import HIDDEN_GROUP, LineFamily

Colour = tuple[int, int, int]
"""Red, green and blue in 0..255."""

WHITE, BLACK = (255, 255, 255), (0, 0, 0)
_NAMED = {"white": WHITE, "black": BLACK}

PURE: dict[str, Colour] = {
    LineFamily.BOUNDARIES.value: (0, 0, 255),
    LineFamily.CREASES.value: (255, 0, 0),
    LineFamily.INTERSECTIONS.value: (255, 0, 255),
    LineFamily.SUGGESTIVE.value: (0, 160, 0),
    LineFamily.APPARENT.value: (255, 128, 0),
    LineFamily.RIDGES.value: (0, 160, 160),
    LineFamily.VALLEYS.value: (128, 0, 255),
    "image": (128, 96, 0),
    HIDDEN_GROUP: (128, 128, 128),
}
"""A colour of its own for each group of lines but contours, which have that of lines on the paper."""


def colour(name: str | None) -> Colour | None:
    """The colour of that name; None for None and "transparent".

    Raises:
        ArgumentError: `name` isn't a colour.
    """
    if name is None or name == "transparent":
        return None
    if name in _NAMED:
        return _NAMED[name]
    if isinstance(name, str) and re.fullmatch("#[0-9a-fA-F]{6}", name):
        value = int(name[1:], 16)
        return value >> 16, value >> 8 & 255, value & 255
    raise ArgumentError("background", repr(name), "#rrggbb, white, black or transparent")
