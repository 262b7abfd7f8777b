"""What a drawing shows: one plan, whoever decides: defaults, a caller, a model, a baseline."""

from dataclasses import dataclass, field
from typing import Literal

from ncmodel.types import LineFamily, Stroke, Thresholds

Hidden = Literal["none", "dashed", "layer"]
"""What becomes of lines behind the surface."""

DEFAULT_FAMILIES = (
    LineFamily.CONTOURS,
    LineFamily.BOUNDARIES,
    LineFamily.CREASES,
    LineFamily.INTERSECTIONS,
    LineFamily.SUGGESTIVE,
    LineFamily.APPARENT,
)
"""Drawn unless told otherwise. Ridges and valleys aren't: they show the mesh's roughness before its form."""

CRUMB = 0.02
"""Of the picture's shorter side: what strokes of a drawing of `DEFAULT_FAMILIES` have as ink at least."""

MODEL_CRUMB = 0.04
"""The same where a model chooses: it draws weaker lines, too, where a view needs them, and these break into more bits.
This share serves best on views of training shapes (docs/training.md)."""


@dataclass(frozen=True)
class Plan:
    """What a drawing shows.

    Attributes:
        families: The families asked for or chosen; those whose threshold is None are left out.
        thresholds: Of the filtered families.
        strokes: Lines that don't come from the mesh: those of a model's image branch, in the view's pixels.
        score: The model's score of its choice, if one chose.
        evaluations: How many drawings it scored.
        converged: Whether its search found that it can't get better.
        finished: Whether lines that run along each other are drawn once, and those that continue each other as one; or
            all as they are found, as for what is measured or learnt from.
        crumb: Share of the picture's shorter side: strokes of less ink are left out, unless there is a reason for them;
            of finished drawings, which then are without apparent ridges on faces too large to tell them, too.
        rims: Where boundaries aren't drawn, those that are the shape's outline are all the same: an outline is closed.
        detail: Share of the lines inside the outline that is drawn, the most important first; 1 draws all of them.
        min_length: Pixels, at 768, of the shortest strokes that are drawn beside the outline's.
        hidden: Whether lines behind the surface are drawn, too: as dashes, or as a layer of solid lines.
    """

    families: tuple[LineFamily, ...] = DEFAULT_FAMILIES
    thresholds: Thresholds = field(default_factory=Thresholds)
    strokes: tuple[Stroke, ...] = ()
    score: float | None = None
    evaluations: int = 0
    converged: bool = True
    finished: bool = False
    crumb: float = 0.0
    rims: bool = False
    detail: float = 1.0
    min_length: float = 0.0
    hidden: Hidden = "none"

    @property
    def drawn(self) -> tuple[LineFamily, ...]:
        """The families that are drawn."""
        return tuple(family for family in self.families if self.thresholds.value(family) is not None)

    @property
    def filtered(self) -> dict[str, float | None]:
        """The name of each filtered family that is drawn -> its threshold, in the order of t."""
        drawn = self.drawn
        return {f.value: self.thresholds.value(f) for f in self.thresholds.families if f in drawn}
