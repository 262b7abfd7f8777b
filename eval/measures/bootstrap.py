"""Confidence intervals: Wilson's for shares, the bootstrap over shapes for everything that is averaged over drawings.

Drawings of one shape resemble each other, so shapes are resampled and not drawings. `scipy.stats.bootstrap` has one
statistic of at least two samples; here all quantities of all methods share each draw, which pairs them and gives F1 its
interval, and one shape alone has an interval too, of no width.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from ncmodel.report.intervals import CONFIDENCE, Interval, wilson_interval
from ncmodel.types import Floats

RESAMPLES = 2000


@dataclass(frozen=True)
class PairAccuracy:
    """How often a score puts the better drawing of a pair first.

    Attributes:
        accuracy: Share of pairs in the right order; a tie counts one half.
        pairs: Number of pairs.
        shapes: Number of shapes they come from.
        wilson: Interval that takes pairs as independent: too narrow where a shape has many. Half a pair, from a tie, is
            rounded.
        bootstrap: Interval over resampled shapes: the one to report.
    """

    accuracy: float
    pairs: int
    shapes: int
    wilson: Interval
    bootstrap: Interval


def resampled_means(values: Floats, clusters: Sequence[Hashable], seed: int = 0, resamples: int = RESAMPLES) -> Floats:
    """Means over resampled clusters: whole clusters are drawn with replacement, as many as there are.

    Args:
        values: (N, M) M quantities of N items.
        clusters: (N,) which cluster each item belongs to.
        seed: The same seed draws the same clusters, so that differences between methods on the same items are paired.
        resamples: Number of draws R.

    Returns:
        (R, M) means over the items of the drawn clusters.
    """
    if len(values) != len(clusters) or not len(values):
        raise ValueError(f"{len(values)} items for {len(clusters)} cluster labels, expected as many and at least one")
    index = {cluster: number for number, cluster in enumerate(dict.fromkeys(clusters))}
    member = np.array([index[cluster] for cluster in clusters])
    sums = np.zeros((len(index), values.shape[1]))
    np.add.at(sums, member, values)
    sizes = np.bincount(member, minlength=len(index)).astype(np.float64)
    drawn = np.random.default_rng(seed).multinomial(len(index), np.full(len(index), 1.0 / len(index)), size=resamples)
    means: Floats = (drawn @ sums) / (drawn @ sizes)[:, None]
    return means


def percentile_interval(samples: Floats, confidence: float = CONFIDENCE) -> Interval:
    """The interval that holds the middle `confidence` of bootstrap samples."""
    low, high = np.quantile(samples, [0.5 - confidence / 2.0, 0.5 + confidence / 2.0])
    return Interval(float(low), float(high))


def pair_accuracy(
    better: Sequence[float], worse: Sequence[float], shapes: Sequence[Hashable], seed: int = 0
) -> PairAccuracy:
    """How often the better drawing of a pair has the higher score.

    Args:
        better: (N,) scores of the drawings that were preferred.
        worse: (N,) scores of the others.
        shapes: (N,) the shape each pair is about.
        seed: Of the bootstrap.

    Raises:
        ValueError: There are no pairs, or the three differ in length.
    """
    first, second = np.asarray(better, dtype=np.float64), np.asarray(worse, dtype=np.float64)
    if not len(first) == len(second) == len(shapes) or not len(first):
        raise ValueError(
            f"{len(first)} better, {len(second)} worse, {len(shapes)} shapes, expected as many and at least one"
        )
    if np.isnan(first).any() or np.isnan(second).any():
        raise ValueError("a score is not a number")
    right = np.where(first == second, 0.5, (first > second).astype(np.float64))
    return PairAccuracy(
        accuracy=float(right.mean()),
        pairs=len(right),
        shapes=len(set(shapes)),
        wilson=wilson_interval(round(right.sum()), len(right)),
        bootstrap=percentile_interval(resampled_means(right[:, None], shapes, seed)[:, 0]),
    )
