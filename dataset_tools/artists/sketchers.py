"""Artists who draw few, long lines each chosen as a whole: the same strongest ones, and then what is to their taste."""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import cv2
import numpy as np

from dataset_tools.artists.hand import Hand
from dataset_tools.artists.motif import Motif, at
from dataset_tools.artists.polylines import STEP, Polyline, segments, without
from dataset_tools.artists.shading_lines import KIND as SHADING
from dataset_tools.artists.shading_lines import shading_lines
from ncmodel.export.page import REFERENCE_SIDE, WIDTH
from ncmodel.export.rasterize import draw_segments
from ncmodel.types import Image, LineFamily, Mask

BESIDE = 9
"""Pixels; a line that runs this near to a drawn one adds nothing."""
CROSSING = 40.0
"""Pixels along which a line may be beside others and is drawn all the same, to cross them."""
SHORTEST = 30.0
"""Pixels of the shortest interior line."""
CORE = 0.15
"""Share of the wanted ink that goes to the lines that every artist draws."""
LEAST = 0.3
"""Share of the wanted ink that lines other than contours get, where contours alone are enough."""
RICHNESS = 0.55
"""A shape with twice as many strong lines gets 2^RICHNESS times the ink."""
STRONG = 0.5
"""Mean salience of lines that tell how much detail there is."""
LEAST_DETAIL, MIDDLING_DETAIL, MOST_DETAIL = 0.2, 2.2, 7.0
"""Length of the strong lines of a shape, in lengths of its silhouette; more or less makes no difference."""
CHOOSY = 0.4
"""Of all lines of curvature that are there at most this share is drawn."""


@dataclass(frozen=True)
class Sketcher:
    """An artist's taste and hand.

    Attributes:
        number: Which of the crowd's artists.
        inner: Wanted length of inner lines, in lengths of the silhouette, of a shape of middling detail.
        liking: Kind of line -> how much its lines are liked.
        long: How much more lines that are longer are worth: the exponent of their length.
        strong: The exponent of their salience.
        shading: Share of the ink that goes to lines of shading.
        light: Right, up, towards the eye: where the artist sees the light.
        level: Share of the shape that it sees as dark.
        blur: Pixels below which it sees no shading.
        whim: Spread of the logarithm of a line's worth in one drawing.
        hand: How it draws.
        seed: Of whims and of the hand.
    """

    number: int
    inner: float
    liking: dict[str, float]
    long: float
    strong: float
    shading: float
    light: tuple[float, float, float]
    level: float
    blur: float
    whim: float
    hand: Hand
    seed: int

    def draw(self, motif: Motif, rng: np.random.Generator) -> Image:
        """What this artist draws of a view: (H, W) ink."""
        page = _Page(motif, self.hand, rng)
        for line in motif.outlines:
            page.draw_outline(line)
        budget = self._wanted(motif)
        left = max(budget - page.inner, LEAST * budget)
        page.draw_best(motif.edges, [1.0] * len(motif.edges), left)
        left = max(budget - page.inner, LEAST * budget)
        features = motif.features
        left = min(left, CHOOSY * sum(line.length for line in features) / (1.0 - self.shading))
        page.draw_best(features, [importance(line) for line in features], CORE * left)
        whims = rng.normal(0.0, self.whim, len(features))
        worth = [self._worth(line) * float(np.exp(whim)) for line, whim in zip(features, whims, strict=True)]
        page.draw_best(features, worth, (1.0 - CORE - self.shading) * left)
        lines = shading_lines(motif, np.array(self.light), self.level, self.blur)
        page.draw_best(lines, [self._worth(line) for line in lines], self.shading * left)
        return page.ink()

    def _worth(self, line: Polyline) -> float:
        return float(self.liking[line.kind] * line.salience.mean() ** self.strong * line.length**self.long)

    def _wanted(self, motif: Motif) -> float:
        """Pixels of inner lines."""
        strong = sum(line.length for line in motif.features if line.salience.mean() > STRONG)
        detail = np.clip(strong / motif.outline_length, LEAST_DETAIL, MOST_DETAIL) / MIDDLING_DETAIL
        return self.inner * motif.outline_length * float(detail**RICHNESS)


