"""What could have been chosen: the eight drawings of a view, and the 256 settings that models choose among.

The best of them show what a perfect judge would reach; how a ranking module orders them shows how far it is one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from eval.comparison.methods import Drawn, as_read
from eval.measures.evaluation import Score, Target
from eval.measures.metrics import mean_measures
from eval.measures.thinning import binarise, read_ink
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.drawing.settings import INK_LEVEL, LayeredDrawings
from ncmodel.export.page import WIDTH, legible_width
from ncmodel.images import png_ink
from ncmodel.types import Floats, Image

BEST_OF_8 = "best of 8"
BEST_OF_ALL = "best of 256"
CHOSEN = "chosen by voters"
FAVOURITE = "favourite of 256"
"""Rows: the drawing nearest to the references, what voters chose, and what a ranking module likes best."""


@dataclass(frozen=True, eq=False)
class Judged:
    """Some drawings of a view against its references.

    Attributes:
        drawing: What gives the (H, W) ink of drawing number N.
        scores: Of each drawing, against each reference.
    """

    drawing: Callable[[int], Image]
    scores: Sequence[tuple[Score, ...]]

    @property
    def f1(self) -> Floats:
        """(N,) F1 of the mean precision and recall over the references."""
        return np.array([mean_measures([score.measures for score in scores]).f1 for scores in self.scores])

    @property
    def best(self) -> int:
        """The drawing nearest to the references; the first among equals."""
        return int(np.argmax(self.f1))

    def drawn(self, number: int) -> Drawn:
        """A drawing, and its file."""
        ink = self.drawing(number)
        return Drawn(ink, png_ink(ink))


def judge_selected(data: DataFolder, item: Item, target: Target) -> Judged:
    """The eight drawings that were voted on."""
    inks = [read_ink(path) for path in data.drawing_paths(item)]
    return _judge(inks.__getitem__, len(inks), target)


def judge_candidates(candidates: LayeredDrawings, target: Target) -> Judged:
    """The drawings of all settings."""
    return _judge(candidates.drawing, len(candidates.levels.settings), target)


def _judge(drawing: Callable[[int], Image], count: int, target: Target) -> Judged:
    """Measure drawings; those of the same pixels once."""
    known: dict[bytes, tuple[Score, ...]] = {}
    scores = []
    for number in range(count):
        ink = _measurable(drawing(number))
        pixels = np.packbits(binarise(ink, target.settings.threshold)).tobytes()
        if pixels not in known:
            known[pixels] = target.scores(target.prepare(ink))
        scores.append(known[pixels])
    return Judged(drawing, scores)


def _measurable(ink: Image) -> Image:
    """The ink as it is; in a picture so small that its lines are grey for want of width, all that is inked."""
    height, width = ink.shape
    return as_read(ink) if legible_width(width, height) == WIDTH else (ink > INK_LEVEL).astype(np.float32)


def rank_correlation(scores: Floats, f1: Floats) -> float | None:
    """Spearman's correlation of scores with F1; None where either is the same for all drawings."""
    from scipy.stats import spearmanr

    if np.ptp(scores) == 0.0 or np.ptp(f1) == 0.0:
        return None
    return float(spearmanr(scores, f1).statistic)
