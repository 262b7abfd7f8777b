"""What `ncontours draw` does with meshes: one to a file, several to a folder."""

import json
import math
import os
import sys
import time
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ncmodel.cli.common import emit, progress
from ncmodel.cli.draw_options import DrawOptions
from ncmodel.cli.provenance import Provenance, checksum
from ncmodel.errors import BatchError, InputError, NeuralContoursError, UsageError, printable

if TYPE_CHECKING:
    from ncmodel.camera import Camera
    from ncmodel.drawing.drawing import Drawing
    from ncmodel.export.page import Picture
    from ncmodel.sheets.sheet import Layout, Sheet

CONTACT_SHEET = "contact-sheet.png"
THUMBNAIL = 256
"""Longest side of a drawing on the contact sheet, pixels."""
POLYLINE_SHARE = 0.1
"""Of the tolerance, for the polylines that curves are fitted to; the rest is the curves'."""
THUMBNAIL_WIDTH = 4.0
"""Line width, at 768, of drawings that are to be scaled down: thinner lines would turn grey."""


@dataclass(frozen=True)
class DrawJob:
    """What is asked for; checked before the first mesh is read.

    Attributes:
        options: How to draw.
        output: A file, or a folder.
        suffix: The format in a folder, without the dot.
        as_json: Whether to print what was computed.
        seen_from: The camera, where it is known without its file.
        mesh_name: What the drawing says of its mesh; the way to it from the drawing's folder by default.
    """

    options: DrawOptions
    output: Path
    suffix: str
    as_json: bool
    seen_from: "Camera | None" = None
    mesh_name: str | None = None

    def __post_init__(self) -> None:
        from ncmodel.drawing.arguments import plan_of
        from ncmodel.export.page import Picture

        asked = self.options
        plan_of(asked.lines, asked.thresholds, asked.detail, asked.min_length, asked.hidden)
        Picture(1, 1, (), self.width, asked.background)
        # Worked out now: what is wrong with them is wrong with every mesh.
        _ = self.layout, self.curve, self.camera, self.how

    @property
    def width(self) -> float:
        """Line width."""
        from ncmodel.export.page import WIDTH

        return WIDTH if self.options.width is None else self.options.width

    @cached_property
    def curve(self) -> float:
        """Pixels that curves may stray from the strokes; 0 where polylines are drawn."""
        return self._tolerances[1]

    @cached_property
    def _tolerances(self) -> tuple[float | None, float]:
        """What strokes may stray from lines on the mesh, if it isn't the preset's; and curves from strokes."""
        from ncmodel.drawing.draw import fineness_of

        asked = self.options
        if not asked.curves:
            return asked.tolerance, 0.0
        allowed = fineness_of(asked.preset, asked.tolerance).tolerance
        if allowed <= 0.0:
            raise UsageError("--curves: found a tolerance of 0, expected one to lie within")
        return POLYLINE_SHARE * allowed, (1.0 - POLYLINE_SHARE) * allowed

    @cached_property
    def layout(self) -> "Layout | None":
        """What is on the sheet, if there is one."""
        asked = self.options
        if asked.views is None and asked.page is None:
            return None
        from ncmodel.drawing.arguments import size_of
        from ncmodel.sheets.arrangement import names_of
        from ncmodel.sheets.paper import paper_of, ratio
        from ncmodel.sheets.sheet import Layout

        return Layout(
            () if asked.views is None else names_of(asked.views),
            asked.angle or "third",
            None if asked.size is None else size_of(asked.size),
            None if asked.page is None else paper_of(asked.page, asked.margin or "10mm"),
            None if asked.scale is None else ratio(asked.scale),
        )

    @cached_property
    def how(self) -> dict[str, Any]:
        """How `draw` draws, but for the camera."""
        asked = self.options
        azimuth, elevation = asked.angles
        given = {
            "azimuth": azimuth,
            "elevation": elevation,
            "size": asked.size if self.layout is None else None,
            "projection": asked.projection,
            "crease_angle": asked.crease_angle,
        }
        return {
            "lines": asked.lines,
            "thresholds": asked.thresholds,
            "model": chooser(asked),
            "variant": asked.variant,
            "preset": asked.preset,
            "up": asked.up,
            "tolerance": self._tolerances[0],
            "detail": asked.detail,
            "min_length": asked.min_length,
            "hidden": asked.hidden,
            **{name: value for name, value in given.items() if value is not None},
        }

    @cached_property
    def camera(self) -> "Camera | None":
        """Where from, if a file says so."""
        from ncmodel.camera import Camera
        from ncmodel.drawing.arguments import size_of

        asked = self.options
        if self.seen_from is not None or asked.camera is None:
            return self.seen_from
        camera = Camera.load(asked.camera)
        camera = camera if asked.projection is None else camera.projected(asked.projection)
        return camera if asked.size is None else camera.resized(*size_of(asked.size))

    def run(self, meshes: Sequence[Path], folder: bool) -> None:
        """Draw them: to a folder, or one to the output."""
        if folder:
            self._draw_folder(meshes)
        else:
            self._draw_file(meshes[0])

    def _draw(self, mesh: Path, output: Path) -> tuple["Drawing | Sheet", dict[str, Any]]:
        """Draw one mesh to a file; the drawing, and its record for `--json`."""
        from ncmodel.drawing.draw import draw
        from ncmodel.export.files import write_picture
        from ncmodel.tracing import timed

        begin = time.perf_counter()
        shown: Drawing | Sheet
        if self.layout is None:
            shown = draw(mesh, self.camera, **self.how)
        else:
            from ncmodel.sheets.sheet import draw_sheet

            shown = draw_sheet(mesh, self.layout, camera=self.camera, **self.how)
        with timed(shown.trace, "write"):
            shown = shown.sorted_for_pen() if self.options.sort else shown
            if output.suffix.lower() == ".json":
                shown.save(output)
            else:
                write_picture(output, self._picture(mesh, shown, output))
        return shown, _record(mesh, output, shown, time.perf_counter() - begin)

    def _picture(self, mesh: Path, shown: "Drawing | Sheet", output: Path) -> "Picture":
        """The page for a file; with how it was made, where the format keeps that."""
        from ncmodel.export.files import RECORDED

        asked = self.options
        picture = shown.picture(self.width, asked.background, asked.colors, self.curve)
        if output.suffix.lower() not in RECORDED:
            return picture
        name = Path(os.path.relpath(mesh, output.parent)).as_posix() if self.mesh_name is None else self.mesh_name
        made = Provenance(name, checksum(mesh), self.options, self.camera or shown.camera)
        return replace(picture, record=made.text(shown.plan))

    def _check_output(self, suffix: str) -> None:
        """Raise if what is asked for can't be written in a format.

        Raises:
            UsageError: It can't.
        """
        from ncmodel.export.files import CURVED, PAGES, SUFFIXES

        asked = self.options
        kinds = {"--views": SUFFIXES[:-1], "--page": PAGES, "--curves": CURVED}
        given = {"--views": asked.views is not None, "--page": asked.page is not None, "--curves": asked.curves}
        for name, formats in kinds.items():
            if given[name] and suffix in SUFFIXES and suffix not in formats:
                raise UsageError(f"{name}: found a file {suffix}, expected {', '.join(formats)}")

    def _draw_file(self, mesh: Path) -> None:
        from ncmodel.export.files import check_output

        check_output(self.output)
        self._check_output(self.output.suffix.lower())
        _, record = self._draw(mesh, self.output)
        _tell_notes([record])
        emit(record, self.as_json)

    def _draw_folder(self, meshes: Sequence[Path]) -> None:
        """Every mesh to a file of its name, and all of them on a contact sheet; failures are told at the end."""
        from ncmodel.export.files import SUFFIXES
        from ncmodel.images import from_ink, shrink, write_png
        from ncmodel.report.contact_sheet import Tile, contact_sheet

        if f".{self.suffix}" not in SUFFIXES:
            expected = ", ".join(suffix.removeprefix(".") for suffix in SUFFIXES)
            raise UsageError(f"--format: found {self.suffix!r}, expected one of {expected}")
        self._check_output(f".{self.suffix}")
        if not self.output.is_dir() and (self.output.exists() or self.output.suffix.lower() in SUFFIXES):
            found = "is a file" if self.output.exists() else "is named like a file"
            raise UsageError(f"--output: {self.output} {found}, expected a folder")
        self.output.mkdir(parents=True, exist_ok=True)
        records, failed, sheet = [], [], []
        with progress("draw", len(meshes)) as advance:
            for mesh, name in zip(meshes, _names(meshes), strict=True):
                try:
                    drawing, record = self._draw(mesh, self.output / f"{name}.{self.suffix}")
                except (NeuralContoursError, OSError, MemoryError) as error:
                    reason = str(error) or f"{printable(mesh)}: {type(error).__name__}"
                    failed.append({"mesh": str(mesh), "error": reason})
                else:
                    records.append(record)
                    sheet.append(Tile(shrink(from_ink(drawing.ink(THUMBNAIL_WIDTH)), THUMBNAIL), name))
                advance(printable(mesh.name))
        columns, shown = max(1, math.ceil(math.sqrt(len(sheet)))), self.output / CONTACT_SHEET
        write_png(shown, contact_sheet(sheet, columns, THUMBNAIL))
        _tell_notes(records)
        emit({"drawings": records, "failed": failed, "contact_sheet": str(shown)}, self.as_json)
        if failed:
            reasons = "; ".join(failure["error"] for failure in failed)
            raise BatchError(f"{len(failed)} of {len(meshes)} meshes failed: {reasons}")


