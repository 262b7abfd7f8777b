"""`ncontours bench`: speed and its growth, what faster presets cost, how right and neat drawings are."""

import os
import platform
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ncmodel.cli.common import emit, progress
from ncmodel.errors import ArgumentError, BatchError, MeshError

if TYPE_CHECKING:
    from ncmodel.model.predictor import Model
    from ncmodel.types import Mesh

Meshes = Annotated[
    list[Path] | None, typer.Argument(help="Meshes to draw; by default some of those that pymeshlab bundles.")
]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder for bench.json, bench.html and tables (CSV).")]
Large = Annotated[bool, typer.Option("--large", help="Up to 2 million faces: minutes, and 4 GB.")]
ModelFile = Annotated[Path | None, typer.Option("--model", help="Trained model, to measure its search for thresholds.")]
Parts = Annotated[
    str | None, typer.Option(help="Of speed,presets,coverage,neatness,dataset,search. (default all but search)")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")]

PARTS = ("speed", "presets", "coverage", "neatness", "dataset")
SEARCH = "search"
"""A part that runs only if asked for: the published schedule takes hours with a large ranking module."""

BUNDLED = 4
"""Bundled meshes that drawings are measured on: bunny, airplane, cow, bone."""


def bench(
    output: Output,
    meshes: Meshes = None,
    large: Large = False,
    model: ModelFile = None,
    parts: Parts = None,
    as_json: AsJson = False,
) -> None:
    """Measure speed over the size of the mesh, accuracy over the presets, and drawings of meshes."""
    from dataset_tools.build import costs
    from dataset_tools.simulation.shapes import bumpy_torus, make_shapes
    from eval.benchmark.parts import coverage_part, neatness_part
    from eval.benchmark.presets import measure_presets
    from eval.benchmark.processes import measure_processes
    from eval.benchmark.report import Bench
    from eval.benchmark.scaling import LARGE_SIZES, SIZES, measure_scaling
    from eval.benchmark.searches import search_part
    from eval.demo.pipeline import bundled_meshes

    wanted = _parts(parts)
    if SEARCH in wanted and model is None:
        raise ArgumentError("parts", SEARCH, "a model beside it: --model FILE")
    shapes, failures = _meshes(meshes or bundled_meshes()[:BUNDLED])
    sizes = SIZES + LARGE_SIZES if large else SIZES
    trained = _load(model)
    output.mkdir(parents=True, exist_ok=True)
    steps = {"speed": 2 * len(sizes), "presets": len(shapes) * (2 if trained else 1), "dataset": costs.STEPS}
    with progress("bench", sum(steps.get(part, len(shapes)) for part in wanted)) as advance:
        found = Bench(
            scaling=measure_scaling(sizes, advance) if "speed" in wanted else (),
            processes=measure_processes(sizes, advance) if "speed" in wanted else (),
            efforts=measure_presets(shapes, advance) if "presets" in wanted else (),
            machine=_machine(),
            searches=measure_presets(shapes, advance, trained) if trained and "presets" in wanted else (),
            parts=[
                *([coverage_part(shapes, output, failures, advance)] if "coverage" in wanted else []),
                *([neatness_part(shapes, output, failures, advance)] if "neatness" in wanted else []),
                *(
                    costs.dataset_parts(bumpy_torus(costs.VIEW_FACES), make_shapes(costs.BUILD_SHAPES), advance)
                    if "dataset" in wanted
                    else []
                ),
                *([search_part(shapes, trained, advance)] if SEARCH in wanted and trained else []),
            ],
            failures=failures,
        )
    found.write(output)
    emit(found.to_record(), as_json, f"{found.to_text()}\n\n{output / 'bench.html'}")
    if failures:
        raise BatchError(f"{len(failures)} could not be measured: {'; '.join(failures)}")


def _parts(asked: str | None) -> Sequence[str]:
    if asked is None:
        return PARTS
    names = [name.strip() for name in asked.split(",") if name.strip()]
    odd = next((name for name in names if name not in (*PARTS, SEARCH)), None)
    if odd is not None or not names:
        raise ArgumentError("parts", "none" if odd is None else repr(odd), f"some of {','.join((*PARTS, SEARCH))}")
    return names


def _meshes(paths: Sequence[Path]) -> "tuple[list[Mesh], list[str]]":
    """The meshes that can be read, and a line for each that can't.

    Raises:
        MeshError: None can.
    """
    from ncmodel.mesh.load import load_mesh

    meshes: list[Mesh] = []
    errors: list[MeshError] = []
    for path in paths:
        try:
            meshes.append(load_mesh(path))
        except MeshError as error:
            errors.append(error)
    if not meshes:
        raise errors[0]
    return meshes, list(map(str, errors))


def _load(path: Path | None) -> "Model | None":
    if path is None:
        return None
    from ncmodel.published.model import load_model

    return load_model(path)


def _machine() -> dict[str, str]:
    return {"Python": platform.python_version(), "processors": str(os.cpu_count()), "system": platform.machine()}
