"""One training stage, pass by pass, that goes on where it was stopped and, on a CPU, ends in the same bytes as if not.

The whole state (weights, Adam's moments, the best weights so far, the history) is written after every pass, atomically.
All randomness of a pass comes from (seed, stage, pass), so the state needs no generator's inner state.
"""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from ncmodel.errors import UsageError
from ncmodel.nets.checkpoints import Tensors, load_tensors, save_tensors
from ncmodel.progress import Progress, silent
from ncmodel.training.objectives import Measures, Objective

STAGES = ("ranker", "translator", "finetune", "statistics")
STATE_KIND = "neural-contours training state"


@dataclass(frozen=True)
class Plan:
    """How far to train, and what identifies the training.

    Attributes:
        state: File that the state is kept in.
        settings: JSON-ready values that a state must share to be gone on with: preset, seed, data.
        epochs: Passes over the data, those of earlier runs included.
        seconds: Start no further step after this long; the pass then ends early.
        seed: Of order and variation.
    """

    state: Path
    settings: Mapping[str, Any]
    epochs: int
    seed: int
    seconds: float | None = None


@dataclass
class Progressed:
    """How far a stage has come.

    Attributes:
        history: One record a finished pass: "epoch", "loss" and the validation measures.
        best_epoch: The pass whose weights are kept; 0 for those that the stage started from.
        best: Those weights, by network and name.
        start: Validation measures of the weights that the stage started from; empty where these were untrained.
    """

    history: list[dict[str, Any]] = field(default_factory=list)
    best_epoch: int = 0
    best: Tensors = field(default_factory=dict)
    start: Measures = field(default_factory=dict)

    @property
    def validation(self) -> Measures:
        """Validation measures of the kept weights."""
        record = self.history[self.best_epoch - 1] if self.best_epoch else self.start
        return {key: value for key, value in record.items() if key not in ("epoch", "loss")}


class _Trainer:
    """Networks, their optimiser, and the moving average of their weights.

    Attributes:
        networks: What is trained, with the weights that the next step starts from.
        optimiser: Adam.
        average: Moving average of the weights and buffers, by name.
        steps: Steps taken so far, those of earlier runs included.
    """

    def __init__(self, objective: Objective) -> None:
        self.networks = nn.ModuleDict(objective.networks)
        self.networks.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self.networks.requires_grad_(True)
        self.optimiser = torch.optim.Adam(self.networks.parameters(), lr=objective.rates.learning_rate)
        self.decay, self.steps = objective.averaging, 0
        self.average = _copied(self.networks)

    def start(self, objective: Objective) -> Progressed:
        """Before the first step: prepare untrained networks, judge trained ones, which training has to better."""
        objective.prepare()
        self.average = _copied(self.networks)
        if not objective.pretrained:
            return Progressed()
        with self.averaged():
            return Progressed(best=_copied(self.networks), start=objective.validate())

    def step(self, loss: Tensor) -> float:
        """Take one step down a loss."""
        self.optimiser.zero_grad()
        torch.autograd.backward(loss)
        self.optimiser.step()
        self.steps += 1
        # Early on, the average follows closely: it would else remember the initial weights for long.
        decay = min(self.decay, self.steps / (self.steps + 9)) if self.decay else 0.0
        with torch.no_grad():
            for name, value in self.networks.state_dict().items():
                if value.is_floating_point():  # and no counter of batches
                    self.average[name].lerp_(value, 1 - decay)
        return loss.item()

    @contextmanager
    def averaged(self) -> Iterator[None]:
        """The networks have their average weights in the block, and are in evaluation mode."""
        now = _copied(self.networks)
        self.networks.load_state_dict(self.average)
        self.networks.eval()
        try:
            yield
        finally:
            self.networks.load_state_dict(now)
            self.networks.train()


