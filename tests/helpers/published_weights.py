"""Files like those that users of the published code have."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import torch
from torch import nn

from ncmodel.published.weights import PRESET

NARROW = replace(PRESET, translation=replace(PRESET.translation, width=2), ranking=replace(PRESET.ranking, width=4))
"""The published networks, narrow enough to be quick."""


def save_weights(folder: Path, networks: Mapping[str, nn.Module]) -> tuple[Path, Path]:
    """Write the state dicts of ranking module and image branch; their files."""
    paths = folder / "neural_ranking_module.pth", folder / "image_translation_branch.pth"
    for path, name in zip(paths, ("ranker", "translator"), strict=True):
        torch.save(networks[name].state_dict(), path)
    return paths
