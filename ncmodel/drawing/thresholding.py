"""Thresholds: from all lines of a family to the pieces that a threshold leaves, with their opacity.

In rtsc's units a threshold is compared with the dimensionless strength x = scale * feature / denominator:

* suggestive contours are cut where x falls below t; alpha = (x - t) / (x - t + 0.03)  (DeCarlo et al. 2003, in rtsc);
* ridges, valleys and apparent ridges are left out where both ends are below t; alpha = max(1 - t/x, 0).

The published code has the same two ways to fade, from a strength of its own (`Threshold.measured`).

In units of the 90th percentile, all four are faded as the paper's equations 1-4: alpha = max(1 - t p90/feature, 0), and
cut where that reaches 0. The other families have no threshold and full opacity.
"""

import math

import numpy as np

from ncmodel.types import (
    EVERYTHING,
    FILTERED_FAMILIES,
    SUGGESTIVE_FADE,
    Floats,
    LineFamily,
    LineSet,
    Mask,
    Segments,
    Threshold,
)


def survivors(lines: LineSet, threshold: Threshold) -> Mask:
    """(S,) True for the segments of which `threshold` leaves anything.

    Args:
        lines: All lines of a family, at threshold 0.
        threshold: The family's.
    """
    if lines.family not in FILTERED_FAMILIES:
        return np.ones(len(lines), dtype=np.bool_)
    lines = threshold.measured(lines)
    limit = threshold.limit(lines)
    if math.isinf(limit):
        return np.zeros(len(lines), dtype=np.bool_)
    if _suggestive_in_rtsc(lines, threshold):
        excess = lines.feature - limit * lines.denominator
        return np.asarray(((excess >= 0) == (lines.denominator >= 0)).any(axis=1))
    if threshold.unit == "p90" and threshold.value == 0.0:
        return np.ones(len(lines), dtype=np.bool_)
    return np.asarray((lines.feature > limit).any(axis=1))


def fade(lines: LineSet, threshold: Threshold = EVERYTHING) -> Segments:
    """The pieces of lines that a threshold leaves, with their opacity.

    Args:
        lines: All lines of a family, at threshold 0.
        threshold: The family's.
    """
    kept = threshold.measured(lines.take(survivors(lines, threshold)))
    if lines.family not in FILTERED_FAMILIES:
        alpha = np.ones_like(kept.feature)
    elif _suggestive_in_rtsc(lines, threshold):
        kept, alpha = _fade_suggestive(kept, threshold.limit(kept))
    else:
        limit = threshold.limit(kept)
        if threshold.unit == "p90":
            kept = _cut(kept, kept.feature - limit)
        alpha = _inverse_fade(kept.feature, limit)
    return Segments(lines.family, kept.points, alpha, kept.face)


def _suggestive_in_rtsc(lines: LineSet, threshold: Threshold) -> bool:
    return lines.family is LineFamily.SUGGESTIVE and threshold.unit != "p90"


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
