"""`ncontours draw`: meshes in, drawings out."""

import json
import math
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ncmodel.cli.common import emit, progress
from ncmodel.cli.limited import MemoryGb, Seconds, limited
from ncmodel.errors import BatchError, InputError, NeuralContoursError, UsageError, printable

if TYPE_CHECKING:
    from ncmodel.camera import Camera
    from ncmodel.drawing.drawing import Drawing

CONTACT_SHEET = "contact-sheet.png"
THUMBNAIL = 256
"""Longest side of a drawing on the contact sheet, pixels."""
THUMBNAIL_WIDTH = 4.0
"""Line width, at 768, of drawings that are to be scaled down: thinner lines would turn grey."""


@limited
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
    camera: Annotated[Path | None, typer.Option(help="Camera file (JSON), not beside --azimuth, --elevation.")] = None,
    azimuth: Annotated[float | None, typer.Option(help="Degrees round the shape from its front (default 30)")] = None,
    elevation: Annotated[float | None, typer.Option(help="Degrees above the ground (default 30)")] = None,
    view: Annotated[
        str | None,
        typer.Option(help="front, back, left, right, top, bottom or iso, in place of --azimuth and --elevation."),
    ] = None,
    size: Annotated[str | None, typer.Option(help="N or WxH in pixels (default 768, or the camera's)")] = None,
    lines: Annotated[
        str | None,
        typer.Option(
            help="Families, of contours,boundaries,creases,intersections,suggestive,ridges,valleys,apparent. "
            "(default all but ridges and valleys)"
        ),
    ] = None,
    thresholds: Annotated[
        str | None, typer.Option(help="FAMILY=VALUE,... in rtsc's units (default suggestive=0.01, others 0.1)")
    ] = None,
    detail: Annotated[
        float,
        typer.Option(help="Share of the lines inside the outline, most important first: 0 outline alone, 1 all lines."),
    ] = 1.0,
    min_length: Annotated[
        float, typer.Option(help="Pixels, at 768; shorter strokes are left out, except the outline's.")
    ] = 0.0,
    hidden: Annotated[
        str, typer.Option(help="none, dashed or layer: lines behind the surface, in a group of their own.")
    ] = "none",
    width: Annotated[
        float | None, typer.Option(help="Line width in pixels, at 768; lines grow with the picture (default 2.5).")
    ] = None,
    background: Annotated[
        str | None, typer.Option(help="#rrggbb, white, black or transparent (default none; white in a .png)")
    ] = None,
    sort: Annotated[bool, typer.Option("--sort", help="Order strokes so that a plotter's pen travels little.")] = False,
    tolerance: Annotated[
        float | None, typer.Option(help="Pixels that simplified strokes may be off (default the preset's, 0.25)")
    ] = None,
    up: Annotated[str, typer.Option(help="The files' upward axis, y or z.")] = "y",
    crease_angle: Annotated[
        float | None, typer.Option(help="Degrees between faces above which their edge is a crease (default 40).")
    ] = None,
    model: Annotated[
        Path | None, typer.Option(help="Checkpoint that chooses what to draw, or default: the one that ships.")
    ] = None,
    variant: Annotated[
        str | None, typer.Option(help="full, geometry or image: the model's branches that take part (default all)")
    ] = None,
    mode: Annotated[
        str | None,
        typer.Option(help="paper or published: whose way a model draws (default published for imported weights)"),
    ] = None,
    preset: Annotated[
        str, typer.Option(help="instant, draft, balanced or accurate; matters with --model and in large pictures.")
    ] = "balanced",
    device: Annotated[str, typer.Option(help="Where the model computes: cpu, cuda, ...")] = "cpu",
    suffix: Annotated[
        str | None,
        typer.Option("--format", help="svg, png, pdf, dxf or json: write to a folder, even one mesh (default svg)."),
    ] = None,
    seconds: Seconds = None,
    memory_gb: MemoryGb = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was computed as JSON.")] = False,
) -> None:
    """Draw the lines of shapes."""
    style: dict[str, Any] = {"background": background} | ({} if width is None else {"width": width})
    chooser = None if model is None else _model(model, mode, device)
    if maps is not None:
        from ncmodel.cli.maps import MapsJob, alone

        others = {
            "--camera": camera,
            "--view": view,
            "--azimuth": azimuth,
            "--elevation": elevation,
            "--size": size,
            "--hidden": None if hidden == "none" else hidden,
        }
        alone(maps, **{"a mesh": meshes}, **others, **{"--format": suffix, "--sort": sort})
        options = {"model": chooser, "lines": lines, "thresholds": thresholds, "variant": variant, "preset": preset}
        MapsJob(maps, output, style, options).run(as_json)
        return
    if not meshes:
        raise UsageError("found neither a mesh nor --maps, expected one of them. Try --help.")
    azimuth, elevation = _angles(view, camera, azimuth, elevation)
    given = {
        "azimuth": azimuth,
        "elevation": elevation,
        "size": size,
        "crease_angle": crease_angle,
    }
    job = _Job(
        output=output,
        camera=_camera(camera, azimuth, elevation, size),
        style=style,
        sort=sort,
        suffix="svg" if suffix is None else suffix,
        as_json=as_json,
        options={
            "lines": lines,
            "thresholds": thresholds,
            "model": chooser,
            "variant": variant,
            "preset": preset,
            "up": up,
            "tolerance": tolerance,
            "detail": detail,
            "min_length": min_length,
            "hidden": hidden,
            **{name: value for name, value in given.items() if value is not None},
        },
    )
    if len(meshes) > 1 or output.is_dir() or suffix is not None:
        _draw_folder(job, meshes)
    else:
        _draw_file(job, meshes[0])


