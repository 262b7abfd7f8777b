"""Folders of drawings against a folder of references: name by name, with what can't be measured left out and said."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from eval.measures.comparison import Comparison
from eval.measures.evaluation import Evaluation, Score, Settings, Target
from eval.measures.references import PICTURES, Pairing, find_drawings, pair_up
from eval.measures.report import OverlayGallery
from eval.measures.scans import MOST_INK, WIDEST, ink_share, line_width, read_lines
from eval.measures.thinning import binarise, read_ink
from ncmodel.errors import InputError, NeuralContoursError, UsageError
from ncmodel.types import Image, Mask


@dataclass(frozen=True)
class FolderEvaluation:
    """What came of the folders.

    Attributes:
        comparison: Method -> scores, over the names that every method has.
        gallery: The pictures of the first method.
        failures: One line for each name that could not be measured.
        notes: One line for each picture that was measured but is hardly what was meant.
    """

    comparison: Comparison
    gallery: OverlayGallery
    failures: tuple[str, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Folders:
    """Where drawings, references and silhouettes lie.

    Attributes:
        drawings: Method -> its folder, NAME.png each; at least one.
        references: NAME.png or NAME/*.png each (or JPEG, TIFF).
        silhouettes: NAME.png each (or JPEG, TIFF), or `None`.
    """

    drawings: Mapping[str, Path]
    references: Path
    silhouettes: Path | None = None
    pairings: dict[str, Pairing] = field(init=False, repr=False)
    outlines: dict[str, Path] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        pairings = {method: pair_up(folder, self.references) for method, folder in self.drawings.items()}
        object.__setattr__(self, "pairings", pairings)
        outlines = {} if self.silhouettes is None else find_drawings(self.silhouettes, PICTURES)
        object.__setattr__(self, "outlines", outlines)

    @property
    def names(self) -> list[str]:
        """The drawings that every method and the references have."""
        first, *others = self.pairings.values()
        return [name for name in first.drawings if all(name in other.drawings for other in others)]

    def unmatched(self) -> Iterator[str]:
        """One line for each name that lacks its counterpart."""
        for method, pairing in self.pairings.items():
            for name in pairing.without_reference:
                yield f"{self.drawings[method] / name}.png: no reference of that name in {self.references}"
            for name in pairing.without_drawing:
                yield f"{name}: a reference without a drawing in {self.drawings[method]}"

    def read_references(self, name: str, settings: Settings) -> dict[str, Image]:
        """Label -> (H, W) ink of the references of one name.

        Raises:
            InputError: A picture can't be read, or isn't lines on paper.
        """
        paths = next(iter(self.pairings.values())).references[name]
        return {path.relative_to(self.references).as_posix(): read_lines(path, settings.threshold) for path in paths}

    def silhouette(self, name: str) -> Mask | None:
        """(H, W) what is to be taken away, if anything is.

        Raises:
            InputError: The picture can't be read.
        """
        if self.silhouettes is None:
            return None
        return binarise(read_ink(self.outlines.get(name, self.silhouettes / f"{name}.png")))


def evaluate_folders(
    folders: Folders, settings: Settings, output: Path, advance: Callable[[str], None]
) -> FolderEvaluation:
    """Measure everything that can be measured.

    Args:
        folders: Where the pictures are.
        settings: How drawings are compared.
        output: The report's folder, where pages of pictures go.
        advance: Called with each name when it is done.

    Raises:
        InputError: Nothing could be measured.
    """
    failures = list(folders.unmatched())
    scores: dict[str, list[Score]] = {method: [] for method in folders.drawings}
    gallery, notes = OverlayGallery(output), list[str]()
    for name in folders.names:
        try:
            found = _evaluate_name(folders, name, settings, gallery, notes)
        except UsageError as error:
            failures.append(str(error))
        except NeuralContoursError as error:
            failures.append(f"{name}: {error}")
        else:
            for method, measured in found.items():
                scores[method] += measured
        advance(name)
    if gallery.empty:
        raise InputError(folders.references, f"nothing could be measured ({failures[0]})", "comparable drawings")
    evaluations = {method: Evaluation(tuple(measured), settings) for method, measured in scores.items()}
    return FolderEvaluation(Comparison(evaluations), gallery, tuple(failures), tuple(notes))


def _evaluate_name(
    folders: Folders, name: str, settings: Settings, gallery: OverlayGallery, notes: list[str]
) -> dict[str, tuple[Score, ...]]:
    references = folders.read_references(name, settings)
    target = Target.of(name, references, settings, folders.silhouette(name))
    inks = {method: read_ink(pairing.drawings[name]) for method, pairing in folders.pairings.items()}
    lines = {method: target.prepare(ink) for method, ink in inks.items()}
    scores = {method: target.scores(drawing) for method, drawing in lines.items()}
    first = next(iter(inks))
    gallery.add(target, inks[first], lines[first], scores[first])
    left = "left in it without what is near the silhouette" if target.removed is not None else "drawn in it"
    if target.removed is not None and not target.removed.any():
        notes.append(f"{name}: its silhouette has no outline; expected a mask or an outline, black on white")
    for method, ink in inks.items():
        path = folders.pairings[method].drawings[name]
        if (share := ink_share(ink, settings.threshold)) > MOST_INK:
            notes.append(f"{path}: {share:.0%} of it is ink; expected dark lines on light paper, at most a third")
        if lines[method].empty:
            notes.append(f"{path}: nothing is {left}")
    notes += [f"{folders.references / label}: nothing is {left}" for label, of in target.references.items() if of.empty]
    pictures = {folders.references / label: references[label] for label in target.references}
    pictures |= {folders.pairings[method].drawings[name]: ink for method, ink in inks.items()}
    for path, ink in pictures.items():
        width = line_width(ink, settings.threshold)
        if width > WIDEST * max(ink.shape) and ink_share(ink, settings.threshold) <= MOST_INK:
            notes.append(f"{path}: its lines are {width:.0f} pixels wide, as areas are; only their middle is measured")
    return scores
