"""Strokes as data: what each is, how strong, and where on the picture and in space."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ncmodel.camera import Camera
from ncmodel.types import Floats, Stroke


@dataclass(frozen=True, eq=False)
class StrokeData:
    """A stroke of n points.

    Attributes:
        family: Its family; "image" for lines of a model's image branch.
        hidden: Whether it lies behind the surface.
        strength: Mean opacity along it, in [0, 1]: how far it is above its family's threshold.
        length: Pixels.
        points: (n, 2) pixels, u right and v down.
        opacity: (n,) in [0, 1].
        depth: (n,) distance in front of the camera plane; None for lines that don't come from the mesh.
        position: (n, 3) in object space, likewise.
    """

    family: str
    hidden: bool
    strength: float
    length: float
    points: Floats
    opacity: Floats
    depth: Floats | None
    position: Floats | None


def stroke_data(strokes: Sequence[Stroke], camera: Camera) -> list[StrokeData]:
    """The data of strokes that were seen through a camera."""
    return [_data(stroke, camera) for stroke in strokes]


def _data(stroke: Stroke, camera: Camera) -> StrokeData:
    steps = np.linalg.norm(np.diff(stroke.points, axis=0), axis=1)
    length = float(steps.sum())
    ink = float(steps @ (stroke.alpha[1:] + stroke.alpha[:-1]) / 2.0)
    depth, position = stroke.depth, None
    if depth is not None:
        position = camera.rays(stroke.points).at(depth)
    strength = ink / length if length > 0.0 else float(stroke.alpha.mean())
    return StrokeData(stroke.family, stroke.hidden, strength, length, stroke.points, stroke.alpha, depth, position)


def strokes_json(name: str, strokes: Sequence[Stroke], camera: Camera) -> str:
    """A JSON object: the shape's name, the camera, and the strokes, one a line."""
    lines = ",\n".join(json.dumps(_plain(data)) for data in stroke_data(strokes, camera))
    head = f'"shape": {json.dumps(name)},\n"camera": {json.dumps(json.loads(camera.to_json()))}'
    return f'{{\n{head},\n"strokes": [\n{lines}\n]\n}}\n'


_DIGITS = {"strength": 4, "length": 2, "points": 2, "opacity": 4, "depth": 6, "position": 6}


def _plain(data: StrokeData) -> dict[str, Any]:
    """The values as JSON has them, rounded to hundredths of a pixel and millionths of the shape."""
    plain = asdict(data)
    for key, digits in _DIGITS.items():
        if plain[key] is not None:
            plain[key] = np.round(plain[key], digits).tolist()
    return plain