@dataclass(frozen=True)
class _Job:
    """What the options ask for; checked before the first mesh is read."""

    output: Path
    camera: "Camera | None"
    style: dict[str, Any]
    sort: bool
    suffix: str
    as_json: bool
    options: dict[str, Any]

    def __post_init__(self) -> None:
        from ncmodel.drawing.arguments import plan_of
        from ncmodel.export.page import WIDTH, Picture

        plan_of(**{name: self.options[name] for name in ("lines", "thresholds", "detail", "min_length", "hidden")})
        Picture(1, 1, (), self.style.get("width", WIDTH), self.style["background"])

    def draw(self, mesh: Path, output: Path) -> tuple["Drawing", dict[str, Any]]:
        """Draw one mesh to a file; the drawing, and its record for `--json`."""
        from ncmodel.drawing.draw import draw as draw_shape
        from ncmodel.tracing import timed

        begin = time.perf_counter()
        drawing = draw_shape(mesh, self.camera, **self.options)
        with timed(drawing.trace, "write"):
            drawing = drawing.sorted_for_pen() if self.sort else drawing
            drawing.save(output, **self.style)
        return drawing, _record(mesh, output, drawing, time.perf_counter() - begin)


def _draw_file(job: _Job, mesh: Path) -> None:
    from ncmodel.drawing.drawing import check_output

    check_output(job.output)
    _, record = job.draw(mesh, job.output)
    _tell_notes([record])
    emit(record, job.as_json)


def _tell_notes(records: Sequence[dict[str, Any]]) -> None:
    for record in records:
        for note in record["notes"]:
            sys.stderr.write(f"{printable(record['mesh'])}: {note}\n")


