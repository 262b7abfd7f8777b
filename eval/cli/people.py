"""`ncontours fit-camera`, `register`, `references`: drawings by people, from camera and scan to references."""

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ncmodel.cli.common import emit
from ncmodel.errors import ArgumentError, BatchError, UsageError

if TYPE_CHECKING:
    from ncmodel.types import Image

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


def register(
    scan: Annotated[Path, typer.Argument(help="Scan or photo of a drawing on paper.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Ink picture to write, *.png.")],
    by: Annotated[
        str, typer.Option(help="marks (four discs at the corners), frame (printed), page (its edges) or rendering.")
    ] = "marks",
    size: Annotated[str | None, typer.Option(help="Of the picture, N or WxH. (default the rendering's)")] = None,
    rendering: Annotated[Path | None, typer.Option(help="What was printed with it, of the picture's size.")] = None,
    mesh: Annotated[Path | None, typer.Option(help="Mesh whose rendering was printed; needs --camera.")] = None,
    camera: Annotated[Path | None, typer.Option(help="Camera file of that rendering.")] = None,
    drawing_at: Annotated[
        str | None, typer.Option(help="X,Y in the rendering's pixels where the drawing begins. (default 0,0: over it)")
    ] = None,
    turn: Annotated[int, typer.Option(help="Turn the scan clockwise first: 90, 180 or 270.")] = 0,
    millimetres: Annotated[float | None, typer.Option(help="Width of the picture on the page.")] = None,
    elastic: Annotated[bool, typer.Option("--elastic", help="Bend it onto the outline: erases real error.")] = False,
    up: Annotated[str, typer.Option(help="The mesh file's upward axis, y or z.")] = "y",
    as_json: AsJson = False,
) -> None:
    """Lay a scan of a drawing straight over its picture, and make pencil on grey paper ink."""
    from eval.people.scanned import Page, take_drawing
    from ncmodel.drawing.arguments import size_of
    from ncmodel.files import check_writable
    from ncmodel.images import from_ink, write_png

    if output.suffix.lower() != ".png":
        raise ArgumentError("output", str(output), "a file *.png")
    check_writable(output)
    shown = _rendering(rendering, mesh, camera, up)
    of_rendering = None if shown is None else (shown.shape[1], shown.shape[0])
    chosen = of_rendering if size is None else size_of(size)
    if chosen is None:
        raise UsageError("--size: found none, expected the picture's size, or --rendering, or --mesh and --camera")
    if shown is not None and chosen != of_rendering:
        raise ArgumentError("size", f"{size} and a rendering of {shown.shape[1]}x{shown.shape[0]}", "one size")
    page = Page(by, chosen, turn, millimetres, _place(drawing_at), elastic)
    found = take_drawing(scan, page, shown)
    write_png(output, from_ink(found.ink))
    for note in found.notes:
        sys.stderr.write(f"note: {note}\n")
    record = {"scan": str(scan), "output": str(output), **found.to_record()}
    scale = found.registration.mm_per_pixel
    measured = "" if scale is None else f"; evaluate it with --mm-per-pixel {scale:.6g}"
    emit(record, as_json, f"{output}: {chosen[0]} x {chosen[1]} pixels, by {by}{measured}")


def _rendering(rendering: Path | None, mesh: Path | None, camera: Path | None, up: str) -> "Image | None":
    """What was printed, from its picture or from the mesh."""
    from ncmodel.camera import Camera
    from ncmodel.images import read_grey
    from ncmodel.mesh.load import load_mesh
    from ncmodel.scene.surface import Surface
    from ncmodel.scene.view import View

    if (mesh is None) != (camera is None):
        raise UsageError("found one of --mesh and --camera, expected both or none")
    if rendering is not None or mesh is None or camera is None:
        return None if rendering is None else read_grey(rendering)
    shaded: Image = View(Surface(load_mesh(mesh, up)), Camera.load(camera)).shaded[0]
    return shaded


def _place(text: str | None) -> tuple[float, float]:
    if text is None:
        return 0.0, 0.0
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise ArgumentError("drawing_at", repr(text), "two numbers X,Y") from None
    return x, y


def references(
    source: Annotated[Path, typer.Argument(help="The collection's folder, as it was unpacked.")],
    layout: Annotated[
        str, typer.Argument(help="cole2008, extension, differsketching, tracing-freehand, opensketch or named.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for references, meshes, cameras, silhouettes.")
    ],
    names: Annotated[
        str | None, typer.Option(help='What files\' names tell: "{shape}_{view}_{artist}", {} for anything else.')
    ] = None,
    group: Annotated[str | None, typer.Option(help="Part of the collection, such as tracings or concept.")] = None,
    meshes: Annotated[Path | None, typer.Option(help="Folder of the shapes' meshes, SHAPE.obj each.")] = None,
    cameras: Annotated[
        str | None,
        typer.Option(help="Folder of camera files SHAPE_VIEW.json; fit: found by outlines; given: the collection's."),
    ] = None,
    licence: Annotated[str | None, typer.Option(help="Terms to keep with them. (default those published)")] = None,
    as_json: AsJson = False,
) -> None:
    """Write a collection of people's drawings as references, with licence and provenance."""
    from eval.people.collections import Asked, find_drawings
    from eval.people.reference_folder import Wanted, write_references
    from ncmodel.cli.common import progress

    if cameras is not None and meshes is None:
        raise ArgumentError("cameras", f"{cameras} and no meshes", "--meshes with it")
    drawings = find_drawings(source, layout, Asked(names, group))
    wanted = Wanted(source, layout, meshes, cameras, licence)
    with progress("references", len({drawing.name for drawing in drawings})) as advance:
        written = write_references(drawings, output, wanted, advance)
    for note in written.notes:
        sys.stderr.write(f"note: {note}\n")
    views = len({record["name"] for record in written.drawings})
    record = {
        "output": str(output),
        "drawings": len(written.drawings),
        "views": views,
        "cameras": len(written.cameras),
        "failures": written.failures,
        "notes": written.notes,
    }
    emit(
        record, as_json, f"{output}: {len(written.drawings)} drawings of {views} views, {len(written.cameras)} cameras"
    )
    if written.failures:
        raise BatchError(f"{len(written.failures)} views not written: {'; '.join(written.failures)}")
