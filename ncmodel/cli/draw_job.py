"""What `ncontours draw` does with meshes: one to a file, several to a folder."""

import json
import math
import sys
import time
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ncmodel.cli.common import emit, progress
from ncmodel.cli.draw_options import DrawOptions
from ncmodel.errors import BatchError, InputError, NeuralContoursError, UsageError, printable

if TYPE_CHECKING:
    from ncmodel.camera import Camera
    from ncmodel.drawing.drawing import Drawing

CONTACT_SHEET = "contact-sheet.png"
THUMBNAIL = 256
"""Longest side of a drawing on the contact sheet, pixels."""
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
    """

    options: DrawOptions
    output: Path
    suffix: str
    as_json: bool

    def __post_init__(self) -> None:
        from ncmodel.drawing.arguments import plan_of
        from ncmodel.export.page import WIDTH, Picture

        asked = self.options
        plan_of(asked.lines, asked.thresholds, asked.detail, asked.min_length, asked.hidden)
        Picture(1, 1, (), self.style.get("width", WIDTH), asked.background)
        # Read now: what is wrong with them is wrong with every mesh.
        _ = self.camera, self.how

    @cached_property
    def style(self) -> dict[str, Any]:
        """How `Drawing.save` writes."""
        width = self.options.width
        return {"background": self.options.background} | ({} if width is None else {"width": width})

    @cached_property
    def how(self) -> dict[str, Any]:
        """How `draw` draws, but for the camera."""
        asked = self.options
        azimuth, elevation = asked.angles
        given = {
            "azimuth": azimuth,
            "elevation": elevation,
            "size": asked.size,
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
            "tolerance": asked.tolerance,
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
        if asked.camera is None:
            return None
        camera = Camera.load(asked.camera)
        camera = camera if asked.projection is None else camera.projected(asked.projection)
        return camera if asked.size is None else camera.resized(*size_of(asked.size))

    def run(self, meshes: Sequence[Path], folder: bool) -> None:
        """Draw them: to a folder, or one to the output."""
        if folder:
            self._draw_folder(meshes)
        else:
            self._draw_file(meshes[0])

    def _draw(self, mesh: Path, output: Path) -> tuple["Drawing", dict[str, Any]]:
        """Draw one mesh to a file; the drawing, and its record for `--json`."""
        from ncmodel.drawing.draw import draw
        from ncmodel.tracing import timed

        begin = time.perf_counter()
        drawing = draw(mesh, self.camera, **self.how)
        with timed(drawing.trace, "write"):
            drawing = drawing.sorted_for_pen() if self.options.sort else drawing
            drawing.save(output, **self.style)
        return drawing, _record(mesh, output, drawing, time.perf_counter() - begin)

    def _draw_file(self, mesh: Path) -> None:
        from ncmodel.drawing.drawing import check_output

        check_output(self.output)
        _, record = self._draw(mesh, self.output)
        _tell_notes([record])
        emit(record, self.as_json)

    def _draw_folder(self, meshes: Sequence[Path]) -> None:
        """Every mesh to a file of its name, and all of them on a contact sheet; failures are told at the end."""
        from ncmodel.drawing.drawing import SUFFIXES
        from ncmodel.images import from_ink, shrink, write_png
        from ncmodel.report.contact_sheet import Tile, contact_sheet

        if f".{self.suffix}" not in SUFFIXES:
            expected = ", ".join(suffix.removeprefix(".") for suffix in SUFFIXES)
            raise UsageError(f"--format: found {self.suffix!r}, expected one of {expected}")
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