def _draw_folder(job: _Job, meshes: list[Path]) -> None:
    """Every mesh to a file of its name, and all of them on a contact sheet; failures are told at the end."""
    from ncmodel.drawing.drawing import SUFFIXES
    from ncmodel.images import from_ink, shrink, write_png
    from ncmodel.report.contact_sheet import Tile, contact_sheet

    if f".{job.suffix}" not in SUFFIXES:
        expected = ", ".join(suffix.removeprefix(".") for suffix in SUFFIXES)
        raise UsageError(f"--format: found {job.suffix!r}, expected one of {expected}")
    if not job.output.is_dir() and (job.output.exists() or job.output.suffix.lower() in SUFFIXES):
        found = "is a file" if job.output.exists() else "is named like a file"
        raise UsageError(f"--output: {job.output} {found}, expected a folder")
    job.output.mkdir(parents=True, exist_ok=True)
    records, failed, sheet = [], [], []
    with progress("draw", len(meshes)) as advance:
        for mesh, name in zip(meshes, _names(meshes), strict=True):
            try:
                drawing, record = job.draw(mesh, job.output / f"{name}.{job.suffix}")
            except (NeuralContoursError, OSError, MemoryError) as error:
                failed.append({"mesh": str(mesh), "error": str(error) or f"{printable(mesh)}: {type(error).__name__}"})
            else:
                records.append(record)
                sheet.append(Tile(shrink(from_ink(drawing.ink(THUMBNAIL_WIDTH)), THUMBNAIL), name))
            advance(printable(mesh.name))
    columns = max(1, math.ceil(math.sqrt(len(sheet))))
    write_png(job.output / CONTACT_SHEET, contact_sheet(sheet, columns, THUMBNAIL))
    _tell_notes(records)
    emit({"drawings": records, "failed": failed, "contact_sheet": str(job.output / CONTACT_SHEET)}, job.as_json)
    if failed:
        reasons = "; ".join(failure["error"] for failure in failed)
        raise BatchError(f"{len(failed)} of {len(meshes)} meshes failed: {reasons}")


def _camera(path: Path | None, azimuth: float | None, elevation: float | None, size: str | None) -> "Camera | None":
    from ncmodel.camera import Camera
    from ncmodel.drawing.arguments import size_of

    if path is None:
        return None
    if azimuth is not None or elevation is not None:
        raise UsageError("--camera: found --azimuth or --elevation beside it, expected one or the other")
    camera = Camera.load(path)
    return camera if size is None else camera.resized(*size_of(size))


def _angles(
    view: str | None, camera: Path | None, azimuth: float | None, elevation: float | None
) -> tuple[float | None, float | None]:
    """Azimuth and elevation, those of a named view if there is one."""
    from ncmodel.camera import VIEWS

    if view is None:
        return azimuth, elevation
    others = {"--camera": camera, "--azimuth": azimuth, "--elevation": elevation}
    beside = next((name for name, value in others.items() if value is not None), None)
    if beside is not None:
        raise UsageError(f"--view: found {beside} beside it, expected one or the other")
    if view not in VIEWS:
        raise UsageError(f"--view: found {view!r}, expected one of {', '.join(VIEWS)}")
    return VIEWS[view]


def _model(path: Path, mode: str | None, device: str) -> Any:
    from ncmodel.nets.shipped import checkpoint_path

    path = checkpoint_path(path)
    if not path.is_file():
        # Told without the seconds that it takes to import the networks.
        raise InputError(path, "no such file", "a checkpoint")
    from ncmodel.published.model import load_model

    return load_model(path, mode, device)  # type: ignore[arg-type]  # it checks


def _names(meshes: list[Path]) -> list[str]:
    """A file name for each mesh: its own, with a number where that is taken."""
    names: list[str] = []
    taken = {Path(CONTACT_SHEET).stem}
    for mesh in meshes:
        name, number = mesh.stem, 1
        while name in taken:
            number += 1
            name = f"{mesh.stem}-{number}"
        taken.add(name)
        names.append(name)
    return names


def _record(mesh: Path, output: Path, drawing: "Drawing", seconds: float) -> dict[str, Any]:
    """What `--json` says of a drawing."""
    plan = drawing.plan
    return {
        "mesh": str(mesh),
        "output": str(output),
        "shape": drawing.name,
        "width": drawing.width,
        "height": drawing.height,
        "families": [family.value for family in plan.drawn],
        "thresholds": {name: _finite(value) for name, value in plan.filtered.items()},
        "threshold_unit": plan.thresholds.unit,
        "detail": plan.detail,
        "min_length": plan.min_length,
        "hidden": plan.hidden,
        "score": plan.score,
        "score_evaluations": plan.evaluations,
        "strokes": dict(Counter(stroke.group for stroke in drawing.strokes)),
        "computed": [timing.stage for timing in drawing.trace.timings],
        "seconds": drawing.trace.seconds(),
        "seconds_total": seconds,
        "notes": list(drawing.notes),
        "camera": json.loads(drawing.camera.to_json()),
    }


def _finite(value: float | None) -> float | None:
    """The value, or None where JSON has no word for it."""
    return value if value is not None and math.isfinite(value) else None
