"""From a shape to its drawing: the one entry function, and the drawing that it returns.

Only what a request needs is computed: contours need no curvature, a family that isn't asked for costs nothing, and
lines are thresholded before their visibility is decided.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from ncmodel import export
from ncmodel.camera import DEFAULT_SIZE, Camera
from ncmodel.errors import InputError, UsageError
from ncmodel.export import REFERENCE_SIDE, WIDTH, Picture
from ncmodel.fade import check_thresholds, fade, survivors
from ncmodel.stages import timed
from ncmodel.types import FILTERED_FAMILIES, Floats, Image, LineFamily, Mask, Mesh, Segments, Stroke, Thresholds, Trace

if TYPE_CHECKING:
    from ncmodel.geometry.surface import Surface
    from ncmodel.geometry.view import View

DEFAULT_FAMILIES = tuple(LineFamily)
CREASE_ANGLE = 40.0
"""Degrees between faces above which their edge is drawn as a crease, unless told otherwise."""
CREASE_EDGES = 6
CREASE_LENGTH = 0.05
"""Connected creases of fewer edges than `CREASE_EDGES`, and shorter than this share of the object, are roughness."""
SHORTEST_STROKE = 2.5
"""Strokes of filtered families shorter than this, in pixels at 768, are dots and not drawn."""
SUFFIXES = (".svg", ".png", ".pdf")
"""The file formats that a drawing is written in."""


@dataclass(frozen=True)
class Detail:
    """How finely a drawing is worked out.

    Attributes:
        sample_pixels: Distance along the picture of the points at which visibility is decided.
        tolerance: Pixels that strokes may stray from the lines on the mesh.
    """

    sample_pixels: float = 1.0
    tolerance: float = 0.25


BALANCED = Detail()
PRESETS = {"draft": Detail(4.0, 0.5), "balanced": BALANCED, "accurate": Detail(0.5, 0.05)}


@dataclass(frozen=True, eq=False)
class Drawing:
    """Strokes on a picture plane; shows itself in a notebook.

    Attributes:
        camera: What it was drawn through, and its size.
        strokes: The lines.
        name: The shape's name.
        thresholds: Those it was drawn with.
        families: The families asked for, empty ones included.
        notes: What the reader should know about how it came to be.
        trace: What was computed, and how long it took.
    """

    camera: Camera
    strokes: tuple[Stroke, ...]
    name: str = "drawing"
    thresholds: Thresholds = field(default_factory=Thresholds)
    families: tuple[LineFamily, ...] = ()
    notes: tuple[str, ...] = ()
    trace: Trace = field(default_factory=Trace)

    @property
    def width(self) -> int:
        """Pixels."""
        return self.camera.width

    @property
    def height(self) -> int:
        """Pixels."""
        return self.camera.height

    def ink(self, width: float = WIDTH) -> Image:
        """(H, W) ink in [0, 1].

        Args:
            width: Line width, in pixels of a picture whose shorter side is 768; lines grow with the picture.
        """
        return export.ink(self.picture(width))

    def svg(self, width: float = WIDTH, background: str | None = None) -> str:
        """The drawing as an SVG document; arguments as for `save`."""
        return export.svg(self.picture(width, background))

    def save(self, path: str | Path, width: float = WIDTH, background: str | None = None) -> None:
        """Write an .svg, .png or .pdf file.

        Args:
            path: Where to; the suffix says in which format.
            width: Line width, in pixels of a picture whose shorter side is 768; lines grow with the picture.
            background: "#rrggbb", "white", "black" or "transparent"; None paints none in vector files, white in PNG.

        Raises:
            UsageError: The suffix, the width or the background is something else.
            InputError: There is no such folder.
        """
        from ncmodel import export
        from ncmodel.files import write_bytes

        check_output(path)
        writers = {".svg": lambda p: export.svg(p).encode(), ".png": export.png, ".pdf": export.pdf}
        write_bytes(path, writers[Path(path).suffix.lower()](self.picture(width, background)))

    def picture(self, width: float = WIDTH, background: str | None = None) -> Picture:
        """The strokes with a line width and a background."""
        return Picture(self.width, self.height, self.strokes, width, background, self.name)

    def sorted_for_pen(self) -> Self:
        """The same drawing with each family's strokes in an order that keeps the pen's way in the air short."""
        from ncmodel.geometry.strokes import pen_order

        families = dict.fromkeys(stroke.family for stroke in self.strokes)
        ordered = [pen_order([s for s in self.strokes if s.family == family]) for family in families]
        return replace(self, strokes=tuple(stroke for strokes in ordered for stroke in strokes))

    def _repr_svg_(self) -> str:
        return self.svg()


def check_output(path: str | Path) -> None:
    """Raise if no drawing can be written there.

    Raises:
        UsageError: The suffix is none of `SUFFIXES`.
        InputError: There is no such folder.
    """
    if Path(path).suffix.lower() not in SUFFIXES:
        raise UsageError(f"{path}: the suffix is {Path(path).suffix!r}, expected {', '.join(SUFFIXES)}")
    if not Path(path).parent.is_dir():
        raise InputError(path, f"there is no folder {Path(path).parent}", "a folder that exists")


def draw(
    shape: "Mesh | Surface | str | Path",
    camera: Camera | None = None,
    lines: Iterable[LineFamily | str] = DEFAULT_FAMILIES,
    thresholds: Thresholds | None = None,
    *,
    size: tuple[int, int] = (DEFAULT_SIZE, DEFAULT_SIZE),
    up: str = "y",
    crease_angle: float = CREASE_ANGLE,
    detail: Detail = BALANCED,
) -> Drawing:
    """Draw a shape's lines.

    Args:
        shape: A mesh file, a mesh, or a surface whose computed quantities are to be reused.
        camera: Where from; by default one that looks down on the shape from the front right, with the shape in frame.
        lines: Families to draw; those whose threshold is None are left out.
        thresholds: rtsc's defaults unless given.
        size: (width, height) in pixels, for the default camera.
        up: The upward axis, "y" or "z", of a mesh file.
        crease_angle: Degrees between faces above which their edge is a crease.
        detail: How finely.

    Raises:
        MeshError: The file can't be read.
        UsageError: A family, threshold or size makes no sense.
    """
    from ncmodel.geometry.sharp import parted
    from ncmodel.geometry.strokes import strokes
    from ncmodel.geometry.view import View

    thresholds = thresholds if thresholds is not None else Thresholds()
    check_thresholds(thresholds)
    families = tuple(f for f in dict.fromkeys(map(_family, lines)) if thresholds.of(f) is not None)
    surface = _surface(shape, up)
    if LineFamily.CREASES in families:
        surface = parted(surface, crease_angle)
    camera = camera if camera is not None else Camera.orbit(surface.mesh.vertices, size=size)
    view = View(surface, camera, crease_angle)
    drawn: list[Stroke] = []
    for family in families:
        segments = visible_segments(view, family, thresholds, detail)
        with timed(surface.trace, "strokes"):
            least = SHORTEST_STROKE * min(camera.width, camera.height) / REFERENCE_SIDE
            least = least if family in FILTERED_FAMILIES else 0.0
            drawn += strokes(segments, camera, detail.tolerance, least)
    mesh = surface.mesh
    return Drawing(view.camera, tuple(drawn), mesh.name, thresholds, families, mesh.notes, surface.trace)


def visible_segments(view: "View", family: LineFamily, thresholds: Thresholds, detail: Detail = BALANCED) -> Segments:
    """The visible segments of a family that its threshold leaves, with their opacity."""
    threshold, unit = thresholds.of(family) or 0.0, thresholds.unit
    p90 = _percentile(view, family) if family in FILTERED_FAMILIES and unit == "p90" else 1.0
    lines = view.candidates(family)
    if family is LineFamily.CREASES:
        lines = lines.take(_long(lines.points))
    # Weak lines are the most numerous; what the threshold takes away needs no rays.
    strong = lines.take(survivors(lines, threshold, unit, p90))
    return fade(view.unhidden(strong, detail.sample_pixels), threshold, unit, p90)


def _long(creases: Floats) -> Mask:
    """(S,) True for (S, 2, 3) creases that are connected to enough others to be a line and not a rough spot."""
    from ncmodel.geometry.strokes import connected

    run = connected(creases)
    length = np.bincount(run, np.linalg.norm(creases[:, 1] - creases[:, 0], axis=1))
    return np.asarray((np.bincount(run)[run] >= CREASE_EDGES) | (length[run] >= CREASE_LENGTH))


def _percentile(view: "View", family: LineFamily) -> float:
    from ncmodel.maps import feature_percentile

    return feature_percentile(view, family)


def _family(name: LineFamily | str) -> LineFamily:
    try:
        return LineFamily(name)
    except ValueError:
        raise UsageError(f"lines: unknown family {name!r}, expected some of {', '.join(LineFamily)}") from None


def _surface(shape: "Mesh | Surface | str | Path", up: str) -> "Surface":
    from ncmodel.geometry.surface import Surface

    if isinstance(shape, Surface):
        return shape
    if isinstance(shape, Mesh):
        return Surface(shape)
    from ncmodel.geometry.mesh import load_mesh

    trace = Trace()
    with timed(trace, "load"):
        mesh = load_mesh(shape, up)
    return Surface(mesh, trace)
