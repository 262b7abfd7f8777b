"""References as people hand them in: pencil, grey paper, white on black, brought to black ink on white paper."""

from pathlib import Path

import numpy as np

from eval.measures.thinning import DEFAULT_THRESHOLD, binarise
from ncmodel.errors import InputError
from ncmodel.images import read_grey
from ncmodel.types import Image

MOST_INK = 1 / 3
"""Share of a picture that lines may cover: more is a shaded picture, a mask, or the wrong way round."""

_WHITE, _BLACK = 0.9, 0.3
"""Brightness of paper and of lines from which on a picture is taken as it is."""

_LEAST_CONTRAST = 0.15
"""Between lines and paper; less is the paper itself."""

_SPECKS = (20, 0.0005)
"""Pixels, at least so many and this share of all, that may be darker than the lines: dirt, noise."""


def read_reference(path: str | Path) -> Image:
    """(H, W) ink of a reference, 1 = line.

    Dark lines on white paper are taken as they are. Otherwise ink is 0 at the paper's brightness (the median: lines
    cover less than half) and 1 at that of the lines, which are what differs most from the paper, on either side.

    Raises:
        InputError: The file is missing or no picture.
    """
    brightness = read_grey(path)
    paper = float(np.median(brightness))
    least, share = _SPECKS
    aside = min(max(least, round(share * brightness.size)), (brightness.size - 1) // 4)
    levels = np.partition(brightness.ravel(), (aside, brightness.size - 1 - aside))
    darkest, lightest = float(levels[aside]), float(levels[-1 - aside])
    dark_lines = paper - darkest >= lightest - paper
    contrast = paper - darkest if dark_lines else lightest - paper
    if contrast < _LEAST_CONTRAST or (dark_lines and paper >= _WHITE and darkest <= _BLACK):
        return np.asarray(1.0 - brightness, dtype=np.float32)
    depth = paper - brightness if dark_lines else brightness - paper
    return np.asarray(np.clip(depth / contrast, 0.0, 1.0), dtype=np.float32)


def read_lines(path: str | Path, threshold: float = DEFAULT_THRESHOLD) -> Image:
    """`read_reference` of a picture that must be lines on paper.

    Args:
        path: The picture.
        threshold: Ink from which on a pixel counts as drawn.

    Raises:
        InputError: The file is missing, no picture, or more than `MOST_INK` of it is ink.
    """
    ink = read_reference(path)
    share = ink_share(ink, threshold)
    if share > MOST_INK:
        raise InputError(path, f"{share:.0%} of it is ink", "lines on paper, at most a third of it ink")
    return ink


def ink_share(ink: Image, threshold: float = DEFAULT_THRESHOLD) -> float:
    """Share of a picture that counts as drawn."""
    return float(binarise(ink, threshold).mean())
