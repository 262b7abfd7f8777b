"""Choosing thresholds with few looks at a large network: a surrogate of the score is maximised in its place.

The ranking module of the paper takes a second for a score with its gradient. So every one of them counts: a Gaussian
process is fitted to all scores and gradients so far (Solak et al. 2003), five numbers a look, and says where to look
next. At first that is where it expects the largest improvement (Jones et al. 1998), which also leads to where little is
known; then, where it expects the highest score; at last there too, or, where nothing more is to be gained, again where
little is known.

Drawings that look alike from afar score alike: the process knows a drawing by how much ink lies where
(`Glance`), in which all families count as much as they show. Known by its thresholds alone, a drawing
took twice as many looks. Places are shares of each family's ink, so that none has a plateau where it has faded away.

References:
    Jones, Schonlau, Welch: Efficient Global Optimization of Expensive Black-Box Functions. Journal of Global
    Optimization 13, 1998.
    Solak, Murray-Smith, Leithead, Leith, Rasmussen: Derivative Observations in Gaussian Process Models of Dynamic
    Systems. NIPS 2003.

Letters in shapes: N looks, D families that have lines, M places, C numbers that a drawing is known by.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from scipy.special import ndtr
from torch import Tensor

from ncmodel.errors import UsageError
from ncmodel.model.threshold_search import Optimum, ScoredDrawing, Trial
from ncmodel.nets.blocks import threads_for
from ncmodel.types import Floats

STARTS = (0.6, 0.2)
"""Shares of all families' ink that the first looks are at: the score has a hill at much ink and one at little."""

EXPLORING, SURE = 0.6, 0.8
"""Up to the first share of the looks they go where improvement is expected; up to the second, to the top that is known
by then; after it there too, unless the surrogate expects no higher score there: then where improvement is expected,
since another hill may be higher."""

SETTLED = 1e-3
"""How little above the highest score, as a share of the scores' range, isn't higher."""

LENGTHS = (0.05, 0.07, 0.1, 0.14, 0.2, 0.28, 0.4, 0.56, 0.8)
"""Distances between drawings over which scores may vary; the likeliest is taken."""

ROUGHNESS = 1e-4, 1e-2
"""Of scores and of gradients times length, the variance that isn't the process's: networks of ReLUs have kinks."""

NEAREST = 0.005
"""Shares of ink by which places must differ to be worth a look each."""

STEPS = (0.1, 0.05, 0.025, 0.012, 0.006)
"""How far around the most promising places others are tried."""

SHARES = np.linspace(0.0, 1.0, 65)
"""Of ink, those whose thresholds are worked out; between them, thresholds are linear."""

CHANGE = 0.01
"""Share of ink to either side over which the change of a drawing is taken."""


@dataclass(frozen=True, eq=False)
class Look:
    """What is known of one drawing.

    Attributes:
        place: (D,) shares of ink.
        drawing: (C,) what it looks like.
        change: (D, C) of that, with each share.
        score: Of the drawing.
        slope: (D,) change of the score with each share.
    """

    place: Floats
    drawing: Floats
    change: Floats
    score: float
    slope: Floats


