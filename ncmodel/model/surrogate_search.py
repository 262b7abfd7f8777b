"""Choosing thresholds with few looks at a large network: a surrogate of the score is maximised in its place.

The ranking module of the paper takes a second for a score with its gradient. So every one of them counts: a Gaussian
process is fitted to all scores and gradients so far (Solak et al. 2003), five numbers a look, and says where to look
next. At first that is where it expects the largest improvement (Jones et al. 1998), which also leads to where little is
known; at last, where it expects the highest score. The process knows the score as a function of how much ink of each
family is left, in which all families count in the same units and none has a plateau where it has faded away.

References:
    Jones, Schonlau, Welch: Efficient Global Optimization of Expensive Black-Box Functions. Journal of Global
    Optimization 13, 1998.
    Solak, Murray-Smith, Leithead, Leith, Rasmussen: Derivative Observations in Gaussian Process Models of Dynamic
    Systems. NIPS 2003.

Letters in shapes: N looks, D families that have lines, M places.
"""

from collections.abc import Callable

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import ndtr

from ncmodel.errors import UsageError
from ncmodel.model.threshold_search import Optimum, ScoredDrawing, Trial
from ncmodel.types import Floats

STARTS = (0.6, 0.2)
"""Shares of all families' ink that the first looks are at: the score has a hill at much ink and one at little."""

EXPLORING = 0.7
"""Share of the looks that go where improvement is expected; the others go to the top that is known by then."""

LENGTHS = (0.25, 0.35, 0.5, 0.7, 1.0, 1.4)
"""Shares of ink over which scores may vary; the likeliest is taken."""

ROUGHNESS = 1e-4, 1e-2
"""Of scores and of gradients times length, the variance that isn't the process's: networks of ReLUs have kinks."""

NEAREST = 0.005
"""Shares of ink by which places must differ to be worth a look each."""

STEPS = (0.1, 0.05, 0.025, 0.012, 0.006)
"""How far around the most promising places others are tried."""


class Surrogate:
    """A Gaussian process with the squared-exponential covariance, fitted to scores and gradients.

    Args:
        places: (N, D).
        scores: (N,) of about unit size.
        slopes: (N, D) their gradients.

    Attributes:
        length: The likeliest of `LENGTHS`.
    """

    def __init__(self, places: Floats, scores: Floats, slopes: Floats) -> None:
        count, dims = places.shape
        known = np.column_stack([scores, slopes]).ravel()
        one = np.eye(1, dims + 1).repeat(count, axis=0).ravel()
        self.places, likeliest = places, -np.inf
        for length in LENGTHS:
            noise = np.full((count, dims + 1), ROUGHNESS[1] / length**2)
            noise[:, 0] = ROUGHNESS[0]
            factor = cho_factor(_covariance(places, places, length) + np.diag(noise.ravel()), lower=True)
            mean = float(one @ cho_solve(factor, known) / (one @ cho_solve(factor, one)))
            weights = cho_solve(factor, known - mean * one)
            variance = max(float((known - mean * one) @ weights) / len(known), 1e-300)
            likelihood = -0.5 * len(known) * np.log(variance) - np.log(np.diag(factor[0])).sum()
            if likelihood > likeliest:
                likeliest, self.length = likelihood, length
                self._factor, self._mean, self._weights, self._variance = factor, mean, weights, variance

    def __call__(self, places: Floats) -> tuple[Floats, Floats]:
        """(M,) expected scores at (M, D) places, and (M,) their standard deviations."""
        near, sloped = _falloff(places, self.places, self.length)
        values = np.concatenate([near[..., None], sloped], axis=2).reshape(len(places), -1)
        left = 1.0 - (values * cho_solve(self._factor, values.T).T).sum(axis=1)
        return self._mean + values @ self._weights, np.sqrt(np.maximum(left, 1e-12) * self._variance)


def _falloff(a: Floats, b: Floats, length: float) -> tuple[Floats, Floats]:
    """(N, M) covariances of the values at (N, D) places with those at (M, D), and (N, M, D) with the slopes there."""
    apart = (a[:, None] - b[None]) / length
    near = np.exp(-0.5 * np.square(apart).sum(axis=2))
    return near, apart * near[..., None] / length


def _covariance(a: Floats, b: Floats, length: float) -> Floats:
    """Covariances of the values and slopes at (N, D) places with those at (M, D): (N (1 + D), M (1 + D))."""
    dims = a.shape[1]
    near, sloped = _falloff(a, b, length)
    apart = (a[:, None] - b[None]) / length
    out = np.empty((len(a), 1 + dims, len(b), 1 + dims))
    out[:, 0, :, 0] = near
    out[:, 0, :, 1:] = sloped
    out[:, 1:, :, 0] = -np.moveaxis(sloped, 2, 1)
    curved = (np.eye(dims) - apart[..., :, None] * apart[..., None, :]) * near[..., None, None] / length**2
    out[:, 1:, :, 1:] = np.moveaxis(curved, 2, 1)
    return out.reshape(len(a) * (1 + dims), len(b) * (1 + dims))


def optimise_with_surrogate(exact: ScoredDrawing, rough: ScoredDrawing, looks: int) -> Optimum:
    """Find the thresholds whose drawing scores highest, and whether boundaries belong in it.

    Args:
        exact: The drawing.
        rough: The same drawing, scored nearly as well for less: it is looked at, and what was found scored exactly.
        looks: Scores with gradient that this may take, at least 1.

    Raises:
        UsageError: No score is a number.
    """
    families = [family for family, fading in enumerate(exact.fading) if fading.present]
    search = _Search(exact, rough, families)
    if exact.has_boundaries:
        search.choose_boundaries()
    for look in range(looks if families else 0):
        search.look(exploring=look < EXPLORING * looks)
    return search.result()


