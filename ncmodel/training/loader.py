"""Pictures that are read ahead: worker processes decode the next parts while the networks learn from this one.

Parts come in the order in which they were asked for, with the same bytes, however many workers there are. A worker has
at most `AHEAD` parts ready, so memory stays bounded.
"""

import multiprocessing
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, Self, TypeVar

import torch
from torch import Tensor
from torch.utils.data import DataLoader, Dataset, Sampler

from ncmodel.errors import NeuralContoursError
from ncmodel.training.dataset import ViewImages
from ncmodel.training.processes import ALONE, Team

AHEAD = 2
"""Parts that a worker has ready or in work."""


class Loaded(Protocol):
    """What a part shows, in the machine's memory."""

    def on(self, device: torch.device) -> Any:
        """The same as numbers, on a device."""


class Part(Protocol):
    """What is looked at at once: a step, or a part of it where memory or other processes call for parts."""

    def __len__(self) -> int:
        """How many examples it has, in which a step's loss is a mean."""

    def cut(self, count: int) -> Sequence[Self]:
        """Up to `count` parts, of nearly the same length."""

    def load(self, images: Any) -> Loaded:
        """What it shows."""


P = TypeVar("P", bound=Part)


class Loader:
    """Loads parts, ahead if there are workers; to be closed after use, as a context.

    Args:
        images: Where pictures are; None for a training without.
        workers: Processes that read ahead; 0 reads each part when it is wanted.
    """

    def __init__(self, images: ViewImages | None, workers: int = 0) -> None:
        self._images, self._order = images, _Order()
        self._ahead = None
        if workers and images is not None:
            # Forked from a fresh process: one that holds a GPU, or threads, can't be forked.
            context = multiprocessing.get_context("forkserver")
            context.set_forkserver_preload([__name__])
            self._ahead = DataLoader(
                _Parts(images.for_one_of(workers)),
                batch_size=None,
                sampler=self._order,
                num_workers=workers,
                prefetch_factor=AHEAD,
                persistent_workers=True,
                multiprocessing_context=context,
                worker_init_fn=_start,
            )

    def __enter__(self) -> "Loader":
        return self

    def __exit__(self, *_: object) -> None:
        self._ahead = None  # its workers end with it

    def load(self, parts: Sequence[Part]) -> Iterator[Any]:
        """What each part shows, in order."""
        if self._ahead is None:
            for part in parts:
                yield part.load(self._images)
            return
        self._order.parts = parts
        for loaded in self._ahead:
            if isinstance(loaded, NeuralContoursError):
                raise loaded
            yield loaded


class _Order(Sampler[Any]):
    """The parts of this pass, which the workers are told one by one."""

    def __init__(self) -> None:
        self.parts: Sequence[Part] = ()

    def __iter__(self) -> Iterator[Any]:
        return iter(self.parts)

    def __len__(self) -> int:
        return len(self.parts)


class _Parts(Dataset[Any]):
    """What a worker has: the pictures' places."""

    def __init__(self, images: ViewImages) -> None:
        self.images = images

    def __getitem__(self, part: Part) -> Any:
        try:
            return part.load(self.images)
        except NeuralContoursError as error:
            return error  # raised in a worker, it would come out as many lines


def _start(_: int) -> None:
    """A worker keeps to one core, and ends with the training, however that ends."""
    import cv2

    cv2.setNumThreads(1)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """DataLoader's own watch is on the process that forked the worker, which lives as long as a worker does."""
    parent = multiprocessing.parent_process()
    assert parent is not None, "a worker was started by a training"
    parent.join()
    os._exit(1)


class Examiner:
    """Has parts judged: each process of a team judges its share, and all get all answers.

    Args:
        loader: Loads them.
        team: The processes.
    """

    def __init__(self, loader: Loader, team: Team = ALONE) -> None:
        self.loader, self.team = loader, team

    def answers(self, parts: Sequence[P], judge: Callable[[Any], Tensor]) -> list[Tensor]:
        """What `judge` says of each part's pictures, which it is given as they are kept; on the CPU."""
        mine = parts[self.team.rank :: self.team.size]
        return self.team.gather([judge(loaded).cpu() for loaded in self.loader.load(mine)])
