"""What a drawing is like, whatever it is compared with: how much inner ink, how long its strokes, along which lines.

Drawings are thinned to one pixel. Inner ink is what lies off the silhouette. A stroke runs on through a junction where
there is a straight way on. Millimetres are those of a page on which the shape is 120 mm wide.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from eval.measures.thinning import DEFAULT_THRESHOLD, outline, silhouette_band, thin_lines
from ncmodel.chamfer import distance_to
from ncmodel.lines.chaining import chain
from ncmodel.types import Floats, Image, Mask

PAGE_MM = 120.0
"""Width of the shape on the page, the longer side of its picture."""
NEAR_MM = 1.0
"""Ink this near to a line lies along it."""
CRUMB_MM = 5.0
"""Shorter strokes are crumbs."""
BAND_PIXELS = 5.0
"""Ink within this distance of the silhouette is its own."""


@dataclass(frozen=True)
class Traits:
    """One drawing.

    Attributes:
        inner: Length of the inner ink, in lengths of the silhouette.
        stroke: Mean length of inner strokes, weighted by length, millimetres.
        crumbs: Share of the inner ink in strokes under 5 mm.
        along: Name of a kind of line -> share of the inner ink within 1 mm of such lines.
        apart: Share of the inner ink that isn't near any of them.
    """

    inner: float
    stroke: float
    crumbs: float
    along: Mapping[str, float]
    apart: float


@dataclass(frozen=True, eq=False)
class Measured:
    """What drawings of one view are measured with.

    Attributes:
        band: (H, W) the silhouette's own pixels.
        outline: Pixels around the shape.
        pixels_per_mm: On the page.
        away: Name of a kind of line -> (H, W) distance to such lines.
    """

    band: Mask
    outline: int
    pixels_per_mm: float
    away: Mapping[str, Image]

    @staticmethod
    def of(shape: Mask, lines: Mapping[str, Mask]) -> "Measured":
        """Prepare a view.

        Args:
            shape: (H, W) the pixels that show the shape.
            lines: Name -> (H, W) the pixels of a kind of line.

        Raises:
            ValueError: No pixel shows the shape.
        """
        rows, columns = np.nonzero(shape)
        if not len(rows):
            raise ValueError("no pixel shows the shape")
        wide = max(int(np.ptp(rows)), int(np.ptp(columns))) + 1
        away = {name: distance_to(mask) for name, mask in lines.items()}
        return Measured(silhouette_band(shape, BAND_PIXELS), int(outline(shape).sum()), wide / PAGE_MM, away)

    def inner(self, ink: Image, threshold: float = DEFAULT_THRESHOLD) -> Mask:
        """(H, W) a drawing's thin inner lines."""
        return np.asarray(thin_lines(ink, threshold) & ~self.band)

    def traits(self, inner: Mask) -> Traits:
        """Of a drawing's thin inner lines; shares of no ink are not numbers."""
        lengths = stroke_lengths(inner) / self.pixels_per_mm
        total, reach = float(lengths.sum()), NEAR_MM * self.pixels_per_mm
        near = {name: away[inner] <= reach for name, away in self.away.items()}
        some = np.logical_or.reduce([*near.values(), np.zeros(int(inner.sum()), dtype=np.bool_)])
        return Traits(
            inner=float(inner.sum()) / self.outline,
            stroke=_share(float((lengths**2).sum()), total),
            crumbs=_share(float(lengths[lengths < CRUMB_MM].sum()), total),
            along={name: _share(float(mask.sum()), len(mask)) for name, mask in near.items()},
            apart=_share(float((~some).sum()), len(some)),
        )


def stroke_lengths(thin: Mask) -> Floats:
    """(n,) pixels of the strokes of a thin drawing; a pixel alone has no length."""
    pieces = _pixel_pieces(thin)
    chains = chain(pieces)
    if not len(chains):
        return np.zeros(0)
    lengths = np.linalg.norm(pieces[:, 1] - pieces[:, 0], axis=1)[chains.segment]
    return np.asarray(np.add.reduceat(lengths, chains.first[:-1]))


def _pixel_pieces(thin: Mask) -> Floats:
    """(S, 2, 2) from pixel to neighbouring pixel; diagonally only where there is no way round the corner."""
    padded = np.pad(thin, 1)
    here, right, down = padded[1:-1, 1:-1], padded[1:-1, 2:], padded[2:, 1:-1]
    left, across, back = padded[1:-1, :-2], padded[2:, 2:], padded[2:, :-2]
    joins = [
        ((1, 0), here & right),
        ((0, 1), here & down),
        ((1, 1), here & across & ~right & ~down),
        ((-1, 1), here & back & ~left & ~down),
    ]
    pieces = []
    for step, joined in joins:
        rows, columns = np.nonzero(joined)
        start = np.stack([columns, rows], axis=1)
        pieces.append(np.stack([start, start + np.array(step)], axis=1))
    return np.concatenate(pieces).astype(np.float64)


def _share(part: float, whole: float) -> float:
    return part / whole if whole else float("nan")