def importance(line: Polyline) -> float:
    """What everybody sees: strength times length."""
    return float(line.salience.mean()) ** 2 * line.length


class _Page:
    """A drawing in the making."""

    def __init__(self, motif: Motif, hand: Hand, rng: np.random.Generator) -> None:
        self._motif, self._hand, self._rng = motif, hand, rng
        self._field = hand.field(motif, rng)
        self._beside = np.zeros(motif.shape, dtype=np.uint8)
        self._drawn: list[Polyline] = []
        self.inner = 0.0

    def draw_outline(self, line: Polyline) -> None:
        """Draw a contour or a boundary."""
        self._draw(line, steady=True)

    def draw_best(self, lines: Sequence[Polyline], worth: Sequence[float], budget: float) -> None:
        """Draw whole lines, the most worth first, until `budget` pixels are drawn."""
        end = self.inner + budget
        for index in np.argsort(-np.array(worth), kind="stable").tolist():
            if self.inner >= end:
                return
            line = lines[index]
            free = without(line, self._taken(line), CROSSING, SHORTEST)
            if sum(part.length for part in free) >= 0.4 * line.length:
                for part in free:
                    self._draw(part)

    def ink(self) -> Image:
        """(H, W) ink."""
        camera, scale = self._motif.view.camera, self._motif.scale
        pieces = segments(self._drawn) * scale
        width = WIDTH / REFERENCE_SIDE * min(camera.width, camera.height)
        return draw_segments(pieces, np.ones((len(pieces), 2)), width, (camera.height, camera.width))

    def _taken(self, line: Polyline) -> Mask:
        return np.asarray(at(self._beside, line.points) > 0)

    def _draw(self, line: Polyline, steady: bool = False) -> None:
        self._drawn.append(self._hand.draw(line, self._field, self._rng, steady))
        self.inner += STEP * int(np.count_nonzero(self._motif.inside(line)))
        trace = np.round(line.points * 8).astype(np.int32)
        cv2.polylines(self._beside, [trace], isClosed=False, color=1, thickness=2 * BESIDE + 1, shift=3)


FAVOURITES = (
    LineFamily.APPARENT.value,
    LineFamily.SUGGESTIVE.value,
    LineFamily.RIDGES.value,
    SHADING,
    LineFamily.VALLEYS.value,
)


def sketchers(count: int, seed: int = 0) -> list[Sketcher]:
    """A crowd of artists who differ: each likes one kind of line most, and some draw twice as much as others."""
    rng = np.random.default_rng([seed, 11])
    ranks = rng.permutation(count)
    return [_sketcher(number, (ranks[number] + 0.5) / count, rng) for number in range(count)]


def _sketcher(number: int, rank: float, rng: np.random.Generator) -> Sketcher:
    usual = {"apparent": 0.9, "ridges": 0.8, "suggestive": 1.4, "valleys": 0.9, SHADING: 1.0}
    favourite = FAVOURITES[number % len(FAVOURITES)]
    liking = {kind: weight * float(np.exp(rng.normal(0.0, 1.0))) for kind, weight in usual.items()}
    liking[favourite] *= 6.0
    return Sketcher(
        number=number,
        inner=float(1.15 * np.exp(0.33 * NormalDist().inv_cdf(rank))),
        liking=liking,
        long=float(rng.uniform(1.2, 1.8)),
        strong=float(rng.uniform(0.4, 1.2)),
        shading=float(rng.uniform(0.25, 0.35)) if favourite != SHADING else 0.5,
        light=(float(rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.2)), float(rng.uniform(0.2, 1.2)), 1.0),
        level=float(rng.uniform(0.2, 0.55)),
        blur=float(rng.uniform(5.0, 10.0)),
        whim=0.4,
        hand=Hand(
            smoothing=float(rng.uniform(8.0, 16.0)),
            misplaced=float(rng.uniform(3.0, 4.2)),
            wobble=float(rng.uniform(1.0, 2.0)),
            overshoot=float(rng.uniform(3.0, 12.0)),
        ),
        seed=int(rng.integers(2**31)),
    )
