"""Synthetic drawings against references: every pair measured, then averaged."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass

import pandas as pd

from eval.measures.metrics import MEASURES, Measures, compare_lines, mean_measures
from eval.measures.references import most_consistent
from eval.measures.thinning import DEFAULT_THRESHOLD, silhouette_band, thin_lines
from ncmodel.chamfer import Lines
from ncmodel.errors import ArgumentError, UsageError
from ncmodel.types import Image, Mask

DEFAULT_TOLERANCE = 5.0
"""Pixels: 1 mm on a page where 1024 pixels are 205 mm wide, as on letter or A4 paper with margins."""


@dataclass(frozen=True)
class Settings:
    """How drawings are compared.

    Attributes:
        tolerance_pixels: Up to this distance two pixels are near each other.
        threshold: Ink from which on a pixel counts as drawn, in (0, 1].
        most_consistent: Of several references take only the one closest to the rest.
    """

    tolerance_pixels: float = DEFAULT_TOLERANCE
    threshold: float = DEFAULT_THRESHOLD
    most_consistent: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.tolerance_pixels) and self.tolerance_pixels >= 0.0):
            raise ArgumentError("tolerance_pixels", str(self.tolerance_pixels), "0 or more")
        if not 0.0 < self.threshold <= 1.0:
            raise ArgumentError("threshold", str(self.threshold), "a number above 0 and up to 1")


@dataclass(frozen=True)
class Score:
    """One drawing measured against one reference."""

    name: str
    reference: str
    measures: Measures


@dataclass(frozen=True)
class Evaluation:
    """The scores of one method's drawings."""

    scores: tuple[Score, ...]
    settings: Settings

    def __post_init__(self) -> None:
        if not self.scores:
            raise ValueError("an evaluation has at least one score")

    @property
    def mean(self) -> Measures:
        """Over all pairs of drawing and reference; F1 from the mean precision and recall."""
        return mean_measures([score.measures for score in self.scores])

    def to_frame(self) -> pd.DataFrame:
        """The scores as a table: `name` and `reference` (string), and every measure (float64)."""
        rows = [(score.name, score.reference, *astuple(score.measures)) for score in self.scores]
        types = {"name": "string", "reference": "string", **dict.fromkeys(MEASURES, "float64")}
        return pd.DataFrame(rows, columns=list(types)).astype(types)


@dataclass(frozen=True, eq=False)
class Target:
    """What all drawings of one name are judged by, prepared once.

    Attributes:
        name: The drawing's name.
        references: What the reference is called -> its thin lines.
        removed: (H, W) the band around the silhouette that is taken away from every drawing; `None` to keep all.
        settings: How drawings are compared.
    """

    name: str
    references: Mapping[str, Lines]
    removed: Mask | None
    settings: Settings

    @staticmethod
    def of(name: str, references: Mapping[str, Image], settings: Settings, silhouette: Mask | None = None) -> "Target":
        """Prepare references.

        Args:
            name: The drawing's name.
            references: Label -> (H, W) ink, at least one.
            settings: How drawings are compared.
            silhouette: (H, W) the object's filled mask or its drawn outline, to be removed from all drawings.

        Raises:
            UsageError: The sizes differ, or a setting makes no sense.
        """
        if not references:
            raise ValueError(f"{name}: no references")
        first, size = next((label, ink.shape) for label, ink in references.items())
        for label, ink in references.items():
            _check_sizes(name, (first, size), (label, ink.shape))
        removed = None
        if silhouette is not None:
            _check_sizes(name, (first, size), ("its silhouette", silhouette.shape))
            removed = silhouette_band(silhouette, settings.tolerance_pixels)
        lines = {label: _prepare(ink, settings, removed) for label, ink in references.items()}
        if settings.most_consistent:
            label = list(lines)[most_consistent(list(lines.values()))]
            lines = {label: lines[label]}
        return Target(name, lines, removed, settings)

    def prepare(self, ink: Image) -> Lines:
        """A synthetic drawing's thin lines, silhouette taken away.

        Raises:
            UsageError: Its size isn't that of the references.
        """
        label, reference = next(iter(self.references.items()))
        _check_sizes(self.name, ("the drawing", ink.shape), (label, reference.mask.shape))
        return _prepare(ink, self.settings, self.removed)

    def scores(self, drawing: Lines) -> tuple[Score, ...]:
        """A prepared drawing against each reference."""
        return tuple(
            Score(self.name, label, compare_lines(drawing, reference, self.settings.tolerance_pixels))
            for label, reference in self.references.items()
        )


def evaluate(
    drawings: Mapping[str, Image],
    references: Mapping[str, Sequence[Image]],
    settings: Settings | None = None,
    silhouettes: Mapping[str, Mask] | None = None,
) -> Evaluation:
    """Measure every drawing against each of its references.

    Args:
        drawings: Name -> (H, W) ink.
        references: Name -> one or more (H, W) inks of the same size; names without a drawing are left aside.
        settings: How drawings are compared.
        silhouettes: Name -> (H, W) the object's filled mask or drawn outline, removed from both drawings; all drawings
            need one if any is given.

    Raises:
        UsageError: A drawing has no reference or no silhouette, or sizes differ.
    """
    how = settings or Settings()
    scores: list[Score] = []
    for target in targets(drawings, references, how, silhouettes):
        scores += target.scores(target.prepare(drawings[target.name]))
    return Evaluation(tuple(scores), how)


def targets(
    names: Iterable[str],
    references: Mapping[str, Sequence[Image]],
    settings: Settings,
    silhouettes: Mapping[str, Mask] | None = None,
) -> Iterable[Target]:
    """One target a name, made when it is asked for; references are labelled by their number.

    Raises:
        UsageError: A name has no reference or no silhouette.
    """
    for name in names:
        if not references.get(name):
            raise UsageError(f"{name}: no reference drawing")
        if silhouettes is not None and name not in silhouettes:
            raise UsageError(f"{name}: no silhouette, though others have one")
        labelled = {str(number): ink for number, ink in enumerate(references[name])}
        yield Target.of(name, labelled, settings, silhouettes[name] if silhouettes is not None else None)


def _prepare(ink: Image, settings: Settings, removed: Mask | None) -> Lines:
    mask = thin_lines(ink, settings.threshold)
    return Lines.of(mask if removed is None else mask & ~removed)


def _check_sizes(name: str, *pictures: tuple[str, tuple[int, ...]]) -> None:
    """Raise unless pictures, given by label and shape, have one size."""
    if len({shape for _, shape in pictures}) > 1:
        sizes = (f"{label} is {' x '.join(map(str, reversed(shape)))} pixels" for label, shape in pictures)
        raise UsageError(f"{name}: {', '.join(sizes)}; expected the same size")
