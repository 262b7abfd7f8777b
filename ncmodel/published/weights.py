"""The published checkpoints as one of ours.

They are two state dicts of PyTorch, `neural_ranking_module.pth` and `image_translation_branch.pth`. Both networks are
ours under other names, except that

* the lower score is the better drawing there: `head` is negated;
* an output near 1 is background there: the image branch's last convolution is negated;
* inputs aren't measured: the drawing goes in as it is, maps less a mean brightness.
"""

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from ncmodel.errors import ArgumentError, InputError
from ncmodel.images import FULL_16
from ncmodel.nets.checkpoints import Checkpoint, Tensors, build_network
from ncmodel.nets.presets import PRESETS, Preset, RankingDims, TranslationDims
from ncmodel.types import Floats, Image

SIDE = 1024
"""Of the square that the ranking module sees, pixels."""

SHADED_MEAN, DEPTH_MEAN = 0.974258, 0.906764
"""What is taken from the brightness of shaded maps and of depth."""

_SHADED = tuple(f"shaded_{level}" for level in range(6))

PRESET = replace(
    PRESETS["paper"],
    name="published",
    translation=TranslationDims(size=SIDE, inputs=(*_SHADED, "depth"), style="pix2pixhd"),
    ranking=RankingDims(size=SIDE, inputs=("shaded_0", "depth")),
    published=True,
)
"""The published networks: channels in their order, 182,492,289 and 73,728,833 parameters."""

_NORM = ("weight", "bias", "running_mean", "running_var", "num_batches_tracked")
_CONV = ("weight",)
_BIASED = ("weight", "bias")
_WHAT = {
    "ranker": ("conv1.weight", "the ranking module's weights (neural_ranking_module.pth)"),
    "translator": ("model.1.weight", "the image branch's weights (image_translation_branch.pth)"),
}
"""Network -> a tensor by which its file is told, and what the file should be."""


def centred(maps: Image, names: Sequence[str]) -> Image:
    """(K, H, W) maps of these names as the published networks are handed them: 16 bits less the mean, rounded once.

    The networks' own input layers say the same but for the last digits, which a deep network without ReLUs between its
    blocks makes much of.
    """
    means = np.array([DEPTH_MEAN if name == "depth" else SHADED_MEAN for name in names])
    return np.asarray(stored(maps) - means[:, None, None], dtype=np.float32)


def stored(values: Image) -> Floats:
    """Values in [0, 1] as a 16-bit picture holds them, in double precision."""
    return np.rint(values.astype(np.float64) * FULL_16) / FULL_16


def import_weights(
    ranker: str | Path | None = None, translator: str | Path | None = None, preset: Preset = PRESET
) -> Checkpoint:
    """Read one or both of the published state dicts.

    Args:
        ranker: File of the ranking module.
        translator: File of the image branch.
        preset: What the networks are, if they are narrower than the published ones.

    Raises:
        InputError: A file can't be read, or isn't that network.
        ArgumentError: Neither is given.
    """
    given = {"ranker": ranker, "translator": translator}
    if ranker is None and translator is None:
        raise ArgumentError("ranker", "none, and no translator", "one of them or both")
    sources = {name: Path(path).name for name, path in given.items() if path is not None}
    networks: dict[str, Any] = {name: _network(name, path, preset) for name, path in given.items() if path is not None}
    return Checkpoint(preset, networks.get("ranker"), networks.get("translator"), training={"imported": sources})


def ranker_names(dims: RankingDims) -> dict[str, str]:
    """Our name -> theirs, of every tensor of the ranking module."""
    places = [("stem", "conv1", _CONV), ("stem_norm", "bn1", _NORM), ("head", "fc", _BIASED)]
    for stage, count in enumerate(dims.blocks):
        for block in range(count):
            ours, theirs = f"stages.{stage}.{block}", f"layer{stage + 1}.{block}"
            for part, number in (("first", 1), ("second", 2)):
                places += [(f"{ours}.{part}.0", f"{theirs}.conv{number}", _CONV)]
                places += [(f"{ours}.{part}.1", f"{theirs}.bn{number}", _NORM)]
            if block == 0 and stage > 0:
                places += [(f"{ours}.shortcut.0", f"{theirs}.downsample.0", _CONV)]
                places += [(f"{ours}.shortcut.1", f"{theirs}.downsample.1", _NORM)]
    return _named(places)


