"""Frugal artists, who draw a view with as many inner lines as it can bear, and no more; kept for comparison.

An artist draws every visible contour and border, and then inner lines until their length is in a certain proportion
to the contours': creases first where the shape has them, apparent ridges, suggestive contours, and a few strong
ridges and valleys. A line beside one that is drawn already is left out, faint lines and specks are never drawn, and
some strokes are forgotten. So the thresholds at which an artist stops differ from shape to shape, and no fixed
threshold is right for all.
"""

from dataclasses import dataclass

import numpy as np

from dataset_tools.artists.motif import Motif
from ncmodel.chamfer import distance_to
from ncmodel.export.page import REFERENCE_SIDE, WIDTH
from ncmodel.export.rasterize import draw_segments
from ncmodel.lines.chaining import chain
from ncmodel.scene.view import View
from ncmodel.types import Floats, Image, Ints, LineFamily, Mask

LINE_WIDTH = WIDTH / REFERENCE_SIDE
"""Line widths and distances are shares of the picture's shorter side."""
BESIDE = 6 / 768
"""A line that runs this near to a drawn one adds nothing."""
SPECK = 24 / 768
"""Strokes shorter than this aren't drawn."""
TYPICAL_STROKE = 90 / 768
"""Strokes of this length are forgotten about a third as often as specks."""

FAINTEST = {
    LineFamily.APPARENT: 0.02,
    LineFamily.SUGGESTIVE: 0.002,
    LineFamily.VALLEYS: 0.1,
    LineFamily.RIDGES: 0.1,
}
"""Lines weaker than this (in rtsc's units) are too faint to be drawn, in the order in which families are drawn."""

MECHANICAL = 0.25
"""Creases whose strokes are at least this long on average (weighted by length) are edges of a machine part, and drawn.
Shorter ones are facets of a rough surface."""


TO_CHOOSE_FROM = 1.8
"""The artist chooses among the strongest lines of this many times the length that it will draw."""


@dataclass(frozen=True)
class FrugalArtist:
    """One artist's taste.

    Attributes:
        number: Which of the crowd's artists.
        inner: Wanted length of inner lines, in contour lengths.
        shares: Family -> share of the inner length.
        forgetful: Chance that a short stroke is forgotten; longer ones are forgotten less.
        seed: Of what is forgotten.
    """

    number: int
    inner: float
    shares: dict[LineFamily, float]
    forgetful: float
    seed: int

    def draw(self, motif: Motif, rng: np.random.Generator) -> Image:
        """What this artist draws of a view: (H, W) ink."""
        return Sketch(motif.view, self, rng).finish()


def frugal_artists(count: int = 5, seed: int = 0) -> list[FrugalArtist]:
    """The artists of a crowd: one taste, mildly varied from artist to artist."""
    rng = np.random.default_rng([seed, 7])
    typical = {LineFamily.APPARENT: 0.5, LineFamily.SUGGESTIVE: 0.3, LineFamily.VALLEYS: 0.12, LineFamily.RIDGES: 0.08}
    artists = []
    for number in range(count):
        weights = {family: share * float(np.exp(rng.normal(0, 0.2))) for family, share in typical.items()}
        total = sum(weights.values())
        artists.append(
            FrugalArtist(
                number=number,
                inner=0.6 * float(np.exp(rng.normal(0, 0.15))),
                shares={family: weight / total for family, weight in weights.items()},
                forgetful=float(rng.uniform(0.1, 0.3)),
                seed=int(rng.integers(2**31)),
            )
        )
    return artists


@dataclass(frozen=True, eq=False)
class _Lines:
    """Visible lines of a family on the picture plane.

    Attributes:
        points: (S, 2, 2) end points, pixels.
        strength: (S,) what thresholds are compared with.
        length: (S,) pixels.
    """

    points: Floats
    strength: Floats
    length: Floats

    @staticmethod
    def of(view: View, family: LineFamily) -> "_Lines":
        lines = view.visible(family)
        points = view.camera.project(lines.points)[..., :2]
        length = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        return _Lines(points, np.minimum(lines.strength, 1e6).mean(axis=1), length)

    def take(self, keep: Mask) -> "_Lines":
        return _Lines(self.points[keep], self.strength[keep], self.length[keep])


