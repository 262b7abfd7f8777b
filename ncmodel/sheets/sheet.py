"""Drawings of one shape on a sheet, at a common scale."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np

from ncmodel.camera import (
    DEFAULT_AZIMUTH,
    DEFAULT_ELEVATION,
    FRAME_MARGIN,
    MAX_SIDE,
    ORTHOGRAPHIC,
    PERSPECTIVE,
    VIEWS,
    Camera,
)
from ncmodel.drawing.draw import draw
from ncmodel.drawing.drawing import Drawing
from ncmodel.drawing.plan import Plan
from ncmodel.errors import ArgumentError
from ncmodel.export.files import write_picture
from ncmodel.export.page import MILLIMETRES, WIDTH, Label, Picture, page_scale
from ncmodel.export.png import ink
from ncmodel.scene.prepared import hints, surface_of
from ncmodel.sheets.arrangement import LABEL, VIEW_SIDE, Arrangement, Cell, places
from ncmodel.sheets.paper import Paper
from ncmodel.types import Floats, Image, Mesh, Stroke, Trace


@dataclass(frozen=True)
class Layout:
    """What is on a sheet, and how large.

    Attributes:
        views: Names of `VIEWS`; none for one view without a label.
        angle: "third" or "first".
        size: (width, height) in pixels; as large as it needs by default.
        paper: In place of `size`.
        scale: Length on that paper of what is 1 long; as large as fits by default.

    Raises:
        ArgumentError: A view or the angle is unknown, the size is absurd, or there is a scale and no paper.
    """

    views: tuple[str, ...] = ()
    angle: str = "third"
    size: tuple[int, int] | None = None
    paper: Paper | None = None
    scale: float | None = None

    def __post_init__(self) -> None:
        places(self.views, self.angle)
        if self.size is not None and not all(1 <= side <= MAX_SIDE for side in self.size):
            found = f"{self.size[0]} x {self.size[1]}"
            raise ArgumentError("size", found, f"sides in 1..{MAX_SIDE} pixels")
        if self.scale is not None and self.paper is None:
            raise ArgumentError("scale", "no page beside it", "both")


@dataclass(frozen=True, eq=False)
class Sheet:
    """Drawings on one page.

    Attributes:
        width: Pixels.
        height: Likewise.
        drawings: Of the views.
        corners: (n, 2) where each has its upper left corner.
        labels: The views' names.
        physical: Whether the page has a size on paper.
        notes: What the reader should know of how it came to be.
    """

    width: float
    height: float
    drawings: tuple[Drawing, ...]
    corners: Floats
    labels: tuple[Label, ...] = ()
    physical: bool = False
    notes: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The shape's name."""
        return self.drawings[0].name

    @property
    def plan(self) -> Plan:
        """What the first view shows; with a model, others may show something else."""
        return self.drawings[0].plan

    @property
    def camera(self) -> Camera:
        """The first view's."""
        return self.drawings[0].camera

    @property
    def views(self) -> dict[str, Camera]:
        """Name -> camera of those that have one."""
        parts = zip(self.labels, self.drawings, strict=False)
        return {label.text: drawing.camera for label, drawing in parts}

    @property
    def trace(self) -> Trace:
        """What was computed, and how long it took."""
        return self.drawings[0].trace

    def sorted_for_pen(self) -> Self:
        """The same sheet with each view's strokes in an order that keeps the pen's way in the air short."""
        return replace(self, drawings=tuple(drawing.sorted_for_pen() for drawing in self.drawings))

    @cached_property
    def strokes(self) -> tuple[Stroke, ...]:
        """The lines of all views, in the sheet's pixels."""
        parts = zip(self.drawings, self.corners.tolist(), strict=True)
        return tuple(stroke.moved(right, down) for drawing, (right, down) in parts for stroke in drawing.strokes)

    def picture(
        self, width: float = WIDTH, background: str | None = None, colors: bool = False, curve: float = 0.0
    ) -> Picture:
        """The page, with lines as wide as each view has them in a picture of its own; arguments as for `save`."""
        first = self.drawings[0]
        wide = width * page_scale(first.width, first.height) / page_scale(self.width, self.height)
        return Picture(
            self.width,
            self.height,
            self.strokes,
            wide,
            background,
            title=self.name,
            solid=self.plan.hidden == "layer",
            colours=colors,
            curve=curve,
            physical=self.physical,
            labels=self.labels,
        )

    def ink(self, width: float = WIDTH) -> Image:
        """(H, W) ink in [0, 1]."""
        return ink(self.picture(width))

    def save(
        self,
        path: str | Path,
        width: float = WIDTH,
        background: str | None = None,
        *,
        colors: bool = False,
        curve: float = 0.0,
    ) -> None:
        """Write an .svg, .png, .pdf or .dxf file.

        Args:
            path: Where to; the suffix says in which format. A page of paper isn't written as pixels.
            width: Line width of each view, in pixels of a picture of it whose shorter side is 768.
            background: As `Drawing.save` takes it.
            colors: Likewise.
            curve: Likewise.

        Raises:
            UsageError: As of `Drawing.save`.
            InputError: There is no such folder.
        """
        write_picture(path, self.picture(width, background, colors, curve))