def chooser(asked: DrawOptions) -> Any:
    """The model that chooses what to draw, if there is one."""
    if asked.model is None:
        return None
    from ncmodel.nets.shipped import checkpoint_path

    path = checkpoint_path(asked.model)
    if not path.is_file():
        # Told without the seconds that it takes to import the networks.
        raise InputError(path, "no such file", "a checkpoint")
    from ncmodel.published.model import load_model

    return load_model(path, asked.mode, asked.device)  # type: ignore[arg-type]  # it checks


def _tell_notes(records: Sequence[dict[str, Any]]) -> None:
    for record in records:
        for note in record["notes"]:
            sys.stderr.write(f"{printable(record['mesh'])}: {note}\n")


def _names(meshes: Sequence[Path]) -> list[str]:
    """A file name for each mesh: its own, with a number where that is taken.

    Some file systems don't tell capital letters from small ones, or an accented letter from its two parts.
    """
    names: list[str] = []
    taken = {Path(CONTACT_SHEET).stem}
    for mesh in meshes:
        name, number = mesh.stem, 1
        while (key := unicodedata.normalize("NFC", name).casefold()) in taken:
            number += 1
            name = f"{mesh.stem}-{number}"
        taken.add(key)
        names.append(name)
    return names


def _record(mesh: Path, output: Path, drawing: "Drawing | Sheet", seconds: float) -> dict[str, Any]:
    """What `--json` says of a drawing."""
    plan, views = drawing.plan, getattr(drawing, "views", {})
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
    } | ({"views": {name: json.loads(camera.to_json()) for name, camera in views.items()}} if views else {})


def _finite(value: float | None) -> float | None:
    """The value, or None where JSON has no word for it."""
    return value if value is not None and math.isfinite(value) else None
