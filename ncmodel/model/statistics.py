"""Plain numbers of drawings: how much ink, on which lines, of how much there is, in strokes how long.

A network that looks at a small picture doesn't see how much of which lines a drawing shows, and people care about that
first. These numbers say it. All drawings of a view are unions of a few layers, so pixels are counted once for each set
of layers that they lie on (a few hundred), and the numbers of all drawings are products of small matrices.

Letters in shapes: L layers (the first one is the outline's: occluding contours), N drawings, H rows, W columns.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from ncmodel.types import Floats, Image, Ints, Mask

FAINT = 0.02
"""Added to proportions before their logarithm: less ink than this share of the outline's is none."""

CRUMB = 0.03
"""Strokes that reach over less than this share of the picture's side are crumbs."""

OUTLINES = (0, 2)
"""The layers whose ink others are measured by: contours and borders."""


@dataclass(frozen=True, eq=False)
class Statistics:
    """The numbers of a view's drawings.

    Attributes:
        drawings: (N, D) of each drawing: its inner ink in outlines, the logarithm of that, ink of several layers at
            once, and for each layer but the outline's the share that the drawing shows.
        members: (N, L) which layers each drawing consists of.
        view: (V,) of what there is to choose from: for each such layer the logarithm of its inner ink in outlines; for
            each layer the reach of its strokes and its share of crumbs; the outline's length for the shape's area; the
            area; how much the shading varies, and how much of that are details.
    """

    drawings: Floats
    members: Mask
    view: Floats

    def numbers(self, rows: Ints | None = None) -> Image:
        """(n, F) what a linear ranker needs: how much ink is right (log x and its square) depends on the view.

        Args:
            rows: (n,) which drawings; all by default.
        """
        drawings, members = (part if rows is None else part[rows] for part in (self.drawings, self.members))
        amount = drawings[:, 1:2]
        view = np.broadcast_to(self.view, (len(drawings), len(self.view)))
        parts = [drawings, members[:, 1:], amount**2, amount * view, amount**2 * view, view]
        return np.concatenate(parts, axis=1, dtype=np.float32)


def statistics(masks: Mask, members: Mask, depth: Image, shaded: Image) -> Statistics:
    """Count.

    Args:
        masks: (L, H, W) inked pixels of the layers.
        members: (N, L) which layers each drawing consists of.
        depth: (H, W) depth, 1 on the background.
        shaded: (6, H, W) shaded maps, as `View.shaded`.
    """
    inner = masks & ~masks[0]
    inner[0] = masks[0]
    sets, count = _stacks(inner)
    outline = max(float((sets[:, OUTLINES].any(axis=1) * count).sum()), 1.0)
    own = sets.T.astype(np.float64) @ count
    shown = members.copy()
    shown[:, 0] = False
    drawn = (shown.astype(np.float64) @ sets.T.astype(np.float64)) > 0
    ink = drawn @ count
    covered = (drawn * count) @ sets[:, 1:].astype(np.float64) / np.maximum(own[1:], 1.0)
    amount = ink / outline
    doubled = (shown @ own) / outline - amount
    drawings = np.column_stack([amount, np.log(amount + FAINT), doubled, covered])
    return Statistics(drawings, members, _of_view(inner, own, outline, depth, shaded))


def _of_view(inner: Mask, own: Floats, outline: float, depth: Image, shaded: Image) -> Floats:
    strokes = np.array([_strokes(mask) for mask in inner])
    hit = depth < 1.0
    area = max(int(hit.sum()), 1)
    seen = shaded[:, hit] if hit.any() else np.ones((len(shaded), 1), dtype=np.float32)
    details = [float(np.abs(seen[level] - seen[0]).mean()) for level in (1, 3, 5)]
    shape = [np.log(outline / np.sqrt(area)), area / hit.size, np.log(float(seen[0].std()) + FAINT), *details]
    return np.concatenate([np.log(own[1:] / outline + FAINT), strokes[:, 0], strokes[:, 1], shape])


def _stacks(masks: Mask) -> tuple[Mask, Floats]:
    """(G, L) the sets of layers that pixels lie on, and (G,) how many pixels lie on each."""
    flat = masks.reshape(len(masks), -1)
    flat = flat[:, flat.any(axis=0)]
    weights = np.left_shift(np.int64(1), np.arange(len(masks), dtype=np.int64))
    codes, count = np.unique(weights @ flat.astype(np.int64), return_counts=True)
    return (codes[:, None] & weights) != 0, count.astype(np.float64)


def _strokes(mask: Mask) -> tuple[float, float]:
    """How far connected ink reaches, mean over the ink, and the share of crumbs; 0 and 0 without ink."""
    _, _, boxes, _ = cv2.connectedComponentsWithStats(mask.view(np.uint8), connectivity=8)
    size = boxes[1:, cv2.CC_STAT_AREA].astype(np.float64)
    if not len(size):
        return 0.0, 0.0
    side = min(mask.shape)
    reach = np.hypot(boxes[1:, cv2.CC_STAT_WIDTH], boxes[1:, cv2.CC_STAT_HEIGHT]) / side
    return float((reach * size).sum() / size.sum()), float(size[reach < CRUMB].sum() / size.sum())
