"""What a process may take, in time and memory, and the sentence that says what it died of."""

import resource
import signal
from dataclasses import dataclass

_GIGABYTE = 1 << 30
_OUT_OF_MEMORY = ("MemoryError", "bad_alloc", "allocate", "out of memory")
"""What Python, C++, compilers and the system say."""


@dataclass(frozen=True)
class Limits:
    """What one call may take.

    Attributes:
        seconds: On the clock.
        memory_gb: Address space of its process.
    """

    seconds: float
    memory_gb: float

    @property
    def too_slow(self) -> str:
        """What is said of a call that took too long."""
        return f"it took more than {self.seconds:g} s"

    @property
    def too_large(self) -> str:
        """What is said of a call that needed too much memory."""
        return f"it needs more than {self.memory_gb:g} GB of memory"

    def apply(self) -> None:
        """Let the kernel hold this process to its memory, and to its seconds from now on of processor time.

        Native code that hangs keeps a process from noticing that its parent is gone; the kernel's clock doesn't ask.
        """
        used = resource.getrusage(resource.RUSAGE_SELF)
        _lower(resource.RLIMIT_AS, self.memory_gb * _GIGABYTE)
        _lower(resource.RLIMIT_CPU, int(used.ru_utime + used.ru_stime + min(self.seconds, 1e9)) + 2)

    def cause_of_death(self, status: int, complaints: str) -> str:
        """Why a process under these limits is gone.

        Args:
            status: Its exit status, negative for a signal.
            complaints: What it wrote on stderr.
        """
        last = (complaints.strip().splitlines() or ["no message"])[-1]
        if status == -signal.SIGXCPU:
            return self.too_slow
        if any(word in last for word in _OUT_OF_MEMORY):
            return self.too_large
        how = f"signal {signal.Signals(-status).name}" if status < 0 else f"status {status}"
        return f"its process died with {how} ({last})"


def _lower(which: int, value: float) -> None:
    hard = resource.getrlimit(which)[1]
    soft = int(value) if value < resource.RLIM_INFINITY % (1 << 63) else hard
    resource.setrlimit(which, (soft if hard < 0 else min(soft, hard), hard))
