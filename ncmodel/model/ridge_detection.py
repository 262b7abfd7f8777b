"""From a map of line probabilities to clean lines: image-space ridge detection, as Cole et al. (2008) clean their maps.

A pixel is on a ridge where the smoothed map has a maximum across the direction in which it curves most (Steger 1998).
Such pixels are kept where they hang together with ones that are probable enough, thinned, and joined into segments
that pass through the sub-pixel position of the maximum.

References:
    Cole, Golovinskiy, Limpaecher, Barros, Finkelstein, Funkhouser, Rusinkiewicz: Where Do People Draw Lines? SIGGRAPH
    2008.
    Steger: An Unbiased Detector of Curvilinear Structures. PAMI 20(2), 1998.
"""

import itertools
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.morphology import remove_small_holes, skeletonize

from ncmodel.lines.chaining import chain
from ncmodel.model.letterbox import Square
from ncmodel.types import Floats, Image, Mask, Stroke

IMAGE_FAMILY = "image"
"""Family of the strokes that the image branch adds."""

REACH = 0.6
"""Pixels along u and v that a maximum may lie from a pixel's centre: a bit over a half, to leave no gaps."""

WIDEST = 5.0
"""Lines in the smoothed map are at most this wide (standard deviation of the profile, pixels); what curves less than
that is no line but a slope beside one, or the rounded end of one."""


@dataclass(frozen=True)
class RidgeOptions:
    """What counts as a line in a map of probabilities.

    The image branch isn't sure to the pixel where a line runs, so even along certain lines the probability that it
    gives to each pixel is low. The defaults maximise F1 against held-out drawings, on a broad plateau.

    Attributes:
        sigma: Standard deviation of the smoothing, pixels of the map.
        low: Least probability of a line.
        high: Probability that a line must reach somewhere.
        length: Least length of a line, pixels of the map.
        full: Probability from which on a line is drawn with full ink; below, its ink is in proportion.
    """

    sigma: float = 1.2
    low: float = 0.05
    high: float = 0.1
    length: float = 10.0
    full: float = 0.15

    def __post_init__(self) -> None:
        if not (self.sigma > 0 and 0 < self.low <= self.high <= 1 and self.length >= 0 and 0 < self.full <= 1):
            raise ValueError(f"{self}: expected sigma > 0, 0 < low <= high <= 1, length >= 0 and 0 < full <= 1")


@dataclass(frozen=True, eq=False)
class Ridges:
    """Lines found in a map, as segments between neighbouring pixels' ridge points.

    Attributes:
        points: (S, 2, 2) end points (u, v), pixels of the map; segments of one line share them exactly.
        alpha: (S, 2) ink at the ends, in (0, 1].
    """

    points: Floats
    alpha: Floats


