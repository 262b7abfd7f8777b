"""How close a synthetic drawing is to a reference: precision, recall, F1, IoU and symmetric Chamfer distance.

With A the synthetic drawing's pixels, B the reference's (both thinned to one pixel), and near(A, B) the pixels of A
within the tolerance of some pixel of B (Cole et al. 2008, Liu et al. 2020):

    precision = near(A, B) / |A|        recall = near(B, A) / |B|
    IoU = (near(A, B) + near(B, A)) / (|A| + |B|)

and `ncmodel.chamfer` has the symmetric Chamfer distance, in pixels.

F1 is the harmonic mean of precision and recall. Over many drawings all others are averaged, and F1 is that of the mean
precision and the mean recall.

Empty drawings: two empty ones agree (ratios 1, Chamfer 0). If only one is empty, all ratios are 0, since a drawing that
shows nothing must not gain by it, and Chamfer is the picture's diagonal.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from ncmodel.chamfer import Lines, chamfer_distance
from ncmodel.errors import ArgumentError
from ncmodel.types import Image, Mask


@dataclass(frozen=True)
class Measures:
    """One comparison, or the mean of many.

    Attributes:
        precision: Share of the synthetic pixels near the reference, 0..1.
        recall: Share of the reference's pixels near the synthetic drawing, 0..1.
        f1: Harmonic mean of precision and recall, 0..1.
        iou: Share of all pixels that are near the other drawing, 0..1.
        chamfer: Symmetric mean distance, pixels; the only one that is better when lower.
    """

    precision: float
    recall: float
    f1: float
    iou: float
    chamfer: float


MEASURES = tuple(field.name for field in fields(Measures))
LOWER_IS_BETTER = frozenset(["chamfer"])


def compare_lines(synthetic: Lines, reference: Lines, tolerance: float) -> Measures:
    """All measures of one drawing against one reference.

    Args:
        synthetic: The drawing that is judged.
        reference: The drawing it is judged by.
        tolerance: Pixels up to which two pixels are near each other; 0 asks for the same pixel.

    Raises:
        ValueError: The two have different sizes, or the tolerance is negative or not a number.
    """
    if not tolerance >= 0.0:
        raise ValueError(f"the tolerance is {tolerance} pixels, expected 0 or more")
    chamfer = chamfer_distance(synthetic, reference)
    if synthetic.empty or reference.empty:
        ratio = 1.0 if synthetic.empty and reference.empty else 0.0
        return Measures(ratio, ratio, ratio, ratio, chamfer)
    to_reference = reference.distance[synthetic.mask]
    to_synthetic = synthetic.distance[reference.mask]
    near_reference = _count_near(to_reference, tolerance)
    near_synthetic = _count_near(to_synthetic, tolerance)
    precision = near_reference / len(to_reference)
    recall = near_synthetic / len(to_synthetic)
    iou = (near_reference + near_synthetic) / (len(to_reference) + len(to_synthetic))
    return Measures(precision, recall, f1_score(precision, recall), iou, chamfer)


def measure(synthetic: Mask, reference: Mask, tolerance: float) -> Measures:
    """All measures of one thin mask against another; see `compare_lines`."""
    return compare_lines(Lines.of(synthetic), Lines.of(reference), tolerance)


def f1_score(precision: float, recall: float) -> float:
    """Harmonic mean of precision and recall; 0 where both are 0."""
    total = precision + recall
    return 2.0 * precision * recall / total if total > 0.0 else 0.0


def mean_measures(measures: Sequence[Measures]) -> Measures:
    """The measures over many drawings: means, and F1 from the mean precision and recall.

    Raises:
        ValueError: There is nothing to average.
    """
    if not measures:
        raise ValueError("no measures to average")

    def mean(name: str) -> float:
        return math.fsum(getattr(item, name) for item in measures) / len(measures)

    precision, recall = mean("precision"), mean("recall")
    return Measures(precision, recall, f1_score(precision, recall), mean("iou"), mean("chamfer"))


def tolerance_from_page(tolerance_mm: float, mm_per_pixel: float) -> float:
    """A nearness on the page, as pixels.

    Raises:
        UsageError: A length is negative, zero where it divides, or not finite.
    """
    if not (math.isfinite(tolerance_mm) and tolerance_mm >= 0.0):
        raise ArgumentError("tolerance_mm", str(tolerance_mm), "0 or more")
    if not (math.isfinite(mm_per_pixel) and mm_per_pixel > 0.0):
        raise ArgumentError("mm_per_pixel", str(mm_per_pixel), "more than 0")
    return tolerance_mm / mm_per_pixel


def _count_near(distances: Image, tolerance: float) -> int:
    # Squares of pixel distances are whole numbers, so rounding them undoes float32's error where it matters.
    squared = np.rint(np.square(distances, dtype=np.float64))
    return int(np.count_nonzero(squared <= tolerance * tolerance * (1.0 + 1e-12)))
