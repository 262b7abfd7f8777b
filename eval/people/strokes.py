"""Drawings that collections keep as strokes: JSON and SVG files in, ink out."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ncmodel.errors import InputError
from ncmodel.export.rasterize import draw_segments
from ncmodel.parsing import parse_json
from ncmodel.types import Floats, Image

CANVAS = 800
"""Pixels of a side of the canvas of DifferSketching and of Tracing versus Freehand, which their files don't state."""
LINE = 2.0
"""Width of a stroke, in pixels of a canvas of 800: what evaluation thins again."""

Parsed = TypeVar("Parsed")

_POLYLINE = re.compile(r"\s*[MLml\d.,eE+\-\s]*\s*")


@dataclass(frozen=True, eq=False)
class StrokeDrawing:
    """A drawing as it was drawn.

    Attributes:
        strokes: (n, 2) points u, v each, pixels of the canvas.
        width: Of the canvas, pixels.
        height: Of the canvas, pixels.
    """

    strokes: tuple[Floats, ...]
    width: int
    height: int

    def ink(self) -> Image:
        """(height, width) ink, 1 = line, all strokes full and of one width: pressure is left aside."""
        lines = [np.stack([stroke[:-1], stroke[1:]], axis=1) for stroke in self.strokes if len(stroke) > 1]
        segments = np.concatenate(lines) if lines else np.zeros((0, 2, 2))
        # A tap of the pen has no length, and none is drawn.
        width = LINE * max(self.width, self.height) / CANVAS
        return draw_segments(segments, np.ones((len(segments), 2)), max(1.0, width), (self.height, self.width))

    def itself(self) -> "StrokeDrawing":
        """These strokes, for who reads others from a file."""
        return self

    def shifted(self, by: Sequence[float], width: int, height: int) -> "StrokeDrawing":
        """The same on another canvas, moved."""
        return StrokeDrawing(tuple(stroke + np.asarray(by) for stroke in self.strokes), width, height)


def read_json(path: Path) -> Any:
    """What a JSON file of strokes holds.

    Raises:
        InputError: It can't be read or isn't JSON.
    """
    try:
        return parse_json(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise InputError(path, f"can't be read as JSON ({error})", "strokes in JSON") from error


def opensketch(path: Path) -> StrokeDrawing:
    """OpenSketch: `canvas` with width and height, `strokes` with `is_removed` and `points` of x and y."""

    def parse(record: Any) -> StrokeDrawing:
        kept = (stroke for stroke in record["strokes"] if not stroke["is_removed"])
        strokes = tuple(_points([[p["x"], p["y"]] for p in stroke["points"]]) for stroke in kept)
        return StrokeDrawing(strokes, int(record["canvas"]["width"]), int(record["canvas"]["height"]))

    return _parsed(path, parse, "canvas.width, canvas.height, strokes[].is_removed, strokes[].points[].x and y")


def differsketching(path: Path) -> StrokeDrawing:
    """DifferSketching: `strokes` with `path` of [x, y] on a canvas of 800; those of `draw_type` 1 draw nothing."""

    def parse(record: Any) -> StrokeDrawing:
        strokes = tuple(_points(stroke["path"]) for stroke in record["strokes"] if stroke["draw_type"] != 1)
        return StrokeDrawing(strokes, CANVAS, CANVAS)

    return _parsed(path, parse, "strokes[].draw_type and strokes[].path of [x, y]")


def tracing_freehand(path: Path) -> dict[str, dict[str, StrokeDrawing]]:
    """Tracing versus Freehand: image -> participant -> strokes whose `path` is a text "time,x,y,time,x,y..."."""

    def parse(record: Any) -> dict[str, dict[str, StrokeDrawing]]:
        return {image: {who: drawing(strokes) for who, strokes in of.items()} for image, of in record.items()}

    def drawing(strokes: Any) -> StrokeDrawing:
        texts = (stroke["path"] for stroke in strokes)
        points = (np.array([float(n) for n in text.split(",") if n.strip()]).reshape(-1, 3)[:, 1:] for text in texts)
        return StrokeDrawing(tuple(points), CANVAS, CANVAS)

    return _parsed(path, parse, '{"IMAGE": {"PARTICIPANT": [{"path": "time,x,y,..."}]}}')


def polylines_of_svg(path: Path) -> StrokeDrawing:
    """An SVG whose paths are polylines (M and L), as Tracing versus Freehand's are.

    Raises:
        InputError: It isn't SVG, states no size, or has curves.
    """
    expected = "an SVG with width, height and paths of straight pieces (M, L)"
    try:
        root = ET.parse(path).getroot()
        width, height = (int(float(root.attrib[name].removesuffix("px"))) for name in ("width", "height"))
    except (OSError, ET.ParseError, KeyError, ValueError) as error:
        raise InputError(path, f"can't be read ({error})", expected) from error
    strokes = []
    for element in root.iter("{http://www.w3.org/2000/svg}path"):
        text = element.attrib.get("d", "")
        if not _POLYLINE.fullmatch(text):
            raise InputError(path, f"a path with other pieces ({text[:40]})", expected)
        for part in re.split(r"[Mm]", text)[1:]:
            strokes.append(_points(np.array(re.findall(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?", part), float).reshape(-1, 2)))
    return StrokeDrawing(tuple(strokes), width, height)


def _points(values: Any) -> Floats:
    return np.asarray(values, dtype=np.float64).reshape(-1, 2)


def _parsed(path: Path, parse: Callable[[Any], Parsed], expected: str) -> Parsed:
    try:
        return parse(read_json(path))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(path, f"not such strokes ({type(error).__name__}: {error})", expected) from error
