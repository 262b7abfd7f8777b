"""Choosing among settings: the drawing that people would most probably prefer, by its numbers and by its picture.

No thresholds are searched: the 256 drawings of a view are unions of a dozen layers, and counting ink in all of them
takes milliseconds. A ranking module, if there is one, looks at a shortlist.
"""

from dataclasses import dataclass

import numpy as np
import torch

from ncmodel.drawing.settings import LayeredDrawings, Levels, Setting, draw_layers
from ncmodel.model.letterbox import Square
from ncmodel.model.statistics import statistics
from ncmodel.nets.devices import device_of
from ncmodel.nets.presets import BACKGROUND, MAPS
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.scene.view import View
from ncmodel.tracing import timed
from ncmodel.types import Floats, Image, Ints, LineFamily, Mask


@dataclass(frozen=True)
class Choice:
    """What was chosen of a view.

    Attributes:
        setting: The setting.
        score: In log-odds: its difference to another drawing's score tells how probably people prefer it.
        evaluations: Pictures that the ranking module looked at.
    """

    setting: Setting
    score: float
    evaluations: int


def choose_setting(
    view: View,
    maps: Image,
    counting: StatisticsRanker,
    ranker: RankingModule | None,
    shortlist: int,
    allowed: tuple[LineFamily, ...] = tuple(LineFamily),
    image: Image | None = None,
    mirrored: bool = False,
) -> Choice:
    """Choose a setting.

    Args:
        view: The view, at the resolution that training saw.
        maps: (K, H, W) depth and shaded maps of it, perhaps others after them.
        counting: The ranker on numbers.
        ranker: The ranking module, if it takes part.
        shortlist: How many settings it looks at.
        allowed: The families that may be drawn.
        image: (H, W) ink of the image branch, if that takes part.
        mirrored: Take the mean of the ranking module's scores of a drawing and of its mirror image.
    """
    drawings = draw_layers(view, Levels())
    with timed(view.trace, "setting_choice"):
        return choose_among(drawings, maps, counting, ranker, shortlist, allowed, image, mirrored)


def choose_among(
    drawings: LayeredDrawings,
    maps: Image,
    counting: StatisticsRanker,
    ranker: RankingModule | None,
    shortlist: int,
    allowed: tuple[LineFamily, ...] = tuple(LineFamily),
    image: Image | None = None,
    mirrored: bool = False,
) -> Choice:
    """Choose a setting of a view whose layers are drawn; as `choose_setting`."""
    levels, scores = drawings.levels, setting_scores(drawings, maps, counting)
    scores[~_allowed(levels, allowed)] = -np.inf
    # Of drawings that people like as well, the one with fewer layers: a stable sort by layers comes first.
    order = np.lexsort((levels.members.sum(axis=1), -scores))
    looked_at = order[: shortlist if ranker is not None else 0]
    looked_at = looked_at[np.isfinite(scores[looked_at])]
    if ranker is not None and len(looked_at):
        scores[looked_at] += counting.mix[2].item() * _pictures(drawings, looked_at, maps, ranker, image, mirrored)
        best = int(looked_at[np.argmax(scores[looked_at])])
    else:
        best = int(order[0])
    return Choice(levels.settings[best], float(scores[best]), len(looked_at) * (1 + mirrored))


def setting_scores(drawings: LayeredDrawings, maps: Image, counting: StatisticsRanker) -> Floats:
    """(256,) log-odds of each setting by numbers and habit."""
    found = statistics(drawings.masks, drawings.levels.members, maps[0], maps[1 : len(MAPS)])
    with torch.inference_mode():
        counted = counting(torch.from_numpy(found.numbers())).double().numpy()
    mix, habit = counting.mix.double().numpy(), counting.habit.double().numpy()
    scores: Floats = mix[0] * counted + mix[1] * habit
    return scores


def _allowed(levels: Levels, families: tuple[LineFamily, ...]) -> Mask:
    """(256,) which settings draw none but these families; contours always may."""
    fits = [all(family in (LineFamily.CONTOURS, *families) for family in layer.families) for layer in levels.layers]
    return np.asarray(~(levels.members & ~np.array(fits)).any(axis=1))


def _pictures(
    drawings: LayeredDrawings, chosen: Ints, maps: Image, ranker: RankingModule, image: Image | None, mirrored: bool
) -> Floats:
    """(n,) what the ranking module thinks of some drawings, merged with the image branch's."""
    square = Square(maps.shape[1], maps.shape[2], ranker.dims.size)
    always = 0.0 if image is None else image
    small = np.stack([square.fit(np.maximum(drawings.drawing(int(index)), always), background=0.0) for index in chosen])
    fitted = square.fit(maps, BACKGROUND)[None], small[:, None]
    seen, drawn = (torch.from_numpy(part).to(device_of(ranker)) for part in fitted)
    with torch.inference_mode():
        poses = [(drawn, seen), (drawn.flip(-1), seen.flip(-1))][: 1 + mirrored]
        scores = torch.stack([ranker.score(drawing, ranker.embed(view)) for drawing, view in poses]).mean(dim=0)
    return np.asarray(scores.double().cpu().numpy())
