"""Calibration: the votes on held-out shapes tell a checkpoint what its ranking module's scores mean for people."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, read_pairs
from ncmodel.images import read_grey
from ncmodel.model.maps import item_maps
from ncmodel.model.preference import Preference, Votes, cross_fitted, fit_preference, reliability
from ncmodel.model.score import PictureScore
from ncmodel.nets.checkpoints import Checkpoint, load_checkpoint, save_checkpoint
from ncmodel.nets.presets import Percentile
from ncmodel.nets.ranking import RankingModule

RECORD = "preference"
"""Where a checkpoint's record of its training keeps the temperature, and how far probabilities can be believed."""


def preference_of(checkpoint: Checkpoint) -> Preference | None:
    """What the checkpoint knows of people's preferences; None if no held-out votes were at hand.

    A model that counts ink says log-odds: how much each of its voices counts was fitted to held-out votes.
    """
    if checkpoint.statistics is not None:
        stages = checkpoint.training.get("stages", {})
        return Preference(1.0) if stages.get("statistics", {}).get("validation") else None
    record = checkpoint.training.get(RECORD)
    return None if record is None else Preference(float(record["temperature"]))


def calibrate_file(path: str | Path, data: str | Path, pairs: str | Path) -> dict[str, Any] | None:
    """Calibrate a checkpoint on the pairs of the split `validation`, and keep what was found in it.

    Returns:
        What is kept: `temperature`, `error` (expected calibration error on shapes that the temperature wasn't fitted
        to), the `bins` of the reliability diagram, and how many `pairs` and `shapes` it is of. None without a ranking
        module or such pairs, or where the model says log-odds by itself; the checkpoint then holds nothing.

    Raises:
        InputError: A file can't be used.
    """
    checkpoint = load_checkpoint(path)
    held_out = [pair for pair in read_pairs(pairs) if pair.split == "validation"]
    found = None
    if checkpoint.ranker is not None and checkpoint.statistics is None and held_out:
        found = calibrate(checkpoint.ranker, DataFolder(data), held_out, checkpoint.preset.percentile)
    if checkpoint.training.get(RECORD) != found:
        checkpoint.training.pop(RECORD, None)
        checkpoint.training |= {} if found is None else {RECORD: found}
        save_checkpoint(path, checkpoint)
    return found


def calibrate(
    ranker: RankingModule, data: DataFolder, pairs: Sequence[Pair], percentile: Percentile = "view"
) -> dict[str, Any]:
    """What held-out votes say of a ranking module's scores; see `calibrate_file`."""
    by_item: dict[Item, list[Pair]] = {}
    for pair in pairs:
        by_item.setdefault(pair.item, []).append(pair)
    ordered = [pair for item in sorted(by_item) for pair in by_item[item]]
    better, worse = [], []
    for item in sorted(by_item):
        score = PictureScore(ranker, item_maps(data, item, ranker.pick.given, percentile))
        scores = score.scores(1.0 - read_grey(path) for path in data.drawing_paths(item))
        better += [float(scores[pair.better]) for pair in by_item[item]]
        worse += [float(scores[pair.worse]) for pair in by_item[item]]
    votes, shapes = Votes.of(ordered, better, worse), [pair.item.shape for pair in ordered]
    found = reliability(cross_fitted(votes, shapes), votes.wins, votes.losses)
    return {
        "temperature": fit_preference(votes).temperature,
        "error": found.error,
        "bins": [asdict(part) for part in found.bins],
        "pairs": len(ordered),
        "shapes": len(set(shapes)),
    }