def translator_names(dims: TranslationDims) -> dict[str, str]:
    """Our name -> theirs, of every tensor of the image branch; theirs are numbered in one row."""
    levels, blocks = dims.levels, dims.blocks
    last = 1 + 3 * (levels + 1)  # the first of the residual blocks; a picture is padded, convolved, normed, cut
    places = [("layers.0.0.0", "model.1", _BIASED), ("layers.0.0.1", "model.2", _NORM)]
    for level in range(levels):
        down, up = 4 + 3 * level, last + blocks + 3 * level
        places += [(f"layers.{1 + level}.0.0", f"model.{down}", _BIASED)]
        places += [(f"layers.{1 + level}.0.1", f"model.{down + 1}", _NORM)]
        places += [(f"layers.{2 + levels + level}.0", f"model.{up}", _BIASED)]
        places += [(f"layers.{2 + levels + level}.1", f"model.{up + 1}", _NORM)]
    for block in range(blocks):
        ours, theirs = f"layers.{1 + levels}.{block}", f"model.{last + block}.conv_block"
        for part, number in (("first", 1), ("second", 5)):
            places += [(f"{ours}.{part}.0", f"{theirs}.{number}", _BIASED)]
            places += [(f"{ours}.{part}.1", f"{theirs}.{number + 1}", _NORM)]
    places += [(f"layers.{2 + 2 * levels}", f"model.{last + blocks + 3 * levels + 1}", _BIASED)]
    return _named(places)


_CONSTANTS: dict[str, Tensors] = {
    "ranker": {
        "standardise_drawing.background": torch.zeros(1),
        "standardise_drawing.scale": torch.ones(1),
        "standardise_maps.background": torch.tensor([SHADED_MEAN, DEPTH_MEAN]),
        "standardise_maps.scale": torch.ones(2),
    },
    "translator": {
        "standardise.background": torch.tensor([SHADED_MEAN] * len(_SHADED) + [DEPTH_MEAN]),
        "standardise.scale": torch.ones(len(_SHADED) + 1),
    },
}


def _named(places: list[tuple[str, str, tuple[str, ...]]]) -> dict[str, str]:
    return {f"{ours}.{tensor}": f"{theirs}.{tensor}" for ours, theirs, tensors in places for tensor in tensors}


def _network(name: str, path: str | Path, preset: Preset) -> Any:
    """One network, with the weights of its file."""
    expected = _WHAT[name][1]
    found = _state_dict(path, expected)
    for other, (key, what) in _WHAT.items():
        if other != name and key in found and _WHAT[name][0] not in found:
            raise InputError(path, f"holds {what.partition(' (')[0]}", expected)
    with torch.device("meta"):
        network = build_network(name, preset)
    names = ranker_names(preset.ranking) if name == "ranker" else translator_names(preset.translation)
    negated = "head." if name == "ranker" else f"layers.{2 + 2 * preset.translation.levels}."
    wanted, own = network.state_dict(), dict(_CONSTANTS[name])
    for ours, theirs in names.items():
        tensor = _tensor(path, found, theirs, wanted[ours], expected)
        own[ours] = -tensor if ours.startswith(negated) else tensor
    if found:
        raise InputError(path, f"tensor {min(found)!r} is of another network", expected)
    network.load_state_dict(own, assign=True)
    return network.eval().requires_grad_(False)


def _tensor(path: str | Path, found: dict[str, Tensor], name: str, wanted: Tensor, expected: str) -> Tensor:
    """A tensor of the file, which is taken out of `found`; counters of batches may be missing in old files."""
    tensor = found.pop(name, None)
    if tensor is None and name.endswith(".num_batches_tracked"):
        return torch.zeros((), dtype=torch.int64)
    if tensor is None:
        raise InputError(path, f"tensor {name!r} is missing", expected)
    if tensor.shape != wanted.shape:
        raise InputError(path, f"tensor {name!r} is {tuple(tensor.shape)}", f"{tuple(wanted.shape)}: {expected}")
    if not bool(tensor.isfinite().all()):
        raise InputError(path, f"tensor {name!r} has numbers that aren't finite", expected)
    return tensor.to(wanted.dtype).contiguous()


def _state_dict(path: str | Path, expected: str) -> dict[str, Tensor]:
    """The tensors of a file, by name. Nothing in it is run."""
    if not Path(path).is_file():
        raise InputError(path, "no such file", expected)
    try:
        held = torch.load(path, map_location="cpu", weights_only=True)
    except (pickle.UnpicklingError, RuntimeError, EOFError, ValueError, KeyError, OSError, AttributeError) as error:
        # PyTorch's first sentence tells what is wrong, the next ones what to do about its own bugs.
        reason = str(error).splitlines()[0].partition(". ")[0] if str(error) else type(error).__name__
        raise InputError(path, f"no state dict of PyTorch ({reason[:120]})", expected) from error
    if not isinstance(held, Mapping) or not all(isinstance(value, Tensor) for value in held.values()):
        raise InputError(path, f"holds a {type(held).__name__} of other things than tensors", expected)
    # Training on several GPUs puts this before every name.
    return {str(key).removeprefix("module."): value for key, value in held.items()}
