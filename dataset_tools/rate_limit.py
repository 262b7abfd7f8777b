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
            now = self._clock()
            left, since = self._buckets.pop(name, (float(self._burst), now))
            left = min(float(self._burst), left + (now - since) * self._rate)
            allowed = left >= 1.0
            self._buckets[name] = (left - 1.0 if allowed else left, now)
            while len(self._buckets) > MAX_KNOWN:
                self._buckets.popitem(last=False)
        return allowed
