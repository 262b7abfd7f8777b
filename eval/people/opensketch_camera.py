"""OpenSketch's cameras as ours.

A file DESIGNER_OBJECT_viewN_camparam.json has `restricted`: eye `C`, focal length `f` and principal point `u`, `v` in
units of half the canvas, +y upwards, and `mvMatrix`, OpenGL's model-view matrix column by column, all in the object
file's own coordinates. Public pages don't state these conventions; where the points that were marked by hand are beside
it (DESIGNER_OBJECT_vN_points.json), the camera is held against them, and one that isn't theirs is refused.

Our cameras look through the middle of the picture: the canvas is widened until the principal point is there.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from eval.people.poses import Pose
from eval.people.strokes import StrokeDrawing, read_json
from ncmodel.camera import Camera
from ncmodel.errors import InputError
from ncmodel.mesh.load import read_geometry
from ncmodel.types import Floats

MOST_OFF = 0.1
"""Share of the canvas that marked points may be off in the mean: designers err, other conventions err more."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A sketch on a canvas whose middle is the camera's principal point."""

    drawing: StrokeDrawing
    camera: Camera


def camera_file(source: Path, designer: str, shape: str, number: str) -> Path:
    """Where a sketch's camera is.

    Raises:
        InputError: There is none.
    """
    name = f"{designer}_{shape}_view{number}_camparam.json".lower()
    for path in sorted(source.rglob("*_camparam.json")):
        if path.name.lower() == name:
            return path
    raise InputError(source, f"no {name} in it", "OpenSketch's camera parameters, or cameras that are fitted")


def placed(drawing: StrokeDrawing, path: Path, mesh: Path) -> Placed:
    """A sketch and its camera, in the object space of its mesh.

    Raises:
        InputError: The camera can't be read, or isn't the one that the marked points tell.
    """
    record = read_json(path)
    expected = "restricted.C, f, u, v and mvMatrix of 4 x 4"
    try:
        found = record["restricted"]
        eye = np.asarray(found["C"], dtype=np.float64).reshape(3)
        turn = np.asarray(found["mvMatrix"], dtype=np.float64).reshape(4, 4).T[:3, :3]
        f, u, v = (float(found[key]) for key in "fuv")
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(path, f"not such a camera ({type(error).__name__}: {error})", expected) from error
    half = drawing.width / 2
    principal = np.array([(1 + u) * half, drawing.height / 2 - v * half])
    reach = np.maximum(principal, [drawing.width - principal[0], drawing.height - principal[1]])
    width, height = (2 * math.ceil(side) for side in reach)
    moved = drawing.shifted(np.array([width, height]) / 2 - principal, width, height)
    centre, size = _box(mesh)
    at = (eye - centre) / size
    x, y, z = turn @ -at
    if not -z > 0.0:
        raise InputError(path, "a camera that looks away from the object", expected)
    pose = Pose(turn, x * f * half / -z, -y * f * half / -z, f * half / -z, -z)
    camera = pose.camera(width, height)
    _check(path, camera, principal, (centre, size), drawing)
    return Placed(moved, camera)


def _box(mesh: Path) -> tuple[Floats, float]:
    """The middle of a mesh file's bounding box and its longest side: what object space undoes."""
    vertices, faces = read_geometry(mesh)
    used = vertices[np.unique(faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    return (low + high) / 2, float((high - low).max())


def _check(path: Path, camera: Camera, principal: Floats, box: tuple[Floats, float], drawing: StrokeDrawing) -> None:
    """Hold a camera against the points that were marked on sketch and object."""
    marks = path.name.replace("_camparam.json", "_points.json").replace("_view", "_v").lower()
    root = path.parent.parent
    for beside in sorted(root.rglob("*_points.json")):
        if beside.name.lower() == marks:
            record = read_json(beside)
            sketch = np.asarray(record["points_2D_sketch"], dtype=np.float64)
            points = (np.asarray(record["points_3D_object"], dtype=np.float64) - box[0]) / box[1]
            shift = np.array([camera.width, camera.height]) / 2 - principal
            away = float(np.linalg.norm(camera.project(points)[:, :2] - shift - sketch, axis=1).mean())
            if away > MOST_OFF * drawing.width:
                found = f"marked points are {away:.0f} pixels off in the mean"
                raise InputError(path, found, f"at most {MOST_OFF * drawing.width:.0f}: another convention; fit them")