def fit(objective: Objective, plan: Plan, progress: Progress = silent) -> Progressed:
    """Train an objective's networks; they end with the weights of the pass that did best on held-out items.

    Raises:
        UsageError: The state file is of a training with other settings, or the loss is no number any more.
    """
    begin = time.monotonic()
    trainer = _Trainer(objective)
    done = _resume(plan, trainer)
    if done is None:
        done = trainer.start(objective)
    left = range(len(done.history), plan.epochs)
    with _deterministic(), progress(objective.name, len(left)) as advance:
        for epoch in left:
            if _over(begin, plan.seconds) and done.history:
                break
            rng = np.random.default_rng([plan.seed, STAGES.index(objective.name), epoch])
            loss = _one_pass(trainer, objective.steps(rng), begin, plan.seconds)
            with trainer.averaged():
                measures = objective.validate()
            if not np.isfinite([loss, *measures.values()]).all():
                raise UsageError(f"training of the {objective.name} diverged in pass {epoch + 1}: the loss is {loss}")
            done.history.append({"epoch": epoch + 1, "loss": loss, **measures})
            if not done.validation or objective.loss_of(measures) < objective.loss_of(done.validation):
                done.best_epoch = epoch + 1
                done.best = {name: value.clone() for name, value in trainer.average.items()}
            _save(plan, trainer, done)
            advance(", ".join(f"{key} {value:.4f}" for key, value in {"loss": loss, **measures}.items()))
    trainer.networks.load_state_dict(done.best)
    trainer.networks.eval().requires_grad_(False)
    return done


def _one_pass(trainer: _Trainer, steps: Sequence[Callable[[], Tensor]], begin: float, seconds: float | None) -> float:
    """Take the steps of one pass (at least one) and return their mean loss."""
    losses: list[float] = []
    trainer.networks.train()
    for step in steps:
        if losses and _over(begin, seconds):
            break
        losses.append(trainer.step(step()))
    return float(np.mean(losses))


def _over(begin: float, seconds: float | None) -> bool:
    return seconds is not None and time.monotonic() - begin > seconds


@contextmanager
def _deterministic() -> Iterator[None]:
    """On a CPU, take the reproducible version of operations that torch has in several; for GPUs it lacks some."""
    before = torch.are_deterministic_algorithms_enabled()
    torch.use_deterministic_algorithms(not torch.cuda.is_available())
    try:
        yield
    finally:
        torch.use_deterministic_algorithms(before)


def _copied(networks: nn.Module) -> Tensors:
    return {name: tensor.detach().clone() for name, tensor in networks.state_dict().items()}


def _save(plan: Plan, trainer: _Trainer, done: Progressed) -> None:
    """Write the state after a pass."""
    tensors = {f"now.{name}": value for name, value in trainer.networks.state_dict().items()}
    tensors |= {f"average.{name}": value for name, value in trainer.average.items()}
    tensors |= {f"best.{name}": value for name, value in done.best.items()}
    for index, moments in trainer.optimiser.state_dict()["state"].items():
        tensors |= {f"adam.{index}.{key}": value for key, value in moments.items()}
    progressed = {"history": done.history, "best_epoch": done.best_epoch, "start": done.start, "steps": trainer.steps}
    save_tensors(plan.state, STATE_KIND, tensors, {"settings": plan.settings, **progressed})


def _resume(plan: Plan, trainer: _Trainer) -> Progressed | None:
    """Bring a trainer to where an earlier run stopped; None when there was none."""
    if not plan.state.exists():
        return None
    tensors, header = load_tensors(plan.state, STATE_KIND)
    for key, value in plan.settings.items():
        was = header["settings"].get(key, value)  # states of before don't tell the pictures
        if was != value:
            raise UsageError(
                f"{plan.state}: an earlier training had {key} {was}, now {value}; expected the same, or a restart"
            )
    parts: dict[str, Tensors] = {"now": {}, "average": {}, "best": {}, "adam": {}}
    for name, tensor in tensors.items():
        part, _, rest = name.partition(".")
        parts[part][rest] = tensor
    moments: dict[int, Tensors] = {}
    for name, tensor in parts["adam"].items():
        index, _, key = name.partition(".")
        moments.setdefault(int(index), {})[key] = tensor
    trainer.networks.load_state_dict(parts["now"])
    trainer.optimiser.load_state_dict({**trainer.optimiser.state_dict(), "state": moments})
    for name, value in parts["average"].items():
        trainer.average[name].copy_(value)
    trainer.steps = header["steps"]
    return Progressed(header["history"], header["best_epoch"], parts["best"], header["start"])
