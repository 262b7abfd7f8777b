"""Networks on disk: safetensors for the numbers, a JSON header for what they mean. No pickle, so nothing in it can run.

The header says which networks the file holds, their preset, and how they were trained. Nothing in a file depends on the
time or the machine's name: the same training gives the same bytes.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import safetensors.torch
import torch
from safetensors import SafetensorError, safe_open
from torch import Tensor, nn

from ncmodel.errors import InputError
from ncmodel.files import atomic
from ncmodel.nets.presets import Preset, StatisticsDims
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.regressor import GeometryRegressor
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.nets.translation import TranslationBranch
from ncmodel.parsing import parse_json

FORMAT_VERSION = 1
MODEL_KIND = "neural-contours model"
_HEADER_KEY = "neural-contours"
NETWORKS = ("ranker", "translator", "statistics", "regressor")
"""What a checkpoint may hold."""

Tensors = dict[str, Tensor]


@dataclass
class Checkpoint:
    """Trained networks and where they come from.

    Attributes:
        preset: Dimensions of both networks and how they are trained.
        ranker: The neural ranking module, if it has been trained.
        translator: The image translation branch, if it has been trained.
        statistics: The ranker on plain numbers, if it has been trained.
        regressor: The network of the appendix that predicts thresholds, if it has been trained.
        training: What the training recorded: seed, pairs, and per stage its epochs and validation measures.
    """

    preset: Preset
    ranker: RankingModule | None = None
    translator: TranslationBranch | None = None
    statistics: StatisticsRanker | None = None
    regressor: GeometryRegressor | None = None
    training: dict[str, Any] = field(default_factory=dict)

    @property
    def networks(self) -> dict[str, nn.Module]:
        """The networks that are there, by name."""
        known = {name: getattr(self, name) for name in NETWORKS}
        return {name: network for name, network in known.items() if network is not None}


def build_network(name: str, preset: Preset) -> nn.Module:
    """One of `NETWORKS`, with weights as torch happens to draw them."""
    if name == "statistics":
        return StatisticsRanker(preset.statistics or StatisticsDims())
    if name == "ranker":
        return RankingModule(preset.ranking, preset.inputs)
    if name == "regressor":
        return GeometryRegressor(preset)
    return TranslationBranch(preset.translation, preset.inputs)


def save_checkpoint(path: str | Path, checkpoint: Checkpoint) -> None:
    """Write networks and header, atomically."""
    networks = checkpoint.networks
    tensors = {f"{name}.{key}": value for name, net in networks.items() for key, value in net.state_dict().items()}
    header = {
        "preset": checkpoint.preset.to_record(),
        "networks": list(networks),
        "training": checkpoint.training,
        "versions": {"neural-contours": version("neural-contours"), "torch": torch.__version__},
    }
    save_tensors(path, MODEL_KIND, tensors, header)


def load_checkpoint(path: str | Path, device: torch.device | str = "cpu") -> Checkpoint:
    """Read networks, in evaluation mode.

    Raises:
        InputError: The file is missing, of another kind or version, or its tensors don't fit what its header says.
    """
    tensors, header = load_tensors(path, MODEL_KIND, device)
    expected = "the header of a trained model"
    try:
        preset = Preset.from_record(header["preset"])
        names = list(header["networks"])
        training = dict(header["training"])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(path, f"damaged header ({error})", expected) from error
    if not set(names) <= set(NETWORKS) or not names:
        raise InputError(path, f"networks are {names}", f"some of {', '.join(NETWORKS)}")
    loaded: dict[str, Any] = {name: _assemble(path, name, preset, tensors) for name in names}
    if tensors:
        raise InputError(path, f"tensor {min(tensors)!r} is of no network", expected)
    return Checkpoint(preset, **loaded, training=training)


def _assemble(path: str | Path, name: str, preset: Preset, tensors: Tensors) -> nn.Module:
    """One network with its tensors, which are taken out of `tensors`."""
    with torch.device("meta"):
        # No memory is spent before the file has shown that it fits its header.
        network: nn.Module = build_network(name, preset)
    own = {}
    for key, wanted in network.state_dict().items():
        found = tensors.pop(f"{name}.{key}", None)
        if found is None or found.shape != wanted.shape or found.dtype != wanted.dtype:
            what = "is missing" if found is None else f"is {tuple(found.shape)} {found.dtype}"
            fits = f"{tuple(wanted.shape)} {wanted.dtype}, as the preset {preset.name!r} in its header says"
            raise InputError(path, f"tensor {name}.{key} {what}", fits)
        if found.is_floating_point() and not _all_finite(found):
            raise InputError(path, f"tensor {name}.{key} has numbers that aren't finite", "finite weights")
        own[key] = found
    network.load_state_dict(own, assign=True)
    return network.eval().requires_grad_(False)


def _all_finite(values: Tensor) -> bool:
    """Whether all are numbers: their sum is one then, and costs a third; a sum that isn't may have overflowed."""
    return bool(values.sum().isfinite()) or bool(values.isfinite().all())


def save_tensors(path: str | Path, kind: str, tensors: Mapping[str, Tensor], header: Mapping[str, Any]) -> None:
    """Write tensors and a JSON header, atomically, the same bytes for the same content.

    Args:
        path: Where to.
        kind: What the file is; `load_tensors` checks it.
        tensors: By name.
        header: JSON-ready values; no NaN.
    """
    text = json.dumps({"kind": kind, "version": FORMAT_VERSION, **header}, sort_keys=True, allow_nan=False)
    dense = {name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()}
    with atomic(path) as aside:
        safetensors.torch.save_file(dense, aside, metadata={_HEADER_KEY: text})


def load_tensors(path: str | Path, kind: str, device: torch.device | str = "cpu") -> tuple[Tensors, dict[str, Any]]:
    """Read what `save_tensors` wrote.

    Raises:
        InputError: The file is missing, of another kind or version, or damaged.
    """
    if not Path(path).is_file():
        raise InputError(path, "no such file", f"a {kind}")
    try:
        with safe_open(path, framework="pt", device=str(device)) as file:
            text = (file.metadata() or {}).get(_HEADER_KEY, "")
            header = parse_json(text) if text else {}
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
    except (SafetensorError, OSError, ValueError) as error:
        raise InputError(path, f"not a safetensors file ({error})", f"a {kind}") from error
    if not isinstance(header, dict) or header.get("kind") != kind:
        found = header.get("kind") if isinstance(header, dict) else None
        raise InputError(path, f"holds a {found or 'file of some other program'}", f"a {kind}")
    if header.get("version") != FORMAT_VERSION:
        raise InputError(path, f"format version {header.get('version')}", f"version {FORMAT_VERSION}")
    return tensors, header
