"""What a stage needs to go on, in one file: weights, Adam's moments, the best weights so far, the history.

It is written after every pass and, within long ones, every so many seconds, atomically. All randomness of a pass comes
from (seed, stage, pass), so that within one the number of steps taken tells the rest; what networks draw at random
themselves (dropout) comes from torch's generator, whose state is kept too.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from ncmodel.errors import UsageError
from ncmodel.nets.checkpoints import Tensors, load_tensors, save_tensors

STATE_KIND = "neural-contours training state"

Measures = dict[str, float]
"""What networks are judged by, by name."""


@dataclass
class Progressed:
    """How far a stage has come.

    Attributes:
        history: One record a finished pass: "epoch", "loss" and the validation measures.
        best_epoch: The pass whose weights are kept; 0 for those that the stage started from.
        best: Those weights, by network and name.
        start: Validation measures of the weights that the stage started from; empty where these were untrained.
        losses: Of the steps taken in the pass that isn't finished.
        random: State of torch's generator after these steps, where an earlier run took them.
    """

    history: list[dict[str, Any]] = field(default_factory=list)
    best_epoch: int = 0
    best: Tensors = field(default_factory=dict)
    start: Measures = field(default_factory=dict)
    losses: list[float] = field(default_factory=list)
    random: Tensor | None = None

    @property
    def validation(self) -> Measures:
        """Validation measures of the kept weights."""
        record = self.history[self.best_epoch - 1] if self.best_epoch else self.start
        return {key: value for key, value in record.items() if key not in ("epoch", "loss")}


@dataclass
class Learner:
    """Networks, their optimiser, and the moving average of their weights.

    Attributes:
        networks: What is trained, with the weights that the next step starts from.
        optimiser: Adam.
        average: Moving average of the weights and buffers, by name.
        steps: Steps taken so far, those of earlier runs included.
    """

    networks: nn.Module
    optimiser: torch.optim.Optimizer
    average: Tensors
    steps: int = 0


def save_state(path: Path, settings: Mapping[str, Any], learner: Learner, done: Progressed) -> None:
    """Write the state after a step.

    Args:
        path: Where to.
        settings: JSON-ready values that identify the training.
        learner: The networks as they are.
        done: How far they have come.
    """
    tensors = {f"now.{name}": value for name, value in learner.networks.state_dict().items()}
    tensors |= {f"average.{name}": value for name, value in learner.average.items()}
    tensors |= {f"best.{name}": value for name, value in done.best.items()}
    for index, moments in learner.optimiser.state_dict()["state"].items():
        tensors |= {f"adam.{index}.{key}": value for key, value in moments.items()}
    header = {"history": done.history, "best_epoch": done.best_epoch, "start": done.start, "steps": learner.steps}
    if done.losses:
        header["losses"] = done.losses
        tensors["random.torch"] = torch.get_rng_state()
    save_tensors(path, STATE_KIND, tensors, {"settings": settings, **header})


def load_state(path: Path, settings: Mapping[str, Any], learner: Learner) -> Progressed | None:
    """Bring networks to where an earlier run stopped; None when there was none.

    Raises:
        InputError: The file is damaged.
        UsageError: It is of a training with other settings.
    """
    if not path.exists():
        return None
    tensors, header = load_tensors(path, STATE_KIND)
    before = header["settings"]
    for key in [*settings, *(key for key in before if key not in settings)]:
        if key == "pictures" and key not in before:
            continue  # states of before don't tell them
        was, now = before.get(key, "the preset's"), settings.get(key, "the preset's")
        if was != now:
            raise UsageError(f"{path}: an earlier training had {key} {was}, now {now}; expected the same, or a restart")
    parts: dict[str, Tensors] = {"now": {}, "average": {}, "best": {}, "adam": {}, "random": {}}
    for name, tensor in tensors.items():
        part, _, rest = name.partition(".")
        parts[part][rest] = tensor
    moments: dict[int, Tensors] = {}
    for name, tensor in parts["adam"].items():
        index, _, key = name.partition(".")
        moments.setdefault(int(index), {})[key] = tensor
    learner.networks.load_state_dict(parts["now"])
    learner.optimiser.load_state_dict({**learner.optimiser.state_dict(), "state": moments})
    for name, value in parts["average"].items():
        learner.average[name].copy_(value)
    learner.steps = header["steps"]
    history, losses = header["history"], header.get("losses", [])
    return Progressed(
        history, header["best_epoch"], parts["best"], header["start"], losses, parts["random"].get("torch")
    )
