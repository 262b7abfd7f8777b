"""What the benchmark reports of drawings: how right they are, and how neat."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

from eval.benchmark import coverage, neatness
from eval.benchmark.each_view import VIEWS, mean_rows
from eval.benchmark.kept_rows import measure_kept
from ncmodel.camera import DEFAULT_SIZE
from ncmodel.report.part import Part
from ncmodel.types import Mesh


def coverage_part(meshes: Sequence[Mesh], folder: Path, failures: list[str], advance: Callable[[str], None]) -> Part:
    """How complete and how right drawings are, held against what rays see.

    Args:
        meshes: What to draw.
        folder: Where coverage.csv is kept.
        failures: Gets a line for each mesh that can't be measured.
        advance: Called after each mesh.
    """
    file, measure = folder / "coverage.csv", coverage.measure_coverage
    found, failed = measure_kept(coverage.Coverage, measure, meshes, file, advance)
    failures += failed
    low, high = coverage.GAP
    text = (
        f"{len(VIEWS)} views of {coverage.SIZE} pixels each. Drawn: the share of the outline before the "
        f"background and of where depth jumps by {coverage.JUMP:g} of the shape's size, with a contour, boundary or "
        f"crease within {coverage.NEAR:g} pixels. Hidden: ink of all families more than {coverage.BEHIND:g} behind "
        f"what is seen around it. Lost: what is seen of lines and not drawn; of contours, where depth jumps. Gaps: of "
        f"{low:g} to {high:g} pixels in contours, a view."
    )
    rows = coverage.coverage_rows(mean_rows(found))
    return Part("coverage", "Drawings against rays", text, rows, [asdict(row) for row in found])


def neatness_part(meshes: Sequence[Mesh], folder: Path, failures: list[str], advance: Callable[[str], None]) -> Part:
    """How neat default drawings are.

    Args:
        meshes: What to draw.
        folder: Where neatness.csv is kept.
        failures: Gets a line for each mesh that can't be measured.
        advance: Called after each mesh.
    """
    file, measure = folder / "neatness.csv", neatness.measure_neatness
    found, failed = measure_kept(neatness.Neatness, measure, meshes, file, advance)
    failures += failed
    low, high = neatness.DASH_GAP
    text = (
        f"The default drawing from {len(VIEWS)} views of {DEFAULT_SIZE} pixels each; less is better. "
        f"Jaggedness: degrees of turns that a line takes back within {neatness.BACK:g} pixels, on 100 pixels of line. "
        f"Dashes: gaps of {low:g} to {high:g} pixels between ends that continue each other, how many a view and their "
        f"length together. Doubles: share of the lines' length that runs within {neatness.DOUBLE:g} pixels along "
        f"another family's line. Crumbs: share of the ink in strokes under {neatness.CRUMB:.0%} of the picture. Open "
        "outlines: ends of the outline that meet no line."
    )
    rows = neatness.neatness_rows(mean_rows(found))
    return Part("neatness", "How neat drawings are", text, rows, [asdict(row) for row in found])
