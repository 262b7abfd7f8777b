"""An evaluation as files: report.json with every number, report.html to look at, with pages where pictures are many."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import cv2
import numpy as np

from eval.measures.comparison import COLUMNS, Comparison, comparison_table, shown
from eval.measures.evaluation import Evaluation, Score, Target
from eval.measures.metrics import MEASURES
from ncmodel.chamfer import Lines
from ncmodel.files import write_text
from ncmodel.images import Pixels, from_ink, shrink
from ncmodel.report.contact_sheet import Tile
from ncmodel.report.html import Block, Cell, Facts, Fold, Grid, Links, Section, Table, Text, write_report
from ncmodel.types import Image, Mask

HIT = (70, 70, 70)
EXTRA = (213, 94, 0)
MISS = (0, 114, 178)
REMOVED = (236, 236, 230)
"""Colours of an overlay: grey, vermilion, blue (told apart with any colour vision), and a tint for the silhouette."""

PICTURE_SIDE = 480
"""Longest side of the pictures in a report, pixels."""

MOST_PICTURES = 240
"""Pictures that one page holds: about 8 MB, which browsers open at once."""

PAGES = "pages"
"""Folder of the pages of pictures, where one doesn't hold all."""

_TITLE = "Evaluation of line drawings"

LEGEND = (
    "Overlays: grey lines are near the other drawing (hits), orange ones are drawn but not in the reference (extras), "
    "blue ones are in the reference but not drawn (misses). A pale band marks the silhouette, which isn't counted."
)


@dataclass
class OverlayGallery:
    """The pictures of an evaluation, gathered drawing by drawing and shrunk at once.

    Those of many drawings go to pages of their own as soon as they fill one, so that no file gets too large for a
    browser, and they don't pile up in memory.

    Attributes:
        folder: Of the report.
        rows: Drawing's name -> the drawing itself, then for each reference the overlay; those not on a page yet.
        pages: Names of the first and the last drawing on each page -> its path from the folder.
    """

    folder: Path
    rows: dict[str, list[Tile]] = field(default_factory=dict)
    pages: dict[tuple[str, str], str] = field(default_factory=dict)

    @property
    def empty(self) -> bool:
        """Whether there is no picture."""
        return not (self.rows or self.pages)

    def add(self, target: Target, ink: Image, drawing: Lines, scores: Sequence[Score]) -> None:
        """Keep the pictures of one drawing and its comparisons."""
        tiles = [Tile(shrink(from_ink(ink), PICTURE_SIDE), "the drawing")]
        for score in scores:
            reference = target.references[score.reference]
            pixels = overlay(drawing, reference, target.settings.tolerance_pixels, target.removed)
            caption = f"{score.reference}: F1 {shown('f1', score.measures.f1)}"
            tiles.append(Tile(shrink(pixels, PICTURE_SIDE), caption, f"overlay with {caption}"))
        if self.rows and len(tiles) + sum(map(len, self.rows.values())) > MOST_PICTURES:
            self._turn_page()
        self.rows[target.name] = tiles

    def blocks(self) -> list[Block]:
        """What the report shows: all pictures, or where to find them."""
        if self.pages and self.rows:
            self._turn_page()
        self._remove_earlier()
        if not self.pages:
            return [Text(LEGEND, "note"), *self._grids()]
        told = f"{len(self.pages)} pages of at most {MOST_PICTURES} pictures each."
        return [Text(told), Links([(f"{first} .. {last}", page) for (first, last), page in self.pages.items()])]

    def _grids(self) -> list[Block]:
        return [Grid(tiles, name, columns=4, max_side=PICTURE_SIDE) for name, tiles in self.rows.items()]

    def _turn_page(self) -> None:
        """Put the pictures gathered so far on a page of their own."""
        first, last = next(iter(self.rows)), next(reversed(self.rows))
        page = f"{PAGES}/{len(self.pages) + 1:04d}.html"
        (self.folder / PAGES).mkdir(parents=True, exist_ok=True)
        back: list[Block] = [Links([("To the report", "../report.html")]), Text(LEGEND, "note")]
        parts = [Section(f"{first} .. {last}", [*back, *self._grids()])]
        write_report(self.folder / page, _TITLE, parts)
        self.pages[first, last] = page
        self.rows = {}

    def _remove_earlier(self) -> None:
        """Remove the pages of an evaluation before that had more of them."""
        for path in (self.folder / PAGES).glob("[0-9][0-9][0-9][0-9].html"):
            if f"{PAGES}/{path.name}" not in self.pages.values():
                path.unlink()


def overlay(drawing: Lines, reference: Lines, tolerance: float, removed: Mask | None = None) -> Pixels:
    """(H, W, 3) a drawing over its reference: hits, extras and misses in their colours.

    Args:
        drawing: The synthetic drawing.
        reference: The reference, of the same size.
        tolerance: Pixels up to which two pixels are near each other.
        removed: (H, W) the band taken away from both.
    """
    picture = np.full((*drawing.mask.shape, 3), 255, dtype=np.uint8)
    if removed is not None:
        picture[removed] = REMOVED
    near_reference, near_drawing = (_near(lines, tolerance) for lines in (reference, drawing))
    picture[_thick(drawing.mask & near_reference)] = HIT
    picture[_thick(drawing.mask & ~near_reference)] = EXTRA
    picture[_thick(reference.mask & ~near_drawing)] = MISS
    return picture