class _Search:
    """All looks so far.

    Attributes:
        tried: Every place, (D,) shares of ink.
        places, scores, slopes: Of those whose score is a number.
    """

    def __init__(self, exact: ScoredDrawing, rough: ScoredDrawing, families: list[int]) -> None:
        self.exact, self.rough, self.families = exact, rough, families
        self.boundaries, self.evaluations = exact.has_boundaries, 0
        self.tried: list[Floats] = []
        self.places: list[Floats] = []
        self.scores: list[float] = []
        self.slopes: list[Floats] = []

    def choose_boundaries(self) -> None:
        """Draw boundaries if the drawing at the first place is better with them."""
        t = self._thresholds(np.full(len(self.families), STARTS[0]))[None]
        with_them, without = (self.rough.scores(t, boundaries)[0] for boundaries in (True, False))
        self.boundaries = not without > with_them
        self.evaluations += 2

    def look(self, exploring: bool) -> None:
        """Score the most promising place, with its gradient."""
        place = self._promising(exploring)
        score, slope = self.rough.slope(self._thresholds(place), self.boundaries)
        self.evaluations += 1
        self.tried.append(place)
        if np.isfinite(score) and np.isfinite(slope).all():
            fading = [self.exact.fading[family] for family in self.families]
            self.places.append(place)
            self.scores.append(score)
            own = [part.slope(share) for part, share in zip(fading, place.tolist(), strict=True)]
            self.slopes.append(slope[self.families] * own)

    def result(self) -> Optimum:
        """The best place by its exact score, with boundaries or without."""
        best = self.places[int(np.argmax(self.scores))] if self.scores else np.full(len(self.families), STARTS[0])
        t = self._thresholds(best)
        choices = [self.boundaries, *([not self.boundaries] if self.exact.has_boundaries else [])]
        found = [float(self.exact.scores(t[None], boundaries)[0]) for boundaries in choices]
        self.evaluations += len(found)
        if not np.isfinite(found[0]):
            raise UsageError("the ranking module gives no score that is a number: its weights don't fit these drawings")
        better = len(found) > 1 and found[1] > found[0]
        converged = not self.families or self._expected_gain() < 1e-3
        trials = []
        if self.tried:
            start = tuple(self._thresholds(self.tried[0]).tolist())
            trials.append(Trial(start, tuple(t.tolist()), found[0], len(self.tried), converged))
        return Optimum(
            thresholds=tuple(t.tolist()),
            present=tuple(fading.present for fading in self.exact.fading),
            boundaries=choices[better],
            score=found[better],
            evaluations=self.evaluations,
            converged=converged,
            flat=len(self.scores) > 1 and min(self.scores) == max(self.scores),
            trials=tuple(trials),
        )

    def _thresholds(self, place: Floats) -> Floats:
        """(4,) t at (D,) shares of ink; 0 for families without lines."""
        t = np.zeros(4)
        for family, share in zip(self.families, place.tolist(), strict=True):
            t[family] = self.exact.fading[family].threshold(share)
        return t

    def _fitted(self) -> tuple[Surrogate, Floats]:
        """The surrogate, and (N,) the scores in the units that it knows them in."""
        scores, slopes = np.array(self.scores), np.array(self.slopes)
        unit = max(float(np.ptp(scores)), 1e-3 * float(np.abs(slopes).max()), 1e-12)
        return Surrogate(np.array(self.places), scores / unit, slopes / unit), scores / unit

    def _expected_gain(self) -> float:
        """How much higher than the highest score the surrogate's top is, as a share of the scores' range."""
        if len(self.scores) < len(STARTS):
            return np.inf
        surrogate, scores = self._fitted()
        tops = self._tops(lambda places: surrogate(places)[0], scores)
        return float(surrogate(tops)[0].max() - scores.max())

    def _promising(self, exploring: bool) -> Floats:
        """(D,) where to look next."""
        if len(self.tried) < len(STARTS) or not self.scores:
            return np.full(len(self.families), STARTS[len(self.tried) % len(STARTS)])
        surrogate, scores = self._fitted()

        def promise(places: Floats) -> Floats:
            mean, deviation = surrogate(places)
            ahead = (mean - scores.max()) / deviation
            density = np.exp(-0.5 * ahead**2) / np.sqrt(2 * np.pi)
            wanted = deviation * (ahead * ndtr(ahead) + density) if exploring else mean
            apart = np.abs(places[:, None] - np.array(self.tried)[None]).max(axis=2).min(axis=1)
            return np.where(apart < NEAREST, -np.inf, wanted)

        tops = self._tops(promise, scores)
        place: Floats = tops[int(np.argmax(promise(tops)))]
        return place

    def _tops(self, promise: Callable[[Floats], Floats], scores: Floats) -> Floats:
        """(4, D) places of high promise: the best of many, and of those ever nearer around them."""
        dims, rng = len(self.families), np.random.default_rng(len(self.tried))
        best = self.places[int(np.argmax(scores))]
        places = np.concatenate([rng.random((512, dims)), np.clip(best + rng.normal(0, STEPS[0], (256, dims)), 0, 1)])
        tops = places[np.argsort(-promise(places), kind="stable")[:4]]
        for step in STEPS:
            ways = np.concatenate([np.zeros((1, dims)), np.eye(dims), -np.eye(dims), rng.normal(0, 1, (16, dims))])
            around = np.clip(tops[:, None] + step * ways, 0.0, 1.0)
            values = promise(around.reshape(-1, dims)).reshape(len(tops), -1)
            tops = around[np.arange(len(tops)), values.argmax(axis=1)]
        return tops
