"""The ranking module's score of pictures: drawings of a view of which nothing is known but their ink."""

from collections.abc import Iterable

import numpy as np
import torch

from ncmodel.model.letterbox import Square
from ncmodel.nets.presets import BACKGROUND
from ncmodel.nets.ranking import RankingModule
from ncmodel.types import Floats, Image

BATCH = 16
"""Drawings scored at a time."""


class PictureScore:
    """f(I, E, O) for one view.

    Args:
        ranker: The ranking module f.
        maps: (7, H, W) depth E and shaded maps O, of any size.
    """

    def __init__(self, ranker: RankingModule, maps: Image) -> None:
        self._ranker = ranker
        square = Square(maps.shape[1], maps.shape[2], ranker.dims.size)
        with torch.inference_mode():
            self._embedded = ranker.embed(torch.from_numpy(square.fit(maps, BACKGROUND))[None])

    def scores(self, inks: Iterable[Image]) -> Floats:
        """(N,) scores of N drawings, (H, W) ink each, of any size that shows the view in the same frame."""
        size = self._ranker.dims.size
        fitted = [Square(ink.shape[0], ink.shape[1], size).fit(ink, background=0.0) for ink in inks]
        drawings = torch.from_numpy(np.asarray(fitted, dtype=np.float32).reshape(-1, 1, size, size))
        with torch.inference_mode():
            parts = [self._ranker.score(part, self._embedded) for part in torch.split(drawings, BATCH)]
        return torch.cat(parts).double().numpy()
