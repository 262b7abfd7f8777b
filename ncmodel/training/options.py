"""How to train: what the command line and Python callers choose beside the data and the preset."""

from dataclasses import dataclass
from typing import Literal

import torch

from ncmodel.errors import ArgumentError
from ncmodel.nets.devices import device_named, is_fast_in_bfloat16
from ncmodel.training.batch_norm import BATCH_NORMS, BatchNorm
from ncmodel.training.loop import SAVE_EVERY, STAGES, Means
from ncmodel.training.processes import Team, own_device

Precision = Literal["float32", "bfloat16"]


@dataclass(frozen=True)
class TrainOptions:
    """How to train.

    Attributes:
        stages: Some of "ranker", "translator", "finetune", "statistics", in this order; what the preset has by default.
            Or "regressor", the appendix's other way to find thresholds.
        epochs: Passes over the data in each stage, those of earlier runs included; the preset's numbers by default.
        seconds: Stop early after this long; the stages get shares of it. How far a machine gets in a time varies, so
            only training without it is reproducible.
        seed: Of initial weights, order and variation.
        restart: Forget an earlier training that wrote to the same place.
        device: Where to compute: "cpu", "cuda", or another of torch's devices. Under torchrun, "cuda" is a GPU for each
            process.
        workers: Processes that read pictures ahead; with 0, each is read when it is wanted. They change no byte.
        micro_batch: Look at most at so many pairs (or views, where these are trained on) at a time, and add up
            gradients to the whole step's; a step at a time by default.
        precision: "bfloat16" computes convolutions in it, by torch's autocast, and keeps weights in float32. By
            default on GPUs that are fast in it; elsewhere "float32".
        batch_norm: What batch norm goes by where a step is cut into parts: each part's "own" statistics, those of all
            processes ("synchronised"), or the running ones ("frozen"), which don't learn then.
        save_every: Seconds after which a state to go on from is written within a pass.
        objective: What one of the stages minimises in place of its own loss: an entry point's name, or MODULE:CLASS.
        curves: Keep a page with the curves beside the checkpoint.
    """

    stages: tuple[str, ...] | None = None
    epochs: int | None = None
    seconds: float | None = None
    seed: int = 0
    restart: bool = False
    device: str = "cpu"
    workers: int = 0
    micro_batch: int | None = None
    precision: Precision | None = None
    batch_norm: BatchNorm = "own"
    save_every: float = SAVE_EVERY
    objective: str | None = None
    curves: bool = False

    def __post_init__(self) -> None:
        if self.stages is not None and not (self.stages and set(self.stages) <= set(STAGES)):
            raise ArgumentError("stages", repr(",".join(self.stages)), f"all or one of {', '.join(STAGES)}")
        if self.epochs is not None and self.epochs < 1:
            raise ArgumentError("epochs", str(self.epochs), "at least 1")
        if self.seconds is not None and not self.seconds > 0:
            raise ArgumentError("seconds", str(self.seconds), "a positive number")
        if self.seed < 0:
            raise ArgumentError("seed", str(self.seed), "0 or more")
        if self.workers < 0:
            raise ArgumentError("workers", str(self.workers), "0 or more")
        if self.micro_batch is not None and self.micro_batch < 1:
            raise ArgumentError("micro_batch", str(self.micro_batch), "at least 1")
        if self.precision not in (None, "float32", "bfloat16"):
            raise ArgumentError("precision", repr(self.precision), "float32 or bfloat16")
        if self.batch_norm not in BATCH_NORMS:
            raise ArgumentError("batch_norm", repr(self.batch_norm), f"one of {', '.join(BATCH_NORMS)}")
        if not self.save_every > 0:
            raise ArgumentError("save_every", str(self.save_every), "a positive number of seconds")
        device_named(self.own_device)

    @property
    def own_device(self) -> str:
        """The device of this process."""
        return own_device(self.device)

    def means(self, team: Team) -> Means:
        """With what a team computes."""
        device = torch.device(self.own_device)
        fast = device.type == "cuda" and is_fast_in_bfloat16(device)
        rough = fast if self.precision is None else self.precision == "bfloat16"
        return Means(self.workers, self.micro_batch, rough, self.batch_norm, self.save_every, team)
