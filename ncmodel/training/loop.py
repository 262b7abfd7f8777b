"""One training stage, step by step, that goes on where it was stopped and, on a CPU, ends in the same bytes as if not.

A step's loss is the mean over its examples. It may be taken in parts, one after the other for want of memory or side by
side in several processes, whose gradients are added: that is the whole step's gradient (batch norm aside, see
`ncmodel/training/batch_norm.py`).
"""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.parallel import DistributedDataParallel

from ncmodel.errors import UsageError
from ncmodel.nets.checkpoints import Tensors
from ncmodel.nets.devices import device_of
from ncmodel.progress import Progress, silent
from ncmodel.training.batch_norm import BatchNorm, freeze, synchronise
from ncmodel.training.loader import Examiner, Loader, Part
from ncmodel.training.objectives import Objective
from ncmodel.training.processes import ALONE, Team
from ncmodel.training.state import Learner, Progressed, load_state, save_state

STAGES = ("ranker", "translator", "finetune", "statistics", "regressor")
"""Their order tells their random numbers apart."""

SAVE_EVERY = 300.0
"""Seconds after which a state is written within a pass."""


@dataclass(frozen=True)
class Means:
    """With what a training computes. Its steps stay the same, up to rounding and to what batch norm goes by.

    Attributes:
        workers: Processes that read pictures ahead; 0 reads each when it is wanted.
        micro_batch: Look at most at so many pairs or views at a time; at all of a process's by default.
        bfloat16: Compute in bfloat16 what torch's autocast does; weights stay in float32.
        batch_norm: What batch norm goes by.
        save_every: Seconds after which a state is written within a pass.
        team: The processes that train together.
    """

    workers: int = 0
    micro_batch: int | None = None
    bfloat16: bool = False
    batch_norm: BatchNorm = "own"
    save_every: float = SAVE_EVERY
    team: Team = ALONE


@dataclass(frozen=True)
class Plan:
    """How far to train, and what identifies the training.

    Attributes:
        state: File that the state is kept in.
        settings: JSON-ready values that a state must share to be gone on with: preset, seed, data.
        epochs: Passes over the data, those of earlier runs included.
        seconds: Start no further step after this long; the pass then ends early.
        seed: Of order and variation.
        means: With what it computes.
    """

    state: Path
    settings: Mapping[str, Any]
    epochs: int
    seed: int
    seconds: float | None = None
    means: Means = field(default_factory=Means)


class _Loss(nn.Module):
    """An objective's loss as the module that several processes share."""

    def __init__(self, objective: Objective) -> None:
        super().__init__()
        self.networks = nn.ModuleDict(objective.networks)
        self._loss = objective.loss

    def forward(self, batch: Any) -> Tensor:
        return self._loss(batch)


