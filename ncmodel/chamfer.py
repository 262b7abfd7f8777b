"""Chamfer distances between drawings in pixels: of a pair, of many unions of layers at once, and what they are made of.

A drawing is a set of pixels A. The symmetric Chamfer distance is

    d(A, B) = (mean distance from A's pixels to the nearest pixel of B + mean distance from B's to A) / 2

and 0 between two empty drawings. Between an empty drawing and one that isn't it is the picture's diagonal, more than
any distance in it.

Drawings that are unions of a few layers are cheap to compare, and still exactly:

* the distance to a union is the minimum of the distances to its parts, so one distance transform a layer is enough;
* only drawn pixels matter, and each counts once, on however many layers it lies. All pairs of drawings are then a
  matrix product.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ncmodel.types import Floats, Image, Mask

DEFINITION = (
    "symmetric Chamfer distance in pixels between the inked pixels of two drawings: (mean distance from A's pixels to "
    "the nearest pixel of B + mean distance from B's pixels to the nearest pixel of A) / 2; 0 between two empty "
    "drawings, the length of the image's diagonal between an empty drawing and one that isn't"
)
"""What stands beside distances in files."""

STEPS = 1 << 14
"""Distances are added up in whole steps of 1/STEPS pixels. Sums of whole numbers are exact, so that the result doesn't
depend on the order of addition: on the number of threads, the machine, or the library that multiplies matrices."""


def distance_to(mask: Mask) -> Image:
    """(H, W) Euclidean distance of every pixel to the nearest pixel of a mask, in pixels.

    Of an empty mask it is the picture's diagonal everywhere.

    OpenCV rounds the last bit now up, now down, depending on where in memory a picture happens to lie. Squares of
    distances are whole numbers; up to about 1,000 pixels that tells which one was meant.
    """
    if not mask.any():
        return np.full(mask.shape, diagonal(mask), dtype=np.float32)
    distance = cv2.distanceTransform((~mask).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    square = np.square(distance, dtype=np.float32)
    np.rint(square, out=square)
    return np.asarray(np.sqrt(square, out=square))


def diagonal(mask: Mask) -> float:
    """Pixels from corner to corner of a picture, (H, W)."""
    return math.hypot(*mask.shape)


@dataclass(frozen=True, eq=False)
class Lines:
    """A drawing's pixels with what comparing it needs, computed once for many comparisons.

    Attributes:
        mask: (H, W) drawn pixels.
        distance: (H, W) distance of each pixel to the drawing, as `distance_to` gives it.
    """

    mask: Mask
    distance: Image

    @staticmethod
    def of(mask: Mask) -> "Lines":
        """Prepare a mask."""
        return Lines(mask, distance_to(mask))

    @property
    def empty(self) -> bool:
        """Whether nothing is drawn."""
        return not self.mask.any()


def chamfer_distance(first: Lines, second: Lines) -> float:
    """Symmetric Chamfer distance between two drawings, in pixels.

    Raises:
        ValueError: The two have different sizes.
    """
    if first.mask.shape != second.mask.shape:
        raise ValueError(f"drawings have shapes {first.mask.shape} and {second.mask.shape}, expected the same")
    if first.empty or second.empty:
        return 0.0 if first.empty and second.empty else diagonal(first.mask)
    there, back = second.distance[first.mask], first.distance[second.mask]
    return float(there.mean(dtype=np.float64) + back.mean(dtype=np.float64)) / 2


def chamfer_matrix(layers: Mask, members: Mask) -> Floats:
    """Symmetric Chamfer distances between all pairs of drawings that are unions of layers.

    Pixels that lie on the same layers lie on the same drawings, so distances are first added up over such groups.

    Args:
        layers: (L, H, W) drawn pixels of each layer.
        members: (N, L) which layers each drawing consists of; a drawing without layers is empty.

    Returns:
        (N, N) pixels.

    Raises:
        ValueError: There are more than 62 layers.
    """
    inked: Mask = np.logical_or.reduce(layers)
    stacks, stack_of_pixel = np.unique(_codes(layers[:, inked]), return_inverse=True)
    order = np.argsort(stack_of_pixel, kind="stable")
    stack_sizes = np.bincount(stack_of_pixel, minlength=len(stacks)).astype(np.float64)
    fields = np.stack([np.rint(distance_to(layer)[inked] * np.float32(STEPS)) for layer in layers])[:, order]
    starts = np.concatenate([[0], np.cumsum(stack_sizes[:-1])]).astype(np.intp)

    ink = (_codes(members.T)[:, None] & stacks[None, :] != 0).astype(np.float64)
    away = np.zeros((len(members), len(stacks)))
    for drawing in np.flatnonzero(members.any(axis=1) & inked.any()):
        distance = fields[members[drawing]].min(axis=0)
        away[drawing] = np.add.reduceat(distance, starts, dtype=np.float64)

    counts = ink @ stack_sizes
    mean = np.full((len(members), len(members)), diagonal(inked))
    # mean[i, j]: from the pixels of drawing j to the nearest pixel of drawing i; the diagonal where j has none.
    np.divide(away @ ink.T, counts * STEPS, out=mean, where=(counts > 0) & (counts > 0)[:, None])
    distances: Floats = (mean + mean.T) / 2
    empty = counts == 0
    distances[np.ix_(empty, empty)] = 0.0
    np.fill_diagonal(distances, 0.0)
    return distances


def _codes(bits: Mask) -> NDArray[np.int64]:
    """(K, n) bits -> (n,) one number a column; two columns are equal iff their numbers are."""
    if len(bits) > 62:
        raise ValueError(f"{len(bits)} layers, at most 62 fit into one number")
    weights = np.left_shift(np.int64(1), np.arange(len(bits), dtype=np.int64))
    return np.asarray(weights @ bits.astype(np.int64))


def chamfer_to_unions(always: Lines, layers: Sequence[Sequence[Lines]], reference: Lines) -> Floats:
    """Symmetric Chamfer distances between one drawing and all unions of one layer from each of three lists.

    Args:
        always: In every union.
        layers: Three lists of A, B and C layers.
        reference: What the unions are compared with.

    Returns:
        (A, B, C) pixels.
    """
    from_unions, counts = _mean_distance_from_unions(always, layers, reference.distance)
    if reference.empty:
        return np.where(counts > 0, diagonal(reference.mask), 0.0)
    to_unions = _mean_distance_to_unions(always, layers, reference.mask)
    return np.where(counts > 0, (to_unions + from_unions) / 2, diagonal(reference.mask))


def _mean_distance_to_unions(always: Lines, layers: Sequence[Sequence[Lines]], mask: Mask) -> Floats:
    """(A, B, C) mean distance from the pixels of `mask` to each union."""
    first, second, third = (np.stack([lines.distance[mask] for lines in group]) for group in layers)
    first = np.minimum(first, always.distance[mask])
    means = np.empty((len(first), len(second), len(third)))
    for i, start in enumerate(first):
        for j, then in enumerate(np.minimum(start, second)):
            means[i, j] = np.minimum(then, third).mean(axis=1, dtype=np.float64)
    return means


def _mean_distance_from_unions(
    always: Lines, layers: Sequence[Sequence[Lines]], distance: Image
) -> tuple[Floats, Floats]:
    """(A, B, C) mean distance from the pixels of each union to the reference, and the pixels counted."""
    drawn = np.logical_or.reduce([always.mask, *(lines.mask for group in layers for lines in group)])
    fixed = always.mask[drawn]
    first, second, third = (np.stack([lines.mask[drawn] for lines in group]) for group in layers)
    weights = np.stack([np.ones(int(drawn.sum()), np.float32), distance[drawn]])
    total = np.empty((2, len(first), len(second), len(third)))
    added = third.astype(np.float32)
    for i, start in enumerate(first | fixed):
        # What the third layer adds is what neither of the others has: one matrix product for all pairs.
        both = start | second
        before = weights @ both.T.astype(np.float32)
        fresh = np.where(both[None], 0.0, weights[:, None]).astype(np.float32)
        total[:, i] = before[..., None] + fresh @ added.T
    counts = total[0]
    return np.divide(total[1], counts, out=np.zeros_like(counts), where=counts > 0), counts
