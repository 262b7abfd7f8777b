"""Symmetric Chamfer distance between drawings, and between all candidates of a view at once.

The candidates are unions of a few layers, which makes all their distances cheap and still exact:

* the distance to a union is the minimum of the distances to its parts, so one distance transform a layer is enough;
* only inked pixels matter, and those that lie on the same layers lie on the same drawings, so distances are first added
  up over such groups of pixels; all pairs of drawings are then one small matrix product.
"""

import numpy as np
from numpy.typing import NDArray

from ncmodel.export.distance_transform import distance_to
from ncmodel.types import Floats, Image, Mask

STEPS = 1 << 14
"""Distances are added up in whole steps of 1/STEPS pixels. Sums of whole numbers are exact, so that the result doesn't
depend on the order of addition: on the number of threads, the machine, or the library that multiplies matrices."""

DEFINITION = (
    "symmetric Chamfer distance in pixels between the inked pixels of two drawings: (mean distance from A's pixels to "
    "the nearest pixel of B + mean distance from B's pixels to the nearest pixel of A) / 2; 0 between two empty "
    "drawings, the length of the image's diagonal between an empty drawing and one that isn't"
)


def chamfer(a: Mask, b: Mask) -> float:
    """Symmetric Chamfer distance between two drawings.

    Args:
        a: (H, W) inked pixels.
        b: (H, W) inked pixels.

    Returns:
        Pixels, as `DEFINITION` says.
    """
    if not a.any() or not b.any():
        return 0.0 if a.any() == b.any() else _diagonal(a)
    return float(distance_field(b)[a].mean(dtype=np.float64) + distance_field(a)[b].mean(dtype=np.float64)) / 2


def chamfer_matrix(layers: Mask, members: Mask) -> Floats:
    """Symmetric Chamfer distances between all pairs of drawings that are unions of layers.

    Args:
        layers: (L, H, W) inked pixels of each layer.
        members: (N, L) which layers each drawing consists of; a drawing without layers is empty.

    Returns:
        (N, N) pixels, as `DEFINITION` says.
    """
    inked: Mask = np.logical_or.reduce(layers)
    stacks, stack_of_pixel = np.unique(_codes(layers[:, inked]), return_inverse=True)
    order = np.argsort(stack_of_pixel, kind="stable")
    stack_sizes = np.bincount(stack_of_pixel, minlength=len(stacks)).astype(np.float64)
    fields = np.stack([np.rint(distance_field(layer)[inked] * np.float32(STEPS)) for layer in layers])[:, order]
    starts = np.concatenate([[0], np.cumsum(stack_sizes[:-1])]).astype(np.intp)

    ink = (_codes(members.T)[:, None] & stacks[None, :] != 0).astype(np.float64)
    away = np.zeros((len(members), len(stacks)))
    for drawing in np.flatnonzero(members.any(axis=1) & inked.any()):
        distance = fields[members[drawing]].min(axis=0)
        away[drawing] = np.add.reduceat(distance, starts, dtype=np.float64)

    counts = ink @ stack_sizes
    mean = np.full((len(members), len(members)), _diagonal(inked))
    # mean[i, j]: from the pixels of drawing j to the nearest pixel of drawing i; the diagonal where j has none.
    np.divide(away @ ink.T, counts * STEPS, out=mean, where=(counts > 0) & (counts > 0)[:, None])
    distances: Floats = (mean + mean.T) / 2
    empty = counts == 0
    distances[np.ix_(empty, empty)] = 0.0
    np.fill_diagonal(distances, 0.0)
    return distances


def distance_field(mask: Mask) -> Image:
    """Distance of every pixel to the nearest inked one; the image's diagonal everywhere when there is none.

    Args:
        mask: (H, W) inked pixels.

    Returns:
        (H, W) pixels, exact but for float32 rounding.
    """
    return distance_to(mask) if mask.any() else np.full(mask.shape, _diagonal(mask), dtype=np.float32)


def _codes(bits: Mask) -> NDArray[np.int64]:
    """(K, n) bits -> (n,) one number a column; two columns are equal iff their numbers are."""
    if len(bits) > 62:
        raise ValueError(f"{len(bits)} layers, at most 62 fit into one number")
    weights = np.left_shift(np.int64(1), np.arange(len(bits), dtype=np.int64))
    return np.asarray(weights @ bits.astype(np.int64))


def _diagonal(image: Mask) -> float:
    return float(np.hypot(*image.shape[-2:]))
