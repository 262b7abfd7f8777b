"""The plain numbers of a picture: how much of which lines a drawing shows of which nothing is known but its ink.

A picture is taken for the setting whose lines it shows most nearly, with as much ink as it has. A drawing that a
setting gives is taken for itself.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch

from ncmodel.chamfer import distance_to
from ncmodel.drawing.settings import INK_LEVEL, LayeredDrawings
from ncmodel.model.statistics import FAINT, statistics
from ncmodel.nets.presets import MAPS
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.types import Floats, Image, Mask

REACHES = (0.0, 5.0 / 768)
"""Shares of the picture's shorter side within which ink and lines are one: exactly, and as hands draw."""


def picture_scores(inks: Sequence[Image], drawings: LayeredDrawings, maps: Image, counting: StatisticsRanker) -> Floats:
    """(N,) log-odds of N pictures by their numbers and by habit.

    Args:
        inks: (H, W) ink of each, at the size of the layers.
        drawings: The layers of the view.
        maps: (K, H, W) depth and shaded maps, perhaps others after them.
        counting: The ranker on numbers.
    """
    layers, members = drawings.masks, drawings.levels.members
    known = statistics(layers, members, maps[0], maps[1 : len(MAPS)])
    pictures = [np.asarray(ink > INK_LEVEL) for ink in inks]
    nearest = np.array([_nearest_setting(picture, layers, members) for picture in pictures], dtype=np.int64)
    numbers, apart = known.drawings[nearest], ~layers[0]
    for row, picture, setting in zip(numbers, pictures, nearest, strict=True):
        shown = layers[members[setting]].any(axis=0) & apart
        row[0] *= (picture & apart).sum() / max(int(shown.sum()), 1)
        row[1] = np.log(row[0] + FAINT)
    found = replace(known, drawings=numbers, members=members[nearest])
    with torch.inference_mode():
        counted = counting(torch.from_numpy(found.numbers())).double().numpy()
    mix, habit = counting.mix.double().numpy(), counting.habit.double().numpy()
    scores: Floats = mix[0] * counted + mix[1] * habit[nearest]
    return scores


def _nearest_setting(picture: Mask, layers: Mask, members: Mask) -> int:
    """The setting whose drawing agrees best with a picture, by F1; of equals the one with the fewest layers."""
    agreement = np.zeros(len(members))
    inked = np.asarray(layers.any(axis=0))
    lines = layers[:, inked].astype(np.float32)
    drawn = members.astype(np.float32) @ lines > 0
    for reach in REACHES:
        pixels = reach * min(picture.shape)
        near_picture = (distance_to(picture) <= pixels)[inked]
        recall = (drawn & near_picture).sum(axis=1) / np.maximum(drawn.sum(axis=1), 1)
        near_layers = np.stack([(distance_to(layer) <= pixels)[picture] for layer in layers]).astype(np.float32)
        precision = (members.astype(np.float32) @ near_layers > 0).sum(axis=1) / max(int(picture.sum()), 1)
        agreement += 2 * precision * recall / np.maximum(precision + recall, 1e-12)
    return int(np.lexsort((members.sum(axis=1), -agreement))[0])