def draw_sheet(
    shape: Any,
    layout: Layout,
    *,
    camera: Camera | None = None,
    azimuth: float = DEFAULT_AZIMUTH,
    elevation: float = DEFAULT_ELEVATION,
    projection: str | None = None,
    up: str = "y",
    **how: Any,
) -> Sheet:
    """Draw views of a shape onto a sheet; what doesn't depend on the view is computed once.

    Args:
        shape: As `draw` takes it.
        layout: Which views, and how large.
        camera: The one view, where the layout names none; its frame becomes what the page shows.
        azimuth: Of that view, without a camera; degrees.
        elevation: Likewise.
        projection: By default orthographic for named views, perspective for others.
        up: As `draw` takes it.
        how: What else `draw` takes.

    Raises:
        MeshError: The shape can't be read.
        ArgumentError: What it shows doesn't fit the page at its scale, or its size isn't known.
        UsageError: Some argument makes no sense.
    """
    if camera is not None:
        projection = camera.projection
    projection = projection or (ORTHOGRAPHIC if layout.views else PERSPECTIVE)
    if layout.scale is not None and projection != ORTHOGRAPHIC:
        raise ArgumentError("scale", "a perspective view, whose sizes depend on the distance", "an orthographic one")
    surface = surface_of(shape, up, None if camera is None else camera.eye)
    if camera is not None:
        reach = camera.width / 2, camera.height / 2
        cells: tuple[Cell, ...] = (Cell("", camera, (-reach[0], -reach[1], *reach)),)
    else:
        angles = {name: VIEWS[name] for name in layout.views} or {"": (azimuth, elevation)}
        cells = _cells(surface.mesh.used_vertices, angles, places(layout.views, layout.angle), projection)
    arrangement = Arrangement(cells)
    factor, (width, height) = _scaled(arrangement, layout, surface.mesh)
    drawings = tuple(draw(surface, _magnified(cell.camera, factor), **how) for cell in cells)
    left, top = ((side - factor * needed) / 2 for side, needed in zip((width, height), arrangement.size, strict=True))
    middles = np.array([arrangement.middle(cell) for cell in cells])
    corners = factor * middles + (left, top) - [(d.width / 2, d.height / 2) for d in drawings]
    feet = [(cell.name, arrangement.foot(cell)) for cell in cells if cell.name]
    labels = tuple(Label(name, (factor * u + left, factor * v + top), factor * LABEL) for name, (u, v) in feet)
    notes = drawings[0].notes + (() if camera is not None else hints(surface, shape, up))
    return Sheet(width, height, drawings, corners, labels, layout.paper is not None, notes)


def _cells(
    vertices: Floats, angles: dict[str, tuple[float, float]], at: dict[str, tuple[int, int]], projection: str
) -> tuple[Cell, ...]:
    """The views at the largest common scale at which each fits its frame."""
    side = (VIEW_SIDE, VIEW_SIDE)
    cameras = {name: Camera.orbit(vertices, *turn, size=side, projection=projection) for name, turn in angles.items()}
    common = min(camera.focal_pixels for camera in cameras.values())
    cells = []
    for name, camera in cameras.items():
        placed = camera.zoomed(common)
        reach = placed.project(vertices)[:, :2] - VIEW_SIDE / 2
        (left, top), (right, bottom) = reach.min(axis=0).tolist(), reach.max(axis=0).tolist()
        cells.append(Cell(name, placed, (left, top, right, bottom), *at.get(name, (0, 0))))
    return tuple(cells)


def _scaled(arrangement: Arrangement, layout: Layout, mesh: Mesh) -> tuple[float, tuple[float, float]]:
    """How much larger the arrangement is drawn, and the page's width and height, pixels."""
    needed = arrangement.size
    if layout.paper is None:
        if layout.size is None:
            border = 2.0 * FRAME_MARGIN * VIEW_SIDE
            return 1.0, (math.ceil(needed[0] + border), math.ceil(needed[1] + border))
        border = 2.0 * FRAME_MARGIN * min(layout.size)
        return min((side - border) / need for side, need in zip(layout.size, needed, strict=True)), layout.size
    paper = layout.paper
    room = tuple(side / MILLIMETRES for side in paper.inside)
    page = paper.width / MILLIMETRES, paper.height / MILLIMETRES
    largest = min(side / need for side, need in zip(room, needed, strict=True))
    if layout.scale is None:
        return largest, page
    if mesh.millimetres is None:
        raise ArgumentError("scale", "a shape of unknown size", "one that was read from a file")
    per_unit = mesh.millimetres * layout.scale / MILLIMETRES
    factor = per_unit / arrangement.cells[0].camera.focal_pixels
    if factor > largest * (1.0 + 1e-9):
        found, fitting = (
            " x ".join(f"{side * MILLIMETRES:.4g}" for side in sides)
            for sides in ([factor * need for need in needed], room)
        )
        raise ArgumentError("scale", f"a drawing of {found} mm", f"at most {fitting} mm, the page within its margins")
    return factor, page


def _magnified(camera: Camera, factor: float) -> Camera:
    """The same view, larger, in a frame of whole pixels."""
    width, height = (max(1, round(factor * side)) for side in (camera.width, camera.height))
    return camera.resized(width, height).zoomed(factor * camera.focal_pixels)