def find_ridges(probability: Image, options: RidgeOptions | None = None) -> Ridges:
    """Lines along the ridges of a map.

    Args:
        probability: (H, W) in [0, 1].
        options: What counts as a line.

    Raises:
        ValueError: The map isn't two-dimensional or has a value that isn't finite.
    """
    options = options or RidgeOptions()
    if probability.ndim != 2 or not np.isfinite(probability).all():
        raise ValueError(f"probability map of shape {probability.shape}, expected (H, W) finite numbers")
    crest, offset = _crests(probability.astype(np.float64), options.sigma)
    mask = _connected(crest & (probability >= options.low), probability >= options.high, 0.0)
    # Gaps too small to be anything would become rings.
    mask = remove_small_holes(mask, max_size=int(options.length))
    # Thinning may break what was one piece only where it was a blob; lines keep their length.
    mask = _connected(skeletonize(mask), mask, options.length)
    mask = _connected(_pruned(mask, int(options.length - 1) // 2), mask, options.length)
    rows, columns = np.nonzero(mask)
    ends = neighbours(mask)
    points = np.stack([columns, rows], axis=1) + 0.5 + offset[rows, columns]
    alpha = np.minimum(probability[rows, columns].astype(np.float64) / options.full, 1.0)
    return Ridges(points[ends], alpha[ends])


def polylines(ridges: Ridges, square: Square) -> tuple[Stroke, ...]:
    """Ridges chained into strokes of the family "image".

    Args:
        ridges: Lines in a square map.
        square: How the picture sits in that map; strokes are in the picture's pixels.
    """
    return tuple(replace(stroke, points=square.to_picture(stroke.points)) for stroke in chained(ridges))


def chained(ridges: Ridges) -> tuple[Stroke, ...]:
    """Ridges chained into strokes of the family "image", in the map's pixels."""
    chains, found = chain(ridges.points), []
    for begin, end in itertools.pairwise(chains.first.tolist()):
        segment, first = chains.segment[begin:end], chains.flipped[begin:end].astype(np.int64)
        points = np.concatenate([ridges.points[segment, first], ridges.points[segment[-1:], 1 - first[-1:]]])
        alpha = np.concatenate([ridges.alpha[segment, first], ridges.alpha[segment[-1:], 1 - first[-1:]]])
        found.append(Stroke(IMAGE_FAMILY, points, alpha))
    return tuple(found)


def _crests(image: Floats, sigma: float) -> tuple[Mask, Floats]:
    """(H, W) where the smoothed image has a maximum across a line within the pixel, and (H, W, 2) its offset (u, v)."""
    smooth = cv2.GaussianBlur(image, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
    padded = np.pad(smooth, 1, mode="edge")
    before, after, above, below = padded[1:-1, :-2], padded[1:-1, 2:], padded[:-2, 1:-1], padded[2:, 1:-1]
    gx, gy = (after - before) / 2, (below - above) / 2
    hxx, hyy = after - 2 * smooth + before, below - 2 * smooth + above
    hxy = (padded[2:, 2:] - padded[2:, :-2] - padded[:-2, 2:] + padded[:-2, :-2]) / 4
    # The eigenvalue of the Hessian with the largest absolute value, and its direction.
    half, mean = np.hypot((hxx - hyy) / 2, hxy), (hxx + hyy) / 2
    curve = mean - half
    angle = 0.5 * np.arctan2(2 * hxy, hxx - hyy) + np.pi / 2
    nx, ny = np.cos(angle), np.sin(angle)
    sharp = curve < -(WIDEST**-2) * smooth
    step = -(gx * nx + gy * ny) / np.where(sharp, curve, -1.0)
    inside = sharp & (np.abs(step * nx) <= REACH) & (np.abs(step * ny) <= REACH)
    step = np.where(inside, step, 0.0)
    return inside, np.stack([step * nx, step * ny], axis=-1)


def _connected(mask: Mask, seeds: Mask, length: float) -> Mask:
    """The 8-connected pieces of a mask that hold a seed and have at least `length` pixels.

    scikit-image's hysteresis joins pixels along their sides only, and ridges run diagonally too.
    """
    count, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)
    flat = np.asarray(labels, dtype=np.int64).ravel()
    size = np.bincount(flat, minlength=count)
    seeded = np.bincount(flat, weights=(mask & seeds).ravel(), minlength=count)
    keep = (size >= length) & (seeded > 0)
    keep[0] = False
    return np.asarray(keep[labels])


def _pruned(mask: Mask, most: int) -> Mask:
    """A thin mask without side branches of at most so many pixels, which thinning leaves where a line is uneven.

    All lines lose that many pixels at each end; what is left of a line gets its own back, and of a fork the longer one.
    """
    rows, columns = np.nonzero(mask)
    ends = neighbours(mask)
    lost = np.zeros(len(rows), dtype=np.int64)
    for step in range(1, most + 1):
        lost[(lost == 0) & (_degrees(ends, lost == 0) <= 1)] = step
    kept = lost == 0
    here, there = np.concatenate([ends, ends[:, ::-1]]).T
    tips = kept & (_degrees(ends, kept) <= 1)
    for _ in range(most):
        begin, onwards = here[tips[here] & ~kept[there]], there[tips[here] & ~kept[there]]
        order = np.lexsort((lost[onwards], begin))
        begin, onwards = begin[order], onwards[order]
        longest = onwards[np.append(begin[1:] != begin[:-1], True)[: len(begin)]]
        kept[longest] = True
        tips[:] = False
        tips[longest] = True
    pruned = np.zeros_like(mask)
    pruned[rows[kept], columns[kept]] = True
    return pruned


def _degrees(ends: NDArray[np.int64], present: Mask) -> NDArray[np.int64]:
    """How many of the nodes that are present each node is joined with, by pairs (S, 2), if it is present itself."""
    joined = ends[present[ends].all(axis=1)]
    return np.bincount(joined.ravel(), minlength=len(present))


def neighbours(mask: Mask) -> NDArray[np.int64]:
    """(S, 2) pairs of neighbouring pixels, numbered; diagonal ones only where no way round a corner joins them."""
    node = np.full(mask.shape, -1)
    node[mask] = np.arange(int(mask.sum()))
    padded = np.pad(node, 1, constant_values=-1)
    here, right, down = padded[1:-1, 1:-1], padded[1:-1, 2:], padded[2:, 1:-1]
    across, back, left = padded[2:, 2:], padded[2:, :-2], padded[1:-1, :-2]
    pairs = [
        (here, right, np.ones_like(here, dtype=bool)),
        (here, down, np.ones_like(here, dtype=bool)),
        (here, across, (right < 0) & (down < 0)),
        (here, back, (left < 0) & (down < 0)),
    ]
    found = [np.stack([a, b], axis=-1)[allowed & (a >= 0) & (b >= 0)] for a, b, allowed in pairs]
    return np.concatenate(found)
