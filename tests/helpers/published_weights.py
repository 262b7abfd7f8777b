"""Files like those that users of the published code have."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import torch
from torch import nn

from ncmodel.published.weights import PRESET
from tests.helpers.published_reference import Ranking, Translation, randomise

NARROW = replace(PRESET, translation=replace(PRESET.translation, width=2), ranking=replace(PRESET.ranking, width=4))
"""The published networks, narrow enough to be quick."""


def save_weights(folder: Path, networks: Mapping[str, nn.Module]) -> tuple[Path, Path]:
    """Write the state dicts of ranking module and image branch; their files."""
    paths = folder / "neural_ranking_module.pth", folder / "image_translation_branch.pth"
    for path, name in zip(paths, ("ranker", "translator"), strict=True):
        torch.save(networks[name].state_dict(), path)
    return paths


def narrow_networks() -> dict[str, nn.Module]:
    """The reference's networks of these widths, with random weights and batch-norm statistics."""
    return {
        "ranker": randomise(Ranking(NARROW.ranking.width), 1),
        "translator": randomise(Translation(NARROW.translation.width), 2),
    }
