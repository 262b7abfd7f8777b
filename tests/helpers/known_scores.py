"""Known functions of thresholds in place of a ranking module's score."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ncmodel.types import Floats, Mask

Score = Callable[[Floats], float]

HALF, LARGEST = 0.5, 4.0


@dataclass(frozen=True)
class Knees:
    """A family of which half the ink is left at t = 0.5, and none at t = 4."""

    present: bool = True

    def threshold(self, share: float) -> float:
        assert self.present
        return float(np.interp(share, [0.0, 0.5, 1.0], [LARGEST, HALF, 0.0]))


@dataclass
class Known:
    """A view's drawing whose score is known, 1e-6 steps apart differentiated; counts what it is asked."""

    score: Score
    present: Mask = field(default_factory=lambda: np.ones(4, dtype=np.bool_))
    boundary_gain: float | None = None
    rough_error: float = 0.0
    calls: int = 0

    @property
    def has_boundaries(self) -> bool:
        return self.boundary_gain is not None

    @property
    def fading(self) -> Sequence[Knees]:
        return [Knees(bool(present)) for present in self.present]

    def scores(self, thresholds: Floats, boundaries: bool, rough: bool = False) -> Floats:
        assert thresholds.shape[1] == 4
        assert (thresholds >= 0).all()
        self.calls += len(thresholds)
        gain = (self.boundary_gain or 0.0) if boundaries else 0.0
        error = self.rough_error if rough else 0.0
        return np.array([self.score(t) + gain + error for t in thresholds])

    def glance(self, thresholds: Floats) -> Floats:
        """Shares of ink, half of each family at most: all lines and none are 1 apart."""
        seen: Floats = np.interp(thresholds, [0.0, HALF, LARGEST], [0.5, 0.25, 0.0])
        return seen

    def slope(self, thresholds: Floats, boundaries: bool) -> tuple[float, Floats]:
        here = float(self.scores(thresholds[None], boundaries)[0])
        steps = 1e-6 * np.eye(4)
        ahead = np.array([self.score(thresholds + step) - self.score(thresholds - step) for step in steps])
        return here, ahead / 2e-6
