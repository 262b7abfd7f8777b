"""Thresholds: from all lines of a family to the pieces that a threshold leaves, with their opacity.

In rtsc's units a threshold is compared with the dimensionless strength x = scale * feature / denominator:

* suggestive contours are cut where x falls below t; alpha = (x - t) / (x - t + 0.03)  (DeCarlo et al. 2003, in rtsc);
* ridges, valleys and apparent ridges are left out where both ends are below t; alpha = max(1 - t/x, 0).

In units of the 90th percentile, all four are faded as the paper's equations 1-4: alpha = max(1 - t p90/feature, 0), and
cut where that reaches 0. The other families have no threshold and full opacity.
"""

import math
from typing import Literal

import numpy as np

from ncmodel.errors import UsageError
from ncmodel.types import FILTERED_FAMILIES, SUGGESTIVE_FADE, Floats, LineFamily, LineSet, Mask, Segments, Thresholds

Unit = Literal["rtsc", "p90"]


def check_thresholds(thresholds: Thresholds) -> None:
    """Raise if a threshold can't be compared with anything.

    Raises:
        UsageError: A threshold is negative or not a number. (An infinite one is fine: it leaves no line.)
    """
    for family in FILTERED_FAMILIES:
        value = thresholds.of(family)
        if value is not None and not value >= 0.0:
            raise UsageError(f"thresholds: {family} is {value}, expected a number >= 0")


def survivors(lines: LineSet, threshold: float, unit: Unit = "rtsc", p90: float = 1.0) -> Mask:
    """(S,) True for the segments of which `threshold` leaves anything.

    Args:
        lines: All lines of a family, at threshold 0.
        threshold: At least 0, in `unit`.
        unit: What the threshold is measured in.
        p90: The 90th percentile of the family's feature map, for the unit "p90".
    """
    if lines.family not in FILTERED_FAMILIES:
        return np.ones(len(lines), dtype=np.bool_)
    limit = _limit(lines, threshold, unit, p90)
    if math.isinf(limit):
        return np.zeros(len(lines), dtype=np.bool_)
    if lines.family is LineFamily.SUGGESTIVE and unit == "rtsc":
        excess = lines.feature - limit * lines.denominator
        return np.asarray(((excess >= 0) == (lines.denominator >= 0)).any(axis=1))
    if unit == "p90" and threshold == 0.0:
        return np.ones(len(lines), dtype=np.bool_)
    return np.asarray((lines.feature > limit).any(axis=1))


def fade(lines: LineSet, threshold: float, unit: Unit = "rtsc", p90: float = 1.0) -> Segments:
    """The pieces of lines that a threshold leaves, with their opacity.

    Args:
        lines: All lines of a family, at threshold 0.
        threshold: At least 0, in `unit`.
        unit: What the threshold is measured in.
        p90: The 90th percentile of the family's feature map, for the unit "p90".
    """
    kept = lines.take(survivors(lines, threshold, unit, p90))
    if lines.family not in FILTERED_FAMILIES:
        alpha = np.ones_like(kept.feature)
    elif lines.family is LineFamily.SUGGESTIVE and unit == "rtsc":
        kept, alpha = _fade_suggestive(kept, threshold / lines.scale)
    else:
        limit = _limit(lines, threshold, unit, p90)
        if unit == "p90":
            kept = _cut(kept, kept.feature - limit)
        alpha = _inverse_fade(kept.feature, limit)
    return Segments(lines.family, kept.points, alpha, kept.face)


def _limit(lines: LineSet, threshold: float, unit: Unit, p90: float) -> float:
    """The feature value where `threshold` makes a line vanish."""
    return threshold * p90 if unit == "p90" else threshold / lines.scale


def _inverse_fade(feature: Floats, limit: float) -> Floats:
    """max(1 - limit/feature, 0); 1 everywhere for a limit of 0."""
    if limit == 0.0:
        return np.ones_like(feature)
    return np.maximum(1.0 - limit / np.maximum(feature, limit), 0.0)


def _fade_suggestive(lines: LineSet, limit: float) -> tuple[LineSet, Floats]:
    """Suggestive contours where num/den >= limit, with opacity excess/(excess + fade den), of which 0/0 reads as 1."""
    # Along a segment den keeps its sign and num is linear, so the part above the limit is one piece.
    sign = np.where(lines.denominator.sum(axis=1, keepdims=True) >= 0, 1.0, -1.0)
    lines = _cut(lines, sign * (lines.feature - limit * lines.denominator))
    excess = np.maximum(sign * (lines.feature - limit * lines.denominator), 0.0)
    total = excess + SUGGESTIVE_FADE / lines.scale * np.abs(lines.denominator)
    return lines, np.where(total > 0, excess / np.where(total > 0, total, 1.0), 1.0)


def _cut(lines: LineSet, value: Floats) -> LineSet:
    """The parts where `value` (S, 2), linear along each segment and not negative at both ends, is above 0."""
    first, second = value[:, 0], value[:, 1]
    crossing = (first < 0) != (second < 0)
    at = np.where(crossing, first / np.where(crossing, first - second, 1.0), 0.0)
    start = np.where(crossing & (first < 0), at, 0.0)
    end = np.where(crossing & (second < 0), at, 1.0)
    return lines.between(np.arange(len(lines)), start, end)