class Surrogate:
    """A Gaussian process with the squared-exponential covariance, fitted to scores and gradients.

    Args:
        looks: At least one.

    Attributes:
        unit: What scores are divided by: of about their range.
        length: The likeliest of `LENGTHS`.
    """

    def __init__(self, looks: list[Look]) -> None:
        scores, slopes = np.array([look.score for look in looks]), np.array([look.slope for look in looks])
        self.unit = max(float(np.ptp(scores)), 1e-3 * float(np.abs(slopes).max()), 1e-12)
        self._drawings = torch.from_numpy(np.array([look.drawing for look in looks]))
        self._changes = torch.from_numpy(np.array([look.change for look in looks]))
        known = torch.from_numpy(np.column_stack([scores, slopes]).reshape(-1, 1) / self.unit)
        one = torch.zeros(slopes.shape[0], 1 + slopes.shape[1], dtype=torch.double)
        one[:, 0] = 1.0
        one, noise, likeliest = one.reshape(-1, 1), torch.full_like(one, ROUGHNESS[0]), -np.inf
        for length in LENGTHS:
            noise[:, 1:] = ROUGHNESS[1] * self._changes.square().sum(dim=2) / length**2 + 1e-9
            factor = torch.linalg.cholesky(self._covariance(length) + torch.diag(noise.ravel()))
            solved = torch.cholesky_solve(torch.cat([one, known], dim=1), factor)
            mean = float((one.T @ solved[:, 1:]) / (one.T @ solved[:, :1]))
            weights = solved[:, 1:] - mean * solved[:, :1]
            variance = max(float((known - mean * one).T @ weights) / len(known), 1e-300)
            likelihood = -0.5 * len(known) * np.log(variance) - float(factor.diagonal().log().sum())
            if likelihood > likeliest:
                likeliest, self.length = likelihood, length
                self._factor, self._mean, self._weights, self._variance = factor, mean, weights, variance

    def __call__(self, drawings: Floats) -> tuple[Floats, Floats]:
        """(M,) expected scores of (M, C) drawings, in units, and (M,) their standard deviations."""
        near, sloped = self._falloff(torch.from_numpy(drawings), self.length)
        values = torch.cat([near[..., None], sloped], dim=2).reshape(len(drawings), -1)
        known = torch.linalg.solve_triangular(self._factor, values.T, upper=False).square().sum(dim=0)
        mean = self._mean + values @ self._weights[:, 0]
        return mean.numpy(), ((1.0 - known).clamp(min=1e-12) * self._variance).sqrt().numpy()

    def _falloff(self, drawings: Tensor, length: float) -> tuple[Tensor, Tensor]:
        """(M, N) covariances of the scores of (M, C) drawings with those looked at, (M, N, D) with the slopes there."""
        near = torch.exp(-0.5 * torch.cdist(drawings, self._drawings).square() / length**2)
        along = drawings @ self._changes.flatten(0, 1).T - (self._drawings[:, None] * self._changes).sum(dim=2).ravel()
        return near, along.reshape(*near.shape, -1) / length**2 * near[..., None]

    def _covariance(self, length: float) -> Tensor:
        """Covariances of all known values and slopes with each other: (N (1 + D), N (1 + D))."""
        count, dims, _ = self._changes.shape
        near, sloped = self._falloff(self._drawings, length)
        changes, along = self._changes.flatten(0, 1), sloped / near.clamp(min=1e-300)[..., None]
        curved = (changes @ changes.T / length**2).reshape(count, dims, count, dims).permute(0, 2, 1, 3)
        between = (curved + along.transpose(0, 1)[..., :, None] * along[..., None, :]) * near[..., None, None]
        out = near.new_empty(count, 1 + dims, count, 1 + dims)
        out[:, 0, :, 0] = near
        out[:, 0, :, 1:] = sloped
        out[:, 1:, :, 0] = sloped.permute(1, 2, 0)
        out[:, 1:, :, 1:] = between.permute(0, 2, 1, 3)
        return out.reshape(count * (1 + dims), -1)


def optimise_with_surrogate(exact: ScoredDrawing, rough: ScoredDrawing, looks: int) -> Optimum:
    """Find the thresholds whose drawing scores highest, and whether boundaries belong in it.

    Args:
        exact: The drawing.
        rough: The same drawing, scored nearly as well for less: it is looked at, and what was found scored exactly.
        looks: Scores with gradient that this takes, at least 1.

    Raises:
        UsageError: No score is a number.
    """
    families = [family for family, fading in enumerate(exact.fading) if fading.present]
    search = _Search(exact, rough, families)
    if exact.has_boundaries:
        search.choose_boundaries()
    for look in range(looks if families else 0):
        search.look(exploring=look < EXPLORING * looks or (look >= SURE * looks and search.converged))
    return search.result()