class Trainer(Learner):
    """Takes steps.

    Args:
        objective: What is learnt.
        means: With what.
    """

    def __init__(self, objective: Objective, means: Means) -> None:
        self.means, self.decay = means, objective.averaging
        self._loss: nn.Module = _Loss(objective)
        networks = self._loss.networks
        networks.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        networks.requires_grad_(True)
        if means.batch_norm == "synchronised" and means.team.size > 1:
            synchronise(networks)
        self.device = device_of(networks)
        super().__init__(
            networks, torch.optim.Adam(networks.parameters(), lr=objective.rates.learning_rate), _copied(networks)
        )
        if means.team.size > 1:
            self._loss = DistributedDataParallel(self._loss)

    def start(self, objective: Objective, examiner: Examiner) -> Progressed:
        """Before the first step: prepare untrained networks, judge trained ones, which training has to better."""
        objective.prepare()
        self.average = _copied(self.networks)
        if not objective.pretrained:
            return Progressed()
        with self.averaged():
            return Progressed(best=_copied(self.networks), start=objective.validate(examiner))

    def parts(self, step: Part) -> list[tuple[Part, float]]:
        """What this process looks at of a step, one after the other, and how much of the step each is."""
        team, at_once = self.means.team, self.means.micro_batch or len(step)
        rounds = -(-len(step) // (at_once * team.size))
        parts = step.cut(rounds * team.size) if rounds * team.size > 1 else [step]
        shares = [(part, len(part) / len(step)) for part in parts]
        # With fewer examples than processes, one without a part looks at the first, which counts for nothing there.
        shares += [(parts[0], 0.0)] * (rounds * team.size - len(parts))
        return shares[team.rank :: team.size]

    def step(self, shares: Sequence[float], loaded: Iterator[Any]) -> float:
        """Take one step down the loss of its parts, weighted by their shares; return the whole step's loss."""
        team, total = self.means.team, 0.0
        self.optimiser.zero_grad()
        for number, share in enumerate(shares):
            with self._adding_up(number == len(shares) - 1):
                with self.computing():
                    loss = self._loss(next(loaded).on(self.device)) * share
                # Processes take the mean of their gradients where the step's is the sum.
                torch.autograd.backward(loss * team.size if team.size > 1 else loss)
            total += loss.item()
        self.optimiser.step()
        self.steps += 1
        # Early on, the average follows closely: it would else remember the initial weights for long.
        decay = min(self.decay, self.steps / (self.steps + 9)) if self.decay else 0.0
        with torch.no_grad():
            for name, value in self.networks.state_dict().items():
                if value.is_floating_point():  # and no counter of batches
                    self.average[name].lerp_(value, 1 - decay)
        return team.sum(total, self.device)

    def learn(self) -> None:
        """Put the networks into training mode."""
        self.networks.train()
        if self.means.batch_norm == "frozen":
            freeze(self.networks)

    def computing(self) -> AbstractContextManager[object]:
        """The block computes in bfloat16 if that was asked for."""
        if not self.means.bfloat16:
            return nullcontext()
        return torch.autocast(self.device.type, torch.bfloat16)

    @contextmanager
    def averaged(self) -> Iterator[None]:
        """The networks have their average weights in the block, and are in evaluation mode."""
        now = _copied(self.networks)
        self.means.team.equalise(list(self.average.values()))
        self.networks.load_state_dict(self.average)
        self.networks.eval()
        try:
            with self.computing():
                yield
        finally:
            self.networks.load_state_dict(now)
            self.networks.train()

    def _adding_up(self, last: bool) -> AbstractContextManager[object]:
        """Processes exchange gradients after the last part only."""
        shared = self._loss if isinstance(self._loss, DistributedDataParallel) else None
        return shared.no_sync() if shared and not last else nullcontext()


def fit(
    objective: Objective,
    plan: Plan,
    progress: Progress = silent,
    watch: Callable[[Progressed], None] = lambda _: None,
) -> Progressed:
    """Train an objective's networks; they end with the weights of the pass that did best on held-out items.

    Args:
        objective: What is learnt.
        plan: How far.
        progress: Is told about every pass.
        watch: Sees how far it has come, before the first pass and after every one.

    Raises:
        UsageError: The state file is of a training with other settings, or the loss is no number any more.
    """
    clock = _Clock(plan)
    trainer = Trainer(objective, plan.means)
    done = load_state(plan.state, plan.settings, trainer)
    with _deterministic(trainer.device), Loader(objective.images, plan.means.workers) as loader:
        examiner = Examiner(loader, plan.means.team)
        if done is None:
            done = trainer.start(objective, examiner)
        watch(done)
        left = range(len(done.history), plan.epochs)
        with progress(objective.name, len(left)) as advance:
            for epoch in left:
                if done.history and clock.over():
                    break
                rng = np.random.default_rng([plan.seed, STAGES.index(objective.name), epoch])
                _one_pass(trainer, objective.steps(rng), loader, done, clock)
                with trainer.averaged():
                    measures = objective.validate(examiner)
                loss = float(np.mean(done.losses))
                if not np.isfinite([loss, *measures.values()]).all():
                    raise UsageError(
                        f"training of the {objective.name} diverged in pass {epoch + 1}: the loss is {loss}"
                    )
                done.history.append({"epoch": epoch + 1, "loss": loss, **measures})
                done.losses = []
                if not done.validation or objective.loss_of(measures) < objective.loss_of(done.validation):
                    done.best_epoch = epoch + 1
                    done.best = {name: value.clone() for name, value in trainer.average.items()}
                clock.save(trainer, done)
                watch(done)
                advance(", ".join(f"{key} {value:.4f}" for key, value in {"loss": loss, **measures}.items()))
    trainer.networks.load_state_dict(done.best)
    trainer.networks.eval().requires_grad_(False)
    return done


def _one_pass(trainer: Trainer, steps: Sequence[Part], loader: Loader, done: Progressed, clock: "_Clock") -> None:
    """Take the steps of one pass that are left, at least one if none was taken; their losses come to `done`."""
    trainer.learn()
    if done.random is not None:
        torch.set_rng_state(done.random)
        done.random = None
    ahead = [trainer.parts(step) for step in steps[len(done.losses) :]]
    loaded = loader.load([part for parts in ahead for part, _ in parts])
    saved = False
    for number, parts in enumerate(ahead, start=1):
        if done.losses and clock.over():
            break
        done.losses.append(trainer.step([share for _, share in parts], loaded))
        # A pass long enough to be saved within is so at its end too, before it is judged, which may take long again.
        if clock.due() or (saved and number == len(ahead)):
            clock.save(trainer, done)
            saved = True


class _Clock:
    """When to write a state, and when to stop."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.begin = self.saved = time.monotonic()

    def over(self) -> bool:
        """Whether the time is up, for all processes alike."""
        if self.plan.seconds is None:
            return False
        return self.plan.means.team.firsts(time.monotonic() - self.begin > self.plan.seconds)

    def due(self) -> bool:
        """Whether the last state is too old."""
        return time.monotonic() - self.saved >= self.plan.means.save_every

    def save(self, trainer: Trainer, done: Progressed) -> None:
        """Write a state, in the process that does."""
        if self.plan.means.team.leads:
            save_state(self.plan.state, self.plan.settings, trainer, done)
        self.saved = time.monotonic()


@contextmanager
def _deterministic(device: torch.device) -> Iterator[None]:
    """On a CPU, take the reproducible version of operations that torch has in several; for GPUs it lacks some."""
    before = torch.are_deterministic_algorithms_enabled()
    torch.use_deterministic_algorithms(device.type == "cpu")
    try:
        yield
    finally:
        torch.use_deterministic_algorithms(before)


def _copied(networks: nn.Module) -> Tensors:
    return {name: tensor.detach().clone() for name, tensor in networks.state_dict().items()}
