"""The ranking module's score of a view's drawing, as a function of the drawing's thresholds.

Only pixels that carry lines change with t. They are gathered once; each evaluation filters them (equations 1-5) and
adds them into the ranking module's input by the same area averaging that its training pictures went through.

Letters in shapes: B drawings, P pixels that carry filtered lines, S side of the ranking module's input.
"""

import numpy as np
import torch
from torch import Tensor

from ncmodel.model.filters import line_drawing
from ncmodel.model.letterbox import Square
from ncmodel.model.maps import LineMaps
from ncmodel.nets.presets import BACKGROUND
from ncmodel.nets.ranking import RankingModule
from ncmodel.types import Floats, Image, Mask

CHUNK = 16
"""Drawings scored at a time."""


class DrawingScore:
    """f(I(t), E, O) for one view.

    Args:
        ranker: The ranking module f.
        maps: (7, H, W) depth E and shaded maps O.
        lines: The view's line and feature maps, (H, W) too.
        image: (H, W) ink I_L of the image branch, if it takes part.
        mirrored: Take the mean of f for the drawing and for its mirror image.
    """

    def __init__(
        self,
        ranker: RankingModule,
        maps: Image,
        lines: LineMaps,
        image: Image | None = None,
        mirrored: bool = False,
    ) -> None:
        self._ranker, self._lines = ranker, lines
        square = Square(maps.shape[1], maps.shape[2], ranker.dims.size)
        small = torch.from_numpy(square.fit(maps, BACKGROUND))[None]
        with torch.no_grad():
            self._embedded = [ranker.embed(seen) for seen in (small, small.flip(-1))[: 1 + mirrored]]
        pixels = np.flatnonzero(lines.lines.any(axis=0))
        source, cell, weight = square.spread(pixels)
        self._source, self._cell = torch.from_numpy(source), torch.from_numpy(cell)
        self._weight = torch.from_numpy(weight).float()
        self._ink = torch.from_numpy(lines.lines.reshape(4, -1)[:, pixels])
        self._feature = torch.from_numpy(lines.features.reshape(4, -1)[:, pixels])
        self._always, self._base = {}, {}
        for boundaries in (False, True):
            parts = [lines.contours, *([lines.boundaries] if boundaries else []), *([] if image is None else [image])]
            always = np.maximum.reduce(parts).ravel()
            self._always[boundaries] = torch.from_numpy(always[pixels])
            always[pixels] = 0.0
            still = square.fit(always.reshape(maps.shape[1:]), background=0.0)
            self._base[boundaries] = torch.from_numpy(still.reshape(1, -1))

    @property
    def present(self) -> Mask:
        """(4,) which families have lines in this view."""
        return np.asarray((self._ink > 0).any(dim=1).numpy())

    @property
    def has_boundaries(self) -> bool:
        """Whether the view shows boundaries."""
        return bool(self._lines.boundaries.any())

    def threshold_leaving(self, family: int, share: float) -> float:
        """The t at which `share` of a family's ink is left: 0 for share 1, the largest feature for share 0.

        With pixels in order of falling feature, those above t keep sum(S) - t sum(S / feature), which is linear in t
        between two features.
        """
        feature, ink = self._feature[family].double().numpy(), self._ink[family].double().numpy()
        order = np.argsort(-feature, kind="stable")
        feature, ink = np.maximum(feature[order], 1e-12), ink[order]
        total, slope = np.cumsum(ink), np.cumsum(ink / feature)
        left = total - feature * slope
        wanted = share * total[-1]
        last = max(int(np.searchsorted(left, wanted, side="right")) - 1, 0)
        return float(max((total[last] - wanted) / slope[last], 0.0))

    def scores(self, thresholds: Floats, boundaries: bool, rough: bool = False) -> Floats:
        """(B,) scores of (B, 4) thresholds; rough ones in bfloat16."""
        with torch.inference_mode(), torch.autocast("cpu", torch.bfloat16, enabled=rough):
            chunks = torch.split(torch.from_numpy(thresholds).float(), CHUNK)
            parts = [self._score(self.drawings(t, boundaries)) for t in chunks]
        return torch.cat(parts).double().numpy()

    def slope(self, thresholds: Floats, boundaries: bool) -> tuple[float, Floats]:
        """The score at one (4,) t, and its (4,) gradient by backpropagation through drawing and network."""
        t = torch.from_numpy(thresholds).float()[None].requires_grad_()
        score = self._score(self.drawings(t, boundaries))[0]
        (gradient,) = torch.autograd.grad(score, t)
        return score.item(), gradient[0].double().numpy()

    def _score(self, drawings: Tensor) -> Tensor:
        """(B, 1, S, S) drawings -> (B,) scores."""
        poses = zip((drawings, drawings.flip(-1)), self._embedded, strict=False)
        return torch.stack([self._ranker.score(drawn, seen) for drawn, seen in poses]).mean(dim=0)

    def drawings(self, thresholds: Tensor, boundaries: bool) -> Tensor:
        """(B, 4) thresholds -> (B, 1, S, S) drawings I(t) = max(I_G(t), I_L) as the ranking module sees them."""
        ink = line_drawing(self._ink, self._feature, self._always[boundaries], thresholds)
        base = self._base[boundaries].expand(len(thresholds), -1)
        whole = base.index_add(1, self._cell, ink[:, self._source] * self._weight)
        size = self._ranker.dims.size
        return whole.reshape(-1, 1, size, size)
