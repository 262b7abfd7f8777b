"""`ncontours evaluate`: synthetic drawings against references, measured as Cole et al. did."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.common import emit, progress
from ncmodel.errors import BatchError, UsageError

Drawings = Annotated[
    list[Path], typer.Option(help="Folder of drawings, NAME.png each; given several times, methods beside each other.")
]
References = Annotated[Path, typer.Option(help="Folder of references: NAME.png or NAME/*.png (or JPEG, TIFF).")]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder for report.json and report.html.")]
Silhouettes = Annotated[
    Path | None, typer.Option(help="Folder of silhouettes NAME.png (masks or outlines) to take away from all drawings.")
]
Whole = Annotated[
    bool, typer.Option("--keep-silhouettes", help="Count silhouettes too, where references come with their meshes'.")
]
TolerancePixels = Annotated[float | None, typer.Option(help="How far apart near pixels may be; 5 by default.")]
ToleranceMm = Annotated[float | None, typer.Option(help="The same in mm on the page; needs --mm-per-pixel.")]
MmPerPixel = Annotated[float | None, typer.Option(help="Size of a pixel on the page; alone, the tolerance is 1 mm.")]
Threshold = Annotated[float | None, typer.Option(help="Ink from which on a pixel counts as drawn; 0.5 by default.")]
MostConsistent = Annotated[bool, typer.Option(help="Of several references take the one closest to the rest.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the report as JSON.")]


def evaluate(
    drawings: Drawings,
    references: References,
    output: Output,
    silhouettes: Silhouettes = None,
    keep_silhouettes: Whole = False,
    tolerance_pixels: TolerancePixels = None,
    tolerance_mm: ToleranceMm = None,
    mm_per_pixel: MmPerPixel = None,
    threshold: Threshold = None,
    most_consistent: MostConsistent = False,
    as_json: AsJson = False,
) -> None:
    """Measure drawings against references: precision, recall, F1, IoU, Chamfer distance."""
    from eval.measures.comparison import comparison_text
    from eval.measures.evaluation import Settings
    from eval.measures.folders import Folders, evaluate_folders
    from eval.measures.references import known_silhouettes
    from eval.measures.report import write_evaluation
    from eval.measures.thinning import DEFAULT_THRESHOLD

    tolerance, page = resolve_tolerance(tolerance_pixels, tolerance_mm, mm_per_pixel)
    settings = Settings(tolerance, DEFAULT_THRESHOLD if threshold is None else threshold, most_consistent)
    if silhouettes is not None and keep_silhouettes:
        raise UsageError("found --silhouettes and --keep-silhouettes, expected one of them")
    taken = silhouettes or (None if keep_silhouettes else known_silhouettes(references))
    folders = Folders(_by_name(drawings), references, taken)
    with progress("evaluate", len(folders.names)) as advance:
        result = evaluate_folders(folders, settings, output, advance)
    report = write_evaluation(result.comparison, result.gallery, result.failures, page, result.notes)
    for note in result.notes:
        sys.stderr.write(f"note: {note}\n")
    emit(report, as_json, f"{comparison_text(result.comparison)}\n{output / 'report.html'}")
    if result.failures:
        raise BatchError(f"{len(result.failures)} not measured: {'; '.join(result.failures)}")


def resolve_tolerance(
    pixels: float | None, millimetres: float | None, millimetres_per_pixel: float | None
) -> tuple[float, dict[str, float]]:
    """The tolerance in pixels from what was given, and the page's measures behind it.

    Raises:
        UsageError: The options contradict each other.
    """
    from eval.measures.evaluation import DEFAULT_TOLERANCE
    from eval.measures.metrics import tolerance_from_page

    if millimetres is None and millimetres_per_pixel is None:
        return DEFAULT_TOLERANCE if pixels is None else pixels, {}
    if pixels is not None:
        raise UsageError("found --tolerance-pixels and a tolerance in mm, expected one of them")
    if millimetres_per_pixel is None:
        raise UsageError("found --tolerance-mm alone, expected --mm-per-pixel with it")
    page = {"tolerance_mm": 1.0 if millimetres is None else millimetres, "mm_per_pixel": millimetres_per_pixel}
    return tolerance_from_page(page["tolerance_mm"], millimetres_per_pixel), page


def _by_name(folders: list[Path]) -> dict[str, Path]:
    names = {folder.resolve().name: folder for folder in folders}
    if len(names) < len(folders):
        raise UsageError(f"--drawings: found {len(folders)} folders of {len(names)} names, expected different names")
    return names