class _Search:
    """All looks so far.

    Attributes:
        tried: Every place, (D,) shares of ink.
        looks: Those whose score is a number.
    """

    def __init__(self, exact: ScoredDrawing, rough: ScoredDrawing, families: list[int]) -> None:
        self.exact, self.rough, self.families = exact, rough, families
        self.boundaries, self.evaluations = exact.has_boundaries, 0
        self.tried: list[Floats] = []
        self.looks: list[Look] = []
        fading = [exact.fading[family] for family in families]
        self._faded = [np.array([part.threshold(share) for share in SHARES.tolist()]) for part in fading]

    def choose_boundaries(self) -> None:
        """Draw boundaries if the drawing at the first place is better with them."""
        t = self._thresholds(np.full((1, len(self.families)), STARTS[0]))
        with_them, without = (self.rough.scores(t, boundaries)[0] for boundaries in (True, False))
        self.boundaries = not without > with_them
        self.evaluations += 2

    def look(self, exploring: bool) -> None:
        """Score the most promising place, with its gradient."""
        with threads_for(1):
            place = self._promising(exploring)
        score, gradient = self.rough.slope(self._thresholds(place[None])[0], self.boundaries)
        self.evaluations += 1
        self.tried.append(place)
        if np.isfinite(score) and np.isfinite(gradient).all():
            ways = np.eye(len(place))
            sides = np.clip(np.concatenate([place - CHANGE * ways, place + CHANGE * ways]), 0.0, 1.0)
            apart = np.diagonal(sides[len(place) :] - sides[: len(place)])
            less, more = np.split(self._drawings(sides), 2)
            faded = self._thresholds(sides)[:, self.families]
            fading = np.diagonal(faded[len(place) :] - faded[: len(place)]) / apart
            drawing, change = self._drawings(place[None])[0], (more - less) / apart[:, None]
            self.looks.append(Look(place, drawing, change, score, gradient[self.families] * fading))

    @property
    def converged(self) -> bool:
        """Whether the surrogate expects no higher score anywhere."""
        if len(self.looks) < len(STARTS):
            return False
        with threads_for(1):
            surrogate = Surrogate(self.looks)
            tops = self._tops(lambda places: surrogate(self._drawings(places))[0])
            gain = surrogate(self._drawings(tops))[0].max() - self._best.score / surrogate.unit
        return bool(gain < SETTLED)

    def result(self) -> Optimum:
        """The best place by its exact score, with boundaries or without."""
        best = self._best.place if self.looks else np.full(len(self.families), STARTS[0])
        t = self._thresholds(best[None])
        choices = [self.boundaries, *([not self.boundaries] if self.exact.has_boundaries else [])]
        found = [float(self.exact.scores(t, boundaries)[0]) for boundaries in choices]
        self.evaluations += len(found)
        if not np.isfinite(found[0]):
            raise UsageError("the ranking module gives no score that is a number: its weights don't fit these drawings")
        better = len(found) > 1 and found[1] > found[0]
        converged = not self.families or self.converged
        thresholds, scores = tuple(t[0].tolist()), [look.score for look in self.looks]
        trials = []
        if self.tried:
            start = tuple(self._thresholds(self.tried[0][None])[0].tolist())
            trials.append(Trial(start, thresholds, found[0], len(self.tried), converged))
        return Optimum(
            thresholds=thresholds,
            present=tuple(fading.present for fading in self.exact.fading),
            boundaries=choices[better],
            score=found[better],
            evaluations=self.evaluations,
            converged=converged,
            flat=len(scores) > 1 and min(scores) == max(scores),
            trials=tuple(trials),
        )

    @property
    def _best(self) -> Look:
        return max(self.looks, key=lambda look: look.score)

    def _thresholds(self, places: Floats) -> Floats:
        """(M, 4) t at (M, D) shares of ink; 0 for families without lines."""
        t = np.zeros((len(places), 4))
        for family, shares, faded in zip(self.families, places.T, self._faded, strict=True):
            t[:, family] = np.interp(shares, SHARES, faded)
        return t

    def _drawings(self, places: Floats) -> Floats:
        """(M, C) what the drawings at (M, D) places look like."""
        return self.exact.glance(self._thresholds(places))

    def _promising(self, exploring: bool) -> Floats:
        """(D,) where to look next."""
        if len(self.tried) < len(STARTS) or not self.looks:
            return np.full(len(self.families), STARTS[len(self.tried) % len(STARTS)])
        surrogate, tried = Surrogate(self.looks), np.array(self.tried)
        best = self._best.score / surrogate.unit

        def promise(places: Floats) -> Floats:
            mean, deviation = surrogate(self._drawings(places))
            ahead = (mean - best) / deviation
            density = np.exp(-0.5 * ahead**2) / np.sqrt(2 * np.pi)
            wanted = deviation * (ahead * ndtr(ahead) + density) if exploring else mean
            apart = np.abs(places[:, None] - tried[None]).max(axis=2).min(axis=1)
            return np.where(apart < NEAREST, -np.inf, wanted)

        tops = self._tops(promise)
        place: Floats = tops[int(np.argmax(promise(tops)))]
        return place

    def _tops(self, promise: Callable[[Floats], Floats]) -> Floats:
        """(4, D) places of high promise: the best of many, and of those ever nearer around them."""
        dims, rng = len(self.families), np.random.default_rng(len(self.tried))
        near = np.clip(self._best.place + rng.normal(0, STEPS[0], (256, dims)), 0.0, 1.0)
        places = np.concatenate([rng.random((512, dims)), near])
        tops = places[np.argsort(-promise(places), kind="stable")[:4]]
        for step in STEPS:
            ways = np.concatenate([np.zeros((1, dims)), np.eye(dims), -np.eye(dims), rng.normal(0, 1, (16, dims))])
            around = np.clip(tops[:, None] + step * ways, 0.0, 1.0)
            values = promise(around.reshape(-1, dims)).reshape(len(tops), -1)
            tops = around[np.arange(len(tops)), values.argmax(axis=1)]
        return tops