def _near(lines: Lines, tolerance: float) -> Mask:
    return np.zeros_like(lines.mask) if lines.empty else np.asarray(lines.distance <= tolerance)


def _thick(mask: Mask) -> Mask:
    """Lines of one pixel made as wide as they must be to show when the picture is scaled down to `PICTURE_SIDE`."""
    side = 2 * max(1, round(max(mask.shape) / PICTURE_SIDE)) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    return np.asarray(cv2.dilate(mask.astype(np.uint8), disc) > 0)


def record(
    comparison: Comparison,
    failures: Sequence[str] = (),
    page: Mapping[str, float] | None = None,
    notes: Sequence[str] = (),
) -> dict[str, object]:
    """The content of report.json.

    Args:
        comparison: The methods' scores; the report is about the first, the others' means stand beside it.
        failures: One line for each item that could not be measured.
        page: Millimetres behind the tolerance, if it was given so.
        notes: One line for each picture that is hardly what was meant.
    """
    method, evaluation = next(iter(comparison.evaluations.items()))
    return {
        "drawings": evaluation.to_frame().to_dict("records"),
        "mean": asdict(evaluation.mean),
        "interval": {name: asdict(comparison.interval(method, name)) for name in MEASURES},
        "settings": {**asdict(evaluation.settings), **(page or {})},
        "methods": {name: asdict(comparison.mean(name)) for name in comparison.evaluations},
        "failures": list(failures),
        "notes": list(notes),
    }


def write_evaluation(
    comparison: Comparison,
    gallery: OverlayGallery,
    failures: Sequence[str] = (),
    page: Mapping[str, float] | None = None,
    notes: Sequence[str] = (),
) -> dict[str, object]:
    """Write report.json and report.html into the gallery's folder, which is made if needed.

    Args:
        comparison: The methods' scores; the first one's drawings are shown.
        gallery: Their pictures.
        failures: One line for each item that could not be measured.
        page: Millimetres behind the tolerance, if it was given so.
        notes: One line for each picture that is hardly what was meant.

    Returns:
        The content of report.json.
    """
    gallery.folder.mkdir(parents=True, exist_ok=True)
    content = record(comparison, failures, page, notes)
    write_text(gallery.folder / "report.json", json.dumps(content, indent=1, allow_nan=False) + "\n")
    parts = sections(comparison, gallery, failures, page or {}, notes)
    write_report(gallery.folder / "report.html", _TITLE, parts, _lead(comparison))
    return content


def sections(
    comparison: Comparison,
    gallery: OverlayGallery,
    failures: Sequence[str],
    page: Mapping[str, float],
    notes: Sequence[str] = (),
) -> list[Section]:
    """The parts of the page: means and settings, each drawing's numbers, pictures."""
    evaluation = next(iter(comparison.evaluations.values()))
    settings = {**asdict(evaluation.settings), **page}
    summary: list[Block] = [comparison_table(comparison, _CAPTION)]
    if failures:
        summary.append(Text(f"{len(failures)} not measured: {'; '.join(failures)}", "warning"))
    summary += [Text(note, "warning") for note in notes]
    summary.append(Facts([(name.replace("_", " "), _in_words(value)) for name, value in settings.items()]))
    return [
        Section("Means", summary),
        Section("Drawings", [Fold(f"All {len(evaluation.scores)} comparisons", [scores_table(evaluation)])]),
        Section("Pictures", gallery.blocks()),
    ]


def _in_words(value: float | bool) -> str:
    return ("no", "yes")[value] if isinstance(value, bool) else f"{value:g}"


def scores_table(evaluation: Evaluation) -> Table:
    """One row a comparison of a drawing with a reference."""
    rows: list[list[Cell | str]] = []
    for score in evaluation.scores:
        values = {name: getattr(score.measures, name) for name in COLUMNS}
        cells = [Cell(shown(name, value), value) for name, value in values.items()]
        rows.append([score.name, score.reference, *cells])
    return Table(["Drawing", "Reference", *COLUMNS.values()], rows)


_CAPTION = (
    "IoU, F1, P (precision) and R (recall) in per cent, CD (symmetric Chamfer distance) in pixels; in small print the "
    "95 % confidence interval over resampled shapes. The best IoU, CD and F1 are bold."
)


def _lead(comparison: Comparison) -> str:
    evaluation = next(iter(comparison.evaluations.values()))
    names = {score.name for score in evaluation.scores}
    return (
        f"{len(names)} drawings of {len(set(comparison.shapes))} shapes against {len(evaluation.scores)} references, "
        "all thinned to one pixel; two pixels are near each other up to "
        f"{evaluation.settings.tolerance_pixels:g} pixels apart."
    )
