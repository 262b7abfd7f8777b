"""`ncontours draw`: meshes in, drawings out."""

from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.draw_job import DrawJob, chooser
from ncmodel.cli.draw_options import DrawOptions, takes
from ncmodel.errors import UsageError


@takes(DrawOptions)
def draw(
    output: Annotated[
        Path,
        typer.Option("--output", "-o", help="An .svg, .png, .pdf, .dxf or .json file; for several meshes, a folder."),
    ],
    meshes: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="MESH", help="Mesh files: obj, ply, stl, off, gltf, glb, 3mf, dae, step, iges; points: xyz."
        ),
    ] = None,
    maps: Annotated[
        Path | None,
        typer.Option(help="Folder of maps in place of meshes, as dataset export writes it."),
    ] = None,
    suffix: Annotated[
        str | None,
        typer.Option("--format", help="svg, png, pdf, dxf or json: write to a folder, even one mesh (default svg)."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was computed as JSON.")] = False,
    *,
    options: DrawOptions,
) -> None:
    """Draw the lines of shapes."""
    if maps is not None:
        _draw_maps(maps, output, options, as_json, {"a mesh": meshes, "--format": suffix})
        return
    if not meshes:
        raise UsageError("found neither a mesh nor --maps, expected one of them. Try --help.")
    job = DrawJob(options, output, "svg" if suffix is None else suffix, as_json)
    job.run(meshes, folder=len(meshes) > 1 or output.is_dir() or suffix is not None)


def _draw_maps(maps: Path, output: Path, options: DrawOptions, as_json: bool, beside: dict[str, object]) -> None:
    from ncmodel.cli.maps import MapsJob, alone

    others = {
        "--camera": options.camera,
        "--view": options.view,
        "--azimuth": options.azimuth,
        "--elevation": options.elevation,
        "--projection": options.projection,
        "--size": options.size,
        "--hidden": None if options.hidden == "none" else options.hidden,
        "--sort": options.sort,
    }
    alone(maps, **beside, **others)
    style = {"background": options.background} | ({} if options.width is None else {"width": options.width})
    how = {
        "model": chooser(options),
        "lines": options.lines,
        "thresholds": options.thresholds,
        "variant": options.variant,
        "preset": options.preset,
    }
    MapsJob(maps, output, style, how).run(as_json)
