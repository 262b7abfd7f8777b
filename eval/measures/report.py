"""An evaluation as files: report.json with every number, report.html to look at."""

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
from ncmodel.report.html import Block, Cell, Facts, Fold, Grid, Section, Table, Text, write_report
from ncmodel.types import Image, Mask

HIT = (70, 70, 70)
EXTRA = (213, 94, 0)
MISS = (0, 114, 178)
REMOVED = (236, 236, 230)
"""Colours of an overlay: grey, vermilion, blue (told apart with any colour vision), and a tint for the silhouette."""

PICTURE_SIDE, SMALLEST_SIDE = 480, 120
"""Longest side of the pictures in a report, pixels; with more drawings than `MANY` they are smaller."""
MANY = 100
"""Drawings whose pictures one page holds."""
_MORE_PAGES = "pictures-{}.html"

LEGEND = (
    "Overlays: grey lines are near the other drawing (hits), orange ones are drawn but not in the reference (extras), "
    "blue ones are in the reference but not drawn (misses). A pale band marks the silhouette, which isn't counted."
)


@dataclass
class OverlayGallery:
    """The pictures of an evaluation, gathered drawing by drawing and shrunk at once.

    Attributes:
        side: Longest side of a picture, pixels.
        rows: Drawing's name -> the drawing itself, then for each reference the overlay with it.
    """

    side: int = PICTURE_SIDE
    rows: dict[str, list[Tile]] = field(default_factory=dict)

    @staticmethod
    def of(count: int) -> "OverlayGallery":
        """A gallery for so many drawings: the page stays about as large as with `MANY`."""
        side = round(PICTURE_SIDE * min(1.0, (MANY / max(count, 1)) ** 0.5))
        return OverlayGallery(max(side, SMALLEST_SIDE))

    def pages(self) -> list[list[tuple[str, list[Tile]]]]:
        """The rows, page by page; at least one page."""
        rows = list(self.rows.items())
        return [rows[start : start + MANY] for start in range(0, max(len(rows), 1), MANY)]

    def add(self, target: Target, ink: Image, drawing: Lines, scores: Sequence[Score]) -> None:
        """Keep the pictures of one drawing and its comparisons."""
        tiles = [Tile(shrink(from_ink(ink), self.side), "the drawing")]
        for score in scores:
            reference = target.references[score.reference]
            pixels = overlay(drawing, reference, target.settings.tolerance_pixels, target.removed, self.side)
            caption = f"{score.reference}: F1 {shown('f1', score.measures.f1)}"
            tiles.append(Tile(shrink(pixels, self.side), caption, f"overlay with {caption}"))
        self.rows[target.name] = tiles


def overlay(
    drawing: Lines, reference: Lines, tolerance: float, removed: Mask | None = None, side: int = PICTURE_SIDE
) -> Pixels:
    """(H, W, 3) a drawing over its reference: hits, extras and misses in their colours.

    Args:
        drawing: The synthetic drawing.
        reference: The reference, of the same size.
        tolerance: Pixels up to which two pixels are near each other.
        removed: (H, W) the band taken away from both.
        side: Longest side that the picture will be scaled down to, pixels.
    """
    picture = np.full((*drawing.mask.shape, 3), 255, dtype=np.uint8)
    if removed is not None:
        picture[removed] = REMOVED
    near_reference, near_drawing = (_near(lines, tolerance) for lines in (reference, drawing))
    picture[_thick(drawing.mask & near_reference, side)] = HIT
    picture[_thick(drawing.mask & ~near_reference, side)] = EXTRA
    picture[_thick(reference.mask & ~near_drawing, side)] = MISS
    return picture


def _near(lines: Lines, tolerance: float) -> Mask:
    return np.zeros_like(lines.mask) if lines.empty else np.asarray(lines.distance <= tolerance)


def _thick(mask: Mask, side: int) -> Mask:
    """Lines of one pixel made as wide as they must be to show when the picture is scaled down to `side`."""
    width = 2 * max(1, round(max(mask.shape) / side)) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
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
    folder: str | Path,
    comparison: Comparison,
    gallery: OverlayGallery,
    failures: Sequence[str] = (),
    page: Mapping[str, float] | None = None,
    notes: Sequence[str] = (),
) -> dict[str, object]:
    """Write report.json and report.html into a folder, which is made if needed.

    Beyond the first `MANY` drawings their pictures are on pages of their own, pictures-2.html and so on.

    Args:
        folder: Where to.
        comparison: The methods' scores; the first one's drawings are shown.
        gallery: Its pictures.
        failures: One line for each item that could not be measured.
        page: Millimetres behind the tolerance, if it was given so.
        notes: One line for each picture that is hardly what was meant.

    Returns:
        The content of report.json.
    """
    root = Path(folder)
    root.mkdir(parents=True, exist_ok=True)
    content = record(comparison, failures, page, notes)
    write_text(root / "report.json", json.dumps(content, indent=1, allow_nan=False) + "\n")
    parts = sections(comparison, gallery, failures, page or {}, notes)
    write_report(root / "report.html", "Evaluation of line drawings", parts, _lead(comparison))
    for earlier in root.glob(_MORE_PAGES.format("*")):
        earlier.unlink()  # of a report on more drawings
    for number, rows in enumerate(gallery.pages()[1:], 2):
        shown = Section("Pictures", [Text(LEGEND, "note"), *_grids(rows, gallery.side)])
        write_report(root / _MORE_PAGES.format(number), "Evaluation of line drawings", [shown], f"Page {number}.")
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
    pictures: list[Block] = [Text(LEGEND, "note")]
    first, *more = gallery.pages()
    if more:
        names = f"{_MORE_PAGES.format(2)} to {_MORE_PAGES.format(len(more) + 1)}" if more[1:] else _MORE_PAGES.format(2)
        pictures.append(Text(f"The first {MANY} of {len(gallery.rows)} drawings; the others are in {names}.", "note"))
    pictures += _grids(first, gallery.side)
    return [
        Section("Means", summary),
        Section("Drawings", [Fold(f"All {len(evaluation.scores)} comparisons", [scores_table(evaluation)])]),
        Section("Pictures", pictures),
    ]


def _grids(rows: Sequence[tuple[str, list[Tile]]], side: int) -> list[Block]:
    return [Grid(tiles, name, columns=4, max_side=side) for name, tiles in rows]


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
