"""`ncontours fit-camera`: where drawings by people were seen from."""

import sys
import time
from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.common import emit
from ncmodel.errors import ArgumentError, UsageError

AsJson = Annotated[bool, typer.Option("--json", help="Print what was found as JSON.")]


def fit_camera(
    mesh: Annotated[Path, typer.Argument(help="Mesh file.")],
    drawing: Annotated[Path, typer.Argument(help="Picture of a drawing of it: lines on paper, the outline closed.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Camera file to write, *.json.")],
    picture: Annotated[
        Path | None, typer.Option(help="Both outlines over each other, *.png. (default beside the camera file)")
    ] = None,
    focal_pixels: Annotated[float | None, typer.Option(help="Focal length, if it is known. (default: found)")] = None,
    up: Annotated[str, typer.Option(help="The mesh file's upward axis, y or z.")] = "y",
    as_json: AsJson = False,
) -> None:
    """Find the camera that a drawing's outline was seen from."""
    import json

    from eval.people.fitting import fit_drawing
    from ncmodel.files import check_writable, write_text
    from ncmodel.images import write_png
    from ncmodel.mesh.load import load_mesh

    shown = picture or output.with_suffix(".png")
    if output.suffix.lower() != ".json" or shown.suffix.lower() != ".png":
        raise UsageError(f"found {output} and {shown}, expected --output *.json and --picture *.png")
    if shown.resolve() == drawing.resolve():
        raise ArgumentError("picture", f"{shown}, which is the drawing", "another file")
    if focal_pixels is not None and not 0.0 < focal_pixels < 1e6:
        raise ArgumentError("focal_pixels", str(focal_pixels), "a positive number of pixels")
    for path in (output, shown):
        check_writable(path)
    begin = time.perf_counter()
    found = fit_drawing(load_mesh(mesh, up), drawing, focal_pixels)
    write_text(output, found.camera.to_json() + "\n")
    write_png(shown, found.picture())
    for note in found.notes():
        sys.stderr.write(f"note: {note}\n")
    record = {
        "mesh": str(mesh),
        "drawing": str(drawing),
        "output": str(output),
        "picture": str(shown),
        "camera": json.loads(found.camera.to_json()),
        **found.to_record(),
        "seconds": round(time.perf_counter() - begin, 2),
    }
    fit = found.fit
    text = f"{output}: outline {fit.outline_distance:.2f} pixels from the drawn one, overlap {fit.overlap:.3f}; {shown}"
    emit(record, as_json, text)
