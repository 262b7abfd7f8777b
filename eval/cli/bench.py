"""`ncontours bench`: speed and its growth, whole commands, what faster presets cost, and drawings against rays."""

import os
import platform
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ncmodel.cli.common import emit, progress

if TYPE_CHECKING:
    from ncmodel.model.predictor import Model
    from ncmodel.report.part import Part
    from ncmodel.types import Mesh

Meshes = Annotated[
    list[Path] | None, typer.Argument(help="Meshes for the presets; by default those that pymeshlab bundles.")
]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder for bench.json and bench.html.")]
Large = Annotated[bool, typer.Option("--large", help="Up to 2 million faces: minutes, and 4 GB.")]
ModelFile = Annotated[Path | None, typer.Option("--model", help="Trained model, to measure its search for thresholds.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")]


BUNDLED = 4
"""Bundled meshes that presets are measured on: bunny, airplane, cow, bone."""


def bench(
    output: Output, meshes: Meshes = None, large: Large = False, model: ModelFile = None, as_json: AsJson = False
) -> None:
    """Measure speed over the size of the mesh, accuracy over the presets, and drawings against what rays see."""
    from dataset_tools.build import costs
    from dataset_tools.simulation.shapes import bumpy_torus, make_shapes
    from eval.benchmark.presets import measure_presets
    from eval.benchmark.processes import measure_processes
    from eval.benchmark.report import Bench
    from eval.benchmark.scaling import LARGE_SIZES, SIZES, measure_scaling
    from eval.demo.pipeline import bundled_meshes
    from ncmodel.mesh.load import load_mesh

    shapes = [load_mesh(path) for path in meshes or bundled_meshes()[:BUNDLED]]
    sizes = SIZES + LARGE_SIZES if large else SIZES
    trained = _load(model)
    with progress("bench", 2 * len(sizes) + len(shapes) * (3 if trained else 2) + costs.STEPS) as advance:
        found = Bench(
            scaling=measure_scaling(sizes, advance),
            processes=measure_processes(sizes, advance),
            efforts=measure_presets(shapes, advance),
            machine=_machine(),
            searches=measure_presets(shapes, advance, trained) if trained else (),
            parts=[
                coverage_part(shapes, advance),
                *costs.dataset_parts(bumpy_torus(costs.VIEW_FACES), make_shapes(costs.BUILD_SHAPES), advance),
            ],
        )
    found.write(output)
    emit(found.to_record(), as_json, f"{found.to_text()}\n\n{output / 'bench.html'}")


def coverage_part(meshes: "Sequence[Mesh]", advance: Callable[[str], None]) -> "Part":
    """How complete and how right drawings are, held against what rays see.

    Args:
        meshes: What to draw.
        advance: Called after each mesh.
    """
    from eval.benchmark.coverage import (
        BEHIND,
        GAP,
        JUMP,
        NEAR,
        SIZE,
        VIEWS,
        coverage_rows,
        mean_coverage,
        measure_coverage,
    )
    from ncmodel.report.part import Part
    from ncmodel.scene.seams import sew_seams
    from ncmodel.scene.surface import Surface

    found = measure_coverage((sew_seams(Surface(mesh)) for mesh in meshes), advance)
    text = (
        f"{len(VIEWS)} views of {SIZE} pixels each. Drawn: the share of the outline before the background and of where "
        f"depth jumps by {JUMP:g} of the shape's size, with a contour, boundary or crease within {NEAR:g} pixels. "
        f"Hidden: ink of all families more than {BEHIND:g} behind what is seen around it. Lost: what is seen of lines "
        f"and not drawn. Gaps: of {GAP[0]:g} to {GAP[1]:g} pixels in contours, a view."
    )
    return Part("coverage", "Drawings against rays", text, coverage_rows(mean_coverage(found)), _records(found))


def _records(items: Sequence[Any]) -> list[dict[str, Any]]:
    return [asdict(item) for item in items]


def _load(path: Path | None) -> "Model | None":
    if path is None:
        return None
    from ncmodel.model.predictor import load_model

    return load_model(path)


def _machine() -> dict[str, str]:
    return {"Python": platform.python_version(), "processors": str(os.cpu_count()), "system": platform.machine()}
