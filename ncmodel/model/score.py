"""The ranking module's score of a view's drawings: as a function of thresholds, and of pictures of unknown origin.

Of the former, only pixels that carry lines change with t. They are gathered once; each evaluation filters them
(equations 1-5) and adds them into the ranking module's input by the same area averaging that its training pictures went
through.

Letters in shapes: B drawings, P pixels that carry filtered lines, S side of the pictures that the module sees.
"""

from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np
import torch
from torch import Tensor

from ncmodel.model.filters import Fading, Glance, line_drawing
from ncmodel.model.letterbox import Square
from ncmodel.model.maps import LineMaps
from ncmodel.nets.devices import device_of, numbers
from ncmodel.nets.presets import BACKGROUND
from ncmodel.nets.ranking import RankingModule
from ncmodel.types import Floats, Image, Ints

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
        rough: Compute everything in the numbers in which the device is fastest.
    """

    def __init__(
        self,
        ranker: RankingModule,
        maps: Image,
        lines: LineMaps,
        image: Image | None = None,
        mirrored: bool = False,
        rough: bool = False,
    ) -> None:
        self._ranker, self._lines, self._device, self._rough = ranker, lines, device_of(ranker), rough
        square = Square(maps.shape[1], maps.shape[2], ranker.dims.size)
        small = self._there(square.fit(maps, BACKGROUND))[None]
        with torch.no_grad(), numbers(self._device, rough):
            self._embedded = [ranker.embed(seen) for seen in (small, small.flip(-1))[: 1 + mirrored]]
        self._pixels = pixels = np.flatnonzero(lines.lines.any(axis=0))
        source, cell, weight = square.spread(pixels)
        self._source, self._cell, self._weight = self._there(source), self._there(cell), self._there(weight).float()
        ink, feature = (part.reshape(4, -1)[:, pixels] for part in (lines.lines, lines.features))
        self._ink, self._feature = self._there(ink), self._there(feature)
        self._fading = [Fading(*family) for family in zip(ink, feature, strict=True)]
        self._always, self._base = {}, {}
        for boundaries in (False, True):
            parts = [lines.contours, *([lines.boundaries] if boundaries else []), *([] if image is None else [image])]
            always = np.maximum.reduce(parts).ravel()
            self._always[boundaries] = self._there(always[pixels])
            always[pixels] = 0.0
            still = square.fit(always.reshape(maps.shape[1:]), background=0.0)
            self._base[boundaries] = self._there(still.reshape(1, -1))

    def _there(self, values: Floats | Ints | Image) -> Tensor:
        """An array where the ranking module computes."""
        return torch.from_numpy(values).to(self._device)

    @property
    def fading(self) -> Sequence[Fading]:
        """How each of the four families fades."""
        return self._fading

    @property
    def has_boundaries(self) -> bool:
        """Whether the view shows boundaries."""
        return bool(self._lines.boundaries.any())

    def scores(self, thresholds: Floats, boundaries: bool, rough: bool = False) -> Floats:
        """(B,) scores of (B, 4) thresholds; rough ones in the numbers in which the device is fastest."""
        with torch.inference_mode(), numbers(self._device, rough or self._rough):
            chunks = torch.split(self._there(thresholds).float(), CHUNK)
            parts = [self._score(self.drawings(t, boundaries)) for t in chunks]
        return torch.cat(parts).double().cpu().numpy()

    def slope(self, thresholds: Floats, boundaries: bool) -> tuple[float, Floats]:
        """The score at one (4,) t, and its (4,) gradient by backpropagation through drawing and network."""
        t = self._there(thresholds).float()[None].requires_grad_()
        with numbers(self._device, self._rough):
            score = self._score(self.drawings(t, boundaries))[0]
        (gradient,) = torch.autograd.grad(score, t)
        return score.item(), gradient[0].double().cpu().numpy()

    def glance(self, thresholds: Floats) -> Floats:
        """(B, C) what the drawings of (B, 4) thresholds look like from afar, without boundaries and image branch."""
        ink, feature, contours = self._seen
        drawn = line_drawing(ink, feature, contours, torch.from_numpy(thresholds).float())
        return self._glance(drawn.numpy())

    @cached_property
    def _glance(self) -> Glance:
        ink = self._lines.lines.reshape(4, -1)[:, self._pixels].max(axis=0)
        return Glance(self._pixels, ink, self._lines.contours.shape)

    @cached_property
    def _seen(self) -> tuple[Tensor, Tensor, Tensor]:
        """Ink, features and contours of the pixels that are looked at from afar."""
        pixels = self._pixels[self._glance.pixels]
        ink, feature = (part.reshape(4, -1)[:, pixels] for part in (self._lines.lines, self._lines.features))
        return torch.from_numpy(ink), torch.from_numpy(feature), torch.from_numpy(self._lines.contours.ravel()[pixels])

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


class PictureScore:
    """f(I, E, O) for one view.

    Args:
        ranker: The ranking module f.
        maps: (7, H, W) depth E and shaded maps O, of any size.
    """

    def __init__(self, ranker: RankingModule, maps: Image) -> None:
        self._ranker, self._device = ranker, device_of(ranker)
        square = Square(maps.shape[1], maps.shape[2], ranker.dims.size)
        with torch.inference_mode():
            self._embedded = ranker.embed(torch.from_numpy(square.fit(maps, BACKGROUND))[None].to(self._device))

    def scores(self, inks: Iterable[Image]) -> Floats:
        """(N,) scores of N drawings, (H, W) ink each, of any size that shows the view in the same frame."""
        size = self._ranker.dims.size
        fitted = [Square(ink.shape[0], ink.shape[1], size).fit(ink, background=0.0) for ink in inks]
        drawings = torch.from_numpy(np.asarray(fitted, dtype=np.float32).reshape(-1, 1, size, size))
        with torch.inference_mode():
            parts = [self._ranker.score(part.to(self._device), self._embedded) for part in torch.split(drawings, CHUNK)]
        return torch.cat(parts).double().cpu().numpy()
