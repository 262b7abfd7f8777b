"""Choosing thresholds: maximise the ranking module's score over t >= 0 (section 3.3, equation 6).

The score isn't convex in t, and it ends in plateaus where a family has faded away. So a grid comes first, laid out in
how much ink of each family is left rather than in t, whose useful range differs from mesh to mesh; then L-BFGS-B climbs
from the grid's best points with gradients from backpropagation. The best of everything that was evaluated wins.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from scipy.optimize import minimize

from ncmodel.errors import ArgumentError, UsageError
from ncmodel.types import Floats


class Fades(Protocol):
    """How a family's ink fades."""

    @property
    def present(self) -> bool:
        """Whether the family has lines in this view."""

    def threshold(self, share: float) -> float:
        """The t at which `share` of the ink is left; the least t without any for share 0."""


class ScoredDrawing(Protocol):
    """The score of a view's drawing as a function of its thresholds."""

    def scores(self, thresholds: Floats, boundaries: bool, rough: bool = False) -> Floats:
        """(B,) scores of (B, 4) thresholds; `rough` ones are good enough to tell where climbing is worthwhile."""

    def slope(self, thresholds: Floats, boundaries: bool) -> tuple[float, Floats]:
        """The score at one (4,) t, and its (4,) gradient."""

    def glance(self, thresholds: Floats) -> Floats:
        """(B, C) what the drawings of (B, 4) thresholds look like from afar: those at a small distance score alike.

        All lines and none are about 1 apart.
        """

    @property
    def fading(self) -> Sequence[Fades]:
        """How each of the four families fades."""

    @property
    def has_boundaries(self) -> bool:
        """Whether the view shows boundaries, so that drawing them is a choice."""


@dataclass(frozen=True)
class Budget:
    """How thoroughly to search.

    Attributes:
        shares: Of each family's ink, the shares that the grid goes through.
        full_grid: Try all combinations of shares; else change one family at a time, starting from the middle share.
        climbs: How many of the best grid points to climb from.
        iterations: Most L-BFGS-B iterations a climb.
        rough_grid: Score the grid in the numbers in which the device is fastest. Only climbed points then count.
        mirrored: Take the mean of what the ranking module says of a drawing and of its mirror image, which is as good:
            the search then leads less often to what only pleases the module.
        shortlist: With a model that counts ink: how many of the settings that its numbers favour the ranking module
            looks at.
        looks: With a large ranking module: how many scores with gradient a surrogate is fitted to, in place of grid and
            climbs (`ncmodel/model/surrogate_search.py`). 0: grid and climbs.
    """

    shares: tuple[float, ...]
    full_grid: bool
    climbs: int
    iterations: int
    rough_grid: bool = False
    mirrored: bool = False
    shortlist: int = 0
    looks: int = 0

    def __post_init__(self) -> None:
        if not self.shares or not all(0 <= share <= 1 for share in self.shares):
            raise ValueError(f"shares are {self.shares}, expected at least one in 0..1")
        if self.climbs < 0 or (self.climbs and self.iterations < 1) or (self.rough_grid and not self.climbs):
            raise ValueError(f"{self}: expected climbs of at least one iteration, and some after a rough grid")


BUDGETS = {
    "draft": Budget((0.6, 0.3, 0.0), full_grid=False, climbs=1, iterations=4, rough_grid=True, shortlist=4),
    "balanced": Budget(
        (0.6, 0.3, 0.0), full_grid=True, climbs=3, iterations=12, rough_grid=True, mirrored=True, shortlist=16
    ),
    "accurate": Budget(
        (0.6, 0.3, 0.0, 0.85, 0.45), full_grid=True, climbs=8, iterations=30, mirrored=True, shortlist=64
    ),
}
"""The search budget of each preset. The shares are like those that the candidates' thresholds leave of real meshes'
lines: a ranking module judges drawings like those that it was trained on, and all lines of all families aren't."""

LARGE_BUDGETS = {
    "draft": Budget((0.6,), full_grid=True, climbs=0, iterations=0, looks=5, shortlist=4),
    "balanced": Budget((0.6,), full_grid=True, climbs=0, iterations=0, looks=20, shortlist=16),
    "accurate": Budget((0.6,), full_grid=True, climbs=0, iterations=0, looks=75, shortlist=64),
}
"""The same for ranking modules as large as the paper's, which take a second for a gradient."""

INSTANT = replace(BUDGETS["draft"], shortlist=0)
"""The budget of a choice by numbers alone, for models that count ink."""


@dataclass(frozen=True)
class Trial:
    """One climb.

    Attributes:
        start: t that it started from.
        thresholds: t that it ended at.
        score: There.
        evaluations: Scores (with gradient) that it took.
        converged: Whether L-BFGS-B found that it can't get better, instead of running out of iterations.
    """

    start: tuple[float, ...]
    thresholds: tuple[float, ...]
    score: float
    evaluations: int
    converged: bool


@dataclass(frozen=True)
class Optimum:
    """The thresholds chosen for a view, and how they were found.

    Attributes:
        thresholds: t = (t_S, t_R, t_V, t_A), in units of the 90th percentiles; 0 for families without lines.
        present: Which of the four families have lines in this view.
        boundaries: Whether to draw boundaries.
        score: Of the drawing.
        evaluations: Drawings scored, those of climbs included.
        converged: Whether the climb that led there converged; True if the best point needed none.
        flat: The score is the same for all thresholds tried.
        trials: Every climb.
    """

    thresholds: tuple[float, ...]
    present: tuple[bool, ...]
    boundaries: bool
    score: float
    evaluations: int
    converged: bool
    flat: bool
    trials: tuple[Trial, ...] = field(default=())


