"""`ncontours draw`: meshes in, drawings out."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.common import warn
from ncmodel.cli.draw_job import DrawJob, chooser
from ncmodel.cli.draw_options import DrawOptions, refuse_beside, takes
from ncmodel.cli.limited import MemoryGb, Seconds, limited
from ncmodel.cli.provenance import checksum, provenance
from ncmodel.errors import UsageError


def _unless_again(context: typer.Context, output: Path | None) -> Path | None:
    """The output, which must be given unless a file is drawn again."""
    if output is None and context.params.get("again") is None and not context.resilient_parsing:
        raise typer.BadParameter("found none, expected a file, or a folder for several meshes.")
    return output


@limited
@takes(DrawOptions)
def draw(
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            callback=_unless_again,
            help="An .svg, .png, .pdf, .dxf or .json file; for several meshes, a folder.",
        ),
    ] = None,
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
    again: Annotated[
        Path | None,
        typer.Option(
            is_eager=True,
            help="An .svg or .pdf file drawn before: draw it again as it says, or another MESH in its way.",
        ),
    ] = None,
    suffix: Annotated[
        str | None,
        typer.Option("--format", help="svg, png, pdf, dxf or json: write to a folder, even one mesh (default svg)."),
    ] = None,
    seconds: Seconds = None,
    memory_gb: MemoryGb = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was computed as JSON.")] = False,
    *,
    options: DrawOptions,
) -> None:
    """Draw the lines of shapes."""
    if again is not None:
        _draw_again(again, output, options, as_json, meshes or [], {"--maps": maps, "--format": suffix})
        return
    assert output is not None, "it is asked for unless a drawing is drawn again"
    if maps is not None:
        _draw_maps(maps, output, options, as_json, {"a mesh": meshes, "--format": suffix})
        return
    if not meshes:
        raise UsageError("found neither a mesh nor --maps, expected one of them. Try --help.")
    job = DrawJob(options, output, "svg" if suffix is None else suffix, as_json)
    job.run(meshes, folder=len(meshes) > 1 or output.is_dir() or suffix is not None)


def _draw_again(
    drawn: Path,
    output: Path | None,
    options: DrawOptions,
    as_json: bool,
    meshes: Sequence[Path],
    others: dict[str, object],
) -> None:
    """Draw what a file says of itself, to the same file unless told otherwise."""
    refuse_beside("--again", others)
    if options != DrawOptions():
        raise UsageError("--again: found other options beside it, expected none: the file says how it was drawn")
    if len(meshes) > 1:
        raise UsageError(f"--again: found {len(meshes)} meshes beside it, expected one at most")
    made = provenance(drawn)
    mesh = meshes[0] if meshes else drawn.parent / made.mesh
    if not meshes and mesh.is_file() and checksum(mesh) != made.checksum:
        warn(f"{mesh} isn't what {drawn} was drawn from: it has changed")
    seen_from = None if made.options.camera is None else made.camera
    name = None if meshes else made.mesh
    DrawJob(made.options, output or drawn, "svg", as_json, seen_from, name).run([mesh], folder=False)


def _draw_maps(maps: Path, output: Path, options: DrawOptions, as_json: bool, beside: dict[str, object]) -> None:
    from ncmodel.cli.maps import MapsJob, alone

    others = {
        "--camera": options.camera,
        "--view": options.view,
        "--azimuth": options.azimuth,
        "--elevation": options.elevation,
        "--projection": options.projection,
        "--size": options.size,
        "--views": options.views,
        "--page": options.page,
        "--curves": options.curves,
        "--colors": options.colors,
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