class Sketch:
    """A drawing in the making.

    Args:
        view: What is drawn.
        artist: Who draws.
        rng: Decides what is forgotten.
    """

    def __init__(self, view: View, artist: FrugalArtist, rng: np.random.Generator) -> None:
        camera = view.camera
        self._view, self._artist, self._rng = view, artist, rng
        self._shape = (camera.height, camera.width)
        self._side = min(self._shape)
        self.ink: Image = np.zeros(self._shape, dtype=np.float32)
        outline = [_Lines.of(view, family) for family in (LineFamily.CONTOURS, LineFamily.BOUNDARIES)]
        for lines in outline:
            self._add(lines.points)
        contour_length = sum(float(lines.length.sum()) for lines in outline)
        self._wanted = artist.inner * max(contour_length, float(self._side))

    def finish(self) -> Image:
        """Draw the inner lines, and return the drawing: (H, W) ink."""
        left = max(self._wanted - self._draw_creases(), 0.0)
        for family, faintest in FAINTEST.items():
            lines = self._worth_drawing(_Lines.of(self._view, family), faintest)
            self._draw_strongest(lines, left * self._artist.shares[family])
        return self.ink

    def _draw_creases(self) -> float:
        """Draw all creases of a mechanical shape; returns the length drawn."""
        lines = _Lines.of(self._view, LineFamily.CREASES)
        strokes = self._strokes(lines)
        lengths = np.array([lines.length[stroke].sum() for stroke in strokes])
        if (lengths**2).sum() < MECHANICAL * self._side * lines.length.sum() or not strokes:
            return 0.0
        self._add(lines.points[np.concatenate(strokes)])
        return float(lengths.sum())

    def _worth_drawing(self, lines: _Lines, faintest: float) -> _Lines:
        """Lines that are strong enough and not beside a drawn one."""
        lines = lines.take(lines.strength > faintest)
        if not len(lines.points):
            return lines
        away = distance_to(self.ink >= 0.5)
        middle = lines.points.mean(axis=1)
        columns = np.clip(middle[:, 0].astype(np.intp), 0, self._shape[1] - 1)
        rows = np.clip(middle[:, 1].astype(np.intp), 0, self._shape[0] - 1)
        return lines.take(away[rows, columns] > BESIDE * self._side)

    def _draw_strongest(self, lines: _Lines, budget: float) -> None:
        """Draw the longest and strongest strokes up to a length."""
        order = np.argsort(-lines.strength, kind="stable")
        keep = np.zeros(len(order), dtype=np.bool_)
        keep[order[np.cumsum(lines.length[order]) <= TO_CHOOSE_FROM * budget]] = True
        chosen = lines.take(keep)
        drawn, kept = 0.0, []
        for stroke in self._strokes(chosen):
            length = float(chosen.length[stroke].sum())
            forget = self._artist.forgetful * np.exp(-length / (TYPICAL_STROKE * self._side))
            if drawn + length <= budget and self._rng.random() >= forget:
                kept.append(stroke)
                drawn += length
        if kept:
            self._add(chosen.points[np.concatenate(kept)])

    def _strokes(self, lines: _Lines) -> list[Ints]:
        """Lines chained into strokes, as indices: the most telling first, no specks."""
        chains = chain(lines.points)
        strokes = [chains.segment[i:j] for i, j in zip(chains.first[:-1], chains.first[1:], strict=True)]
        telling: list[tuple[float, int, Ints]] = []
        for stroke in strokes:
            length = float(lines.length[stroke].sum())
            strength = float(np.average(lines.strength[stroke], weights=lines.length[stroke] + 1e-9))
            if length >= SPECK * self._side:
                telling.append((strength * length, len(telling), stroke))
        return [stroke for _, _, stroke in sorted(telling, key=lambda entry: (-entry[0], entry[1]))]

    def _add(self, points: Floats) -> None:
        alpha = np.ones((len(points), 2))
        self.ink = draw_segments(points, alpha, LINE_WIDTH * self._side, self._shape, onto=self.ink)
