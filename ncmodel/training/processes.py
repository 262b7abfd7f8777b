"""Several processes that train together, as `torchrun` starts them: each looks at its part of every step."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta
from typing import TypeVar

import torch
from torch import Tensor, distributed

T = TypeVar("T")

PATIENCE = timedelta(hours=6)
"""How long processes wait for the first one, which alone writes files and trains the ranker on numbers."""


@dataclass(frozen=True)
class Team:
    """The processes of a training, and which of them this is.

    Attributes:
        rank: This one's number; 0 is the one that writes files and talks.
        size: How many there are.
    """

    rank: int = 0
    size: int = 1

    @property
    def leads(self) -> bool:
        """Whether this is the process that writes and talks."""
        return self.rank == 0

    def wait(self) -> None:
        """Wait until all have come here."""
        if self.size > 1:
            distributed.barrier()

    def sum(self, value: float, device: torch.device) -> float:
        """The sum of all processes' numbers."""
        if self.size == 1:
            return value
        total = torch.tensor(value, dtype=torch.float64, device=device)
        distributed.all_reduce(total)
        return total.item()

    def firsts(self, value: T) -> T:
        """What the first process has."""
        if self.size == 1:
            return value
        told = [value]
        distributed.broadcast_object_list(told, src=0)
        return told[0]

    def equalise(self, tensors: Sequence[Tensor]) -> None:
        """Give all processes the first one's tensors."""
        if self.size > 1:
            for tensor in tensors:
                distributed.broadcast(tensor, src=0)

    def gather(self, mine: Sequence[T]) -> list[T]:
        """All values, of which each process has every `size`-th, beginning with its rank's."""
        if self.size == 1:
            return list(mine)
        everybodys: list[list[T]] = [[] for _ in range(self.size)]
        distributed.all_gather_object(everybodys, list(mine))
        rounds = max(map(len, everybodys))
        return [values[number] for number in range(rounds) for values in everybodys if number < len(values)]


ALONE = Team()
"""One process."""


def leads() -> bool:
    """Whether this is the first of the processes that torchrun started, or no other was."""
    return os.environ.get("RANK", "0") == "0"


def own_device(name: str) -> str:
    """The device of this process: of several GPUs, each process of a machine takes one."""
    several = int(os.environ.get("WORLD_SIZE", "1")) > 1
    return f"cuda:{os.environ['LOCAL_RANK']}" if several and name == "cuda" else name


@contextmanager
def team_of(device: torch.device) -> Iterator[Team]:
    """The processes that `torchrun` started, connected by NCCL on GPUs and by gloo elsewhere; else this one alone."""
    if int(os.environ.get("WORLD_SIZE", "1")) == 1:
        yield ALONE
        return
    if device.type == "cuda":
        torch.cuda.set_device(device)
    distributed.init_process_group("nccl" if device.type == "cuda" else "gloo", timeout=PATIENCE)
    try:
        yield Team(distributed.get_rank(), distributed.get_world_size())
    finally:
        distributed.destroy_process_group()
