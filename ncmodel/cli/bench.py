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
    from eval.bench import Part
    from ncmodel.model import Model
    from ncmodel.types import Mesh

Meshes = Annotated[
    list[Path] | None, typer.Argument(help="Meshes for the presets; by default those that pymeshlab bundles.")
]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder for bench.json and bench.html.")]
Large = Annotated[bool, typer.Option("--large", help="Up to 2 million faces: minutes, and 4 GB.")]
ModelFile = Annotated[Path | None, typer.Option("--model", help="Trained model, to measure its search for thresholds.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")]

DATASET_STEPS = 4

BUNDLED = 4
"""Bundled meshes that presets are measured on: bunny, airplane, cow, bone."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("bench")(bench)


def bench(
    output: Output, meshes: Meshes = None, large: Large = False, model: ModelFile = None, as_json: AsJson = False
) -> None:
    """Measure speed over the size of the mesh, accuracy over the presets, and drawings against what rays see."""
    from eval.bench import Bench
    from eval.processes import measure_processes
    from eval.scaling import LARGE_SIZES, SIZES, measure_scaling
    from eval.tradeoff import measure_presets
    from ncmodel.cli.demo import bundled_meshes
    from ncmodel.geometry.mesh import load_mesh

    shapes = [load_mesh(path) for path in meshes or bundled_meshes()[:BUNDLED]]
    sizes = SIZES + LARGE_SIZES if large else SIZES
    trained = _load(model)
    with progress("bench", 2 * len(sizes) + len(shapes) * (3 if trained else 2) + DATASET_STEPS) as advance:
        found = Bench(
            scaling=measure_scaling(sizes, advance),
            processes=measure_processes(sizes, advance),
            efforts=measure_presets(shapes, advance),
            machine=_machine(),
            searches=measure_presets(shapes, advance, trained) if trained else (),
            parts=[coverage_part(shapes, advance), *dataset_parts(advance)],
        )
    found.write(output)
    emit(found.to_record(), as_json, f"{found.to_text()}\n\n{output / 'bench.html'}")


def coverage_part(meshes: "Sequence[Mesh]", advance: Callable[[str], None]) -> "Part":
    """How complete and how right drawings are, held against what rays see.

    Args:
        meshes: What to draw.
        advance: Called after each mesh.
    """
    from eval.bench import Part
    from eval.coverage import BEHIND, GAP, JUMP, NEAR, SIZE, VIEWS, coverage_rows, mean_coverage, measure_coverage
    from ncmodel.geometry.seams import sewn
    from ncmodel.geometry.surface import Surface

    found = measure_coverage((sewn(Surface(mesh)) for mesh in meshes), advance)
    text = (
        f"{len(VIEWS)} views of {SIZE} pixels each. Drawn: the share of the outline before the background and of where "
        f"depth jumps by {JUMP:g} of the shape's size, with a contour, boundary or crease within {NEAR:g} pixels. "
        f"Hidden: ink of all families more than {BEHIND:g} behind what is seen around it. Lost: what is seen of lines "
        f"and not drawn. Gaps: of {GAP[0]:g} to {GAP[1]:g} pixels in contours, a view."
    )
    return Part("coverage", "Drawings against rays", text, coverage_rows(mean_coverage(found)), _records(found))


def dataset_parts(advance: Callable[[str], None]) -> "list[Part]":
    """What a view of the data set costs, its distances the obvious ways, and what a second worker brings.

    Args:
        advance: Called after each of the `DATASET_STEPS`.
    """
    from dataset_tools import bench as costs
    from dataset_tools.shapes import make_shapes
    from eval.bench import Part
    from eval.scaling import bumpy_torus

    mesh = bumpy_torus(costs.VIEW_FACES)
    view = costs.measure_view(mesh)
    advance("a view")
    distances = costs.compare_distances(mesh)
    advance("distances")
    builds = costs.measure_builds(make_shapes(costs.BUILD_SHAPES), (1, 2), advance)
    of_view = (
        f"One view of {view.faces:,} faces, all but cleaning, on one thread: {view.cpu_seconds:.2f} s of processor, "
        f"{view.peak_bytes / 1e6:.0f} MB of memory at most, {view.output_bytes / 1e6:.2f} MB of files. "
        "Stages on the clock; the fastest of several runs."
    )
    of_ways = "Processor time. KD-trees are timed on some of the pairs and multiplied."
    of_builds = "Meshes to finished views on the clock: reading, cleaning, start-up of the workers, everything."
    return [
        Part("view", "A view of the data set", of_view, costs.view_rows(view), asdict(view)),
        Part("distances", "Distances between candidates", of_ways, costs.distance_rows(distances), _records(distances)),
        Part("builds", "Workers", of_builds, costs.build_rows(builds), _records(builds)),
    ]


def _records(items: Sequence[Any]) -> list[dict[str, Any]]:
    return [asdict(item) for item in items]


def _load(path: Path | None) -> "Model | None":
    if path is None:
        return None
    from ncmodel.model import load_model

    return load_model(path)


def _machine() -> dict[str, str]:
    return {"Python": platform.python_version(), "processors": str(os.cpu_count()), "system": platform.machine()}
