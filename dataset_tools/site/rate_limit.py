"""Token buckets: how often somebody may do something."""

import threading
from collections import OrderedDict
from collections.abc import Callable

MAX_KNOWN = 100_000
"""Buckets kept; the ones that weren't used for longest are forgotten first."""


class RateLimit:
    """Allows each name a burst, and then a steady rate.

    Args:
        burst: How often at once.
        rate: How often a second after that.
        clock: Seconds, never going back.
    """

    def __init__(self, burst: int, rate: float, clock: Callable[[], float]) -> None:
        self._burst, self._rate, self._clock = burst, rate, clock
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()
        self._lock = threading.Lock()

    def allows(self, name: str) -> bool:
        """Whether `name` may do it now; if so, it is counted."""
        with self._lock:
            left = self._left(name)
            self._buckets[name] = (left - 1.0 if left >= 1.0 else left, self._clock())
            self._buckets.move_to_end(name)
            while len(self._buckets) > MAX_KNOWN:
                self._buckets.popitem(last=False)
        return left >= 1.0

    def would_allow(self, name: str) -> bool:
        """Whether `name` may do it now; nothing is counted."""
        with self._lock:
            return self._left(name) >= 1.0

    def _left(self, name: str) -> float:
        """How often `name` may do it at once."""
        left, since = self._buckets.get(name, (float(self._burst), 0.0))
        return min(float(self._burst), left + (self._clock() - since) * self._rate)