def budget_named(preset: str, large: bool = False) -> Budget:
    """A search budget by its preset's name; another one for `large` ranking modules.

    Raises:
        UsageError: There is none of that name.
    """
    known = {"instant": INSTANT, **(LARGE_BUDGETS if large else BUDGETS)}
    if preset not in known:
        raise ArgumentError("preset", repr(preset), f"one of {', '.join(known)}")
    return known[preset]


def optimise(drawing: ScoredDrawing, budget: Budget) -> Optimum:
    """Find the thresholds whose drawing scores highest, and whether boundaries belong in it.

    Boundaries are in while the thresholds are searched; then the drawing without them is tried and climbed from.

    Raises:
        UsageError: No score is a number.
    """
    search = _Search(drawing, budget)
    search.grid()
    search.climb()
    if drawing.has_boundaries:
        search.leave_out_boundaries()
    return search.result()


@dataclass(frozen=True)
class _Point:
    """One evaluated drawing."""

    score: float
    thresholds: tuple[float, ...]
    boundaries: bool = True
    converged: bool = True
    rough: bool = False


class _Search:
    """Everything evaluated so far."""

    def __init__(self, drawing: ScoredDrawing, budget: Budget) -> None:
        self.drawing, self.budget = drawing, budget
        self.families = [family for family, fading in enumerate(drawing.fading) if fading.present]
        self.scale = np.array([fading.threshold(0.5) if fading.present else 1.0 for fading in drawing.fading])
        self.scale = np.maximum(self.scale, 1e-6)
        self.points: list[_Point] = []
        self.trials: list[Trial] = []
        self.evaluations = 0

    @property
    def best(self) -> _Point:
        """The highest score; the first among equals. Rough scores count until there are others."""
        exact = [point for point in self.points if not point.rough]
        return max(exact or self.points, key=lambda point: point.score)

    def result(self) -> Optimum:
        """The optimum, once everything has been tried."""
        best, finite = self.best, [point.score for point in self.points if point.score > -np.inf]
        if not finite:
            raise UsageError("the ranking module gives no score that is a number: its weights don't fit these drawings")
        return Optimum(
            thresholds=best.thresholds,
            present=tuple(fading.present for fading in self.drawing.fading),
            boundaries=best.boundaries and self.drawing.has_boundaries,
            score=best.score,
            evaluations=self.evaluations,
            converged=best.converged,
            flat=max(finite) == min(finite),
            trials=tuple(self.trials),
        )

    def grid(self) -> None:
        """Evaluate the grid of ink shares; its first point, the middle share of all, wins ties."""
        shares, rough = self.budget.shares, self.budget.rough_grid and bool(self.families)
        tried = {family: [self.drawing.fading[family].threshold(share) for share in shares] for family in self.families}
        if self.budget.full_grid:
            combinations = itertools.product(*tried.values())
            self._try([self._at(dict(zip(tried, values, strict=True))) for values in combinations], rough=rough)
            return
        self._try([self._at({family: values[0] for family, values in tried.items()})], rough=rough)
        for family, values in tried.items():
            here = np.array(self.best.thresholds)
            self._try([np.where(np.arange(4) == family, value, here) for value in values[1:]], rough=rough)

    def climb(self) -> None:
        """Climb from the best points of the grid."""
        order = sorted(self.points, key=lambda point: -point.score)
        for point in order[: self.budget.climbs if self.families else 0]:
            self._climb_from(np.array(point.thresholds), boundaries=True)

    def leave_out_boundaries(self) -> None:
        """Try the best drawing without boundaries, and climb from there if it is better."""
        best = self.best
        self._try([np.array(best.thresholds)], boundaries=False)
        if self.points[-1].score > best.score and self.families:
            self._climb_from(np.array(best.thresholds), boundaries=False)

    def _at(self, values: dict[int, float]) -> Floats:
        """(4,) thresholds; 0 where not given."""
        return np.array([values.get(family, 0.0) for family in range(4)])

    def _try(self, thresholds: Sequence[Floats], boundaries: bool = True, rough: bool = False) -> None:
        scores = self.drawing.scores(np.stack(thresholds), boundaries, rough)
        self.evaluations += len(thresholds)
        for t, score in zip(thresholds, np.where(np.isnan(scores), -np.inf, scores), strict=True):
            self.points.append(_Point(float(score), tuple(t.tolist()), boundaries, rough=rough))

    def _climb_from(self, start: Floats, boundaries: bool) -> None:
        """L-BFGS-B from one point, in units in which each family's half of the ink lies at 1."""
        chosen, climbed = self.families, list[_Point]()

        def descend(x: Floats) -> tuple[float, Floats]:
            t = start.copy()
            t[chosen] = x * self.scale[chosen]
            score, slope = self.drawing.slope(t, boundaries)
            if not (np.isfinite(score) and np.isfinite(slope).all()):
                return 1e30, np.zeros(len(chosen))
            climbed.append(_Point(score, tuple(t.tolist()), boundaries))
            return -score, -slope[chosen] * self.scale[chosen]

        bounds = [(0.0, self.drawing.fading[family].threshold(0.0) / self.scale[family]) for family in chosen]
        found = minimize(
            descend,
            start[chosen] / self.scale[chosen],
            jac=True,
            method="L-BFGS-B",
            bounds=bounds,
            options={"maxiter": self.budget.iterations, "maxfun": 2 * self.budget.iterations},
        )
        self.evaluations += int(found.nfev)
        if climbed:
            top = max(climbed, key=lambda point: point.score)
            self.points.append(replace(top, converged=bool(found.success)))
            start_t = tuple(start.tolist())
            self.trials.append(Trial(start_t, top.thresholds, top.score, int(found.nfev), bool(found.success)))
