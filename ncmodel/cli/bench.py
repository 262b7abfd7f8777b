"""`ncontours bench`: speed and its growth, whole commands, and what the faster presets cost in accuracy."""

import os
import platform
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ncmodel.cli.common import emit, progress

if TYPE_CHECKING:
    from ncmodel.model import Model

Meshes = Annotated[
    list[Path] | None, typer.Argument(help="Meshes for the presets; by default those that pymeshlab bundles.")
]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder for bench.json and bench.html.")]
Large = Annotated[bool, typer.Option("--large", help="Up to 2 million faces: minutes, and 4 GB.")]
ModelFile = Annotated[Path | None, typer.Option("--model", help="Trained model, to measure its search for thresholds.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")]

BUNDLED = 4
"""Bundled meshes that presets are measured on: bunny, airplane, cow, bone."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("bench")(bench)


def bench(
    output: Output, meshes: Meshes = None, large: Large = False, model: ModelFile = None, as_json: AsJson = False
) -> None:
    """Measure speed over the size of the mesh, and accuracy over the presets."""
    from eval.bench import Bench
    from eval.processes import measure_processes
    from eval.scaling import LARGE_SIZES, SIZES, measure_scaling
    from eval.tradeoff import measure_presets
    from ncmodel.cli.demo import bundled_meshes
    from ncmodel.geometry.mesh import load_mesh

    shapes = [load_mesh(path) for path in meshes or bundled_meshes()[:BUNDLED]]
    sizes = SIZES + LARGE_SIZES if large else SIZES
    trained = _load(model)
    with progress("bench", 2 * len(sizes) + len(shapes) * (2 if trained else 1)) as advance:
        found = Bench(
            scaling=measure_scaling(sizes, advance),
            processes=measure_processes(sizes, advance),
            efforts=measure_presets(shapes, advance),
            machine=_machine(),
            searches=measure_presets(shapes, advance, trained) if trained else (),
        )
    found.write(output)
    emit(found.to_record(), as_json, f"{found.to_text()}\n\n{output / 'bench.html'}")


def _load(path: Path | None) -> "Model | None":
    if path is None:
        return None
    from ncmodel.model import load_model

    return load_model(path)


def _machine() -> dict[str, str]:
    return {"Python": platform.python_version(), "processors": str(os.cpu_count()), "system": platform.machine()}
