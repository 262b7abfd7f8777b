"""How long computations tell how far they are, to whoever started them."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Protocol


class Advance(Protocol):
    """Called after each finished item; `note` says what it was."""

    def __call__(self, note: str = "") -> None:
        """Count one item."""


Progress = Callable[[str, int], AbstractContextManager[Advance]]
"""Title and number of items -> what is called after each of them."""


def silent(title: str, total: int) -> AbstractContextManager[Advance]:
    """Progress that says nothing."""
    return nullcontext(lambda note="": None)
