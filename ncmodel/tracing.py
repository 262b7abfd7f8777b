"""Lazy stages: what a request doesn't touch is never computed, and what is computed is timed once.

A class with a `trace` attribute marks its expensive quantities with `@stage`; each is then a cached property that
records its own seconds (those of the stages it calls excluded) in the trace.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Generic, TypeVar, overload

from ncmodel.types import Trace

T = TypeVar("T")

_nested: list[float] = []


@contextmanager
def timed(trace: Trace, name: str) -> Iterator[None]:
    """Record the seconds spent in the block, without those of blocks timed inside it."""
    _nested.append(0.0)
    begin = time.perf_counter()
    try:
        yield
    finally:
        elapsed = time.perf_counter() - begin
        inner = _nested.pop()
        if _nested:
            _nested[-1] += elapsed
        trace.record(name, elapsed - inner)


class stage(Generic[T]):
    """A cached property that records its time in the instance's `trace`."""

    def __init__(self, function: Callable[[Any], T]) -> None:
        self.function = function
        self.name = function.__name__
        self.__doc__ = function.__doc__

    @overload
    def __get__(self, instance: None, owner: type) -> "stage[T]": ...
    @overload
    def __get__(self, instance: object, owner: type) -> T: ...
    def __get__(self, instance: Any, owner: type) -> "stage[T] | T":
        if instance is None:
            return self
        if self.name not in instance.__dict__:
            with timed(instance.trace, self.name):
                instance.__dict__[self.name] = self.function(instance)
        value: T = instance.__dict__[self.name]
        return value
