"""How well cameras are found: ten drawings of made shapes whose cameras are known, some drawn by an unsteady hand.

`python -m eval.people.camera_study` prints the table of docs/measurements.md.
"""

import math
import sys
import time
from dataclasses import dataclass

import cv2
import numpy as np

from dataset_tools.collection.families import make_shape
from eval.people.camera_fit import CameraFit, fit_camera
from eval.people.outline import drawn_outline
from eval.people.poses import Pose
from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.mesh.load import make_mesh
from ncmodel.types import Floats, Image


@dataclass(frozen=True)
class Case:
    """A drawing whose camera is known.

    Attributes:
        shape: A made shape's name.
        azimuth: Degrees.
        elevation: Degrees.
        distance: From the eye to the shape's middle.
        size: (width, height) pixels.
        target: What the camera looks at: the shape needn't be in the middle.
        wobble: Typical distance of a line from where it should be, pixels; 0 is our drawing as it is.
        turned: Whether the shape is a body of revolution, whose azimuth no drawing tells.
    """

    shape: str
    azimuth: float
    elevation: float
    distance: float = 3.0
    size: tuple[int, int] = (768, 768)
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    wobble: float = 0.0
    turned: bool = False


CASES = (
    Case("quadruped_1", 40.0, 20.0),
    Case("bird_2", -60.0, 15.0, wobble=1.5),
    Case("chair_3", 25.0, 30.0),
    Case("aircraft_4", 130.0, 35.0, distance=2.2),
    Case("head_5", 70.0, -10.0, wobble=1.5),
    Case("tool_6", -20.0, 40.0, size=(1024, 768)),
    Case("insect_7", 200.0, 25.0, distance=4.0, wobble=1.0),
    Case("sofa_8", -35.0, 10.0, size=(440, 340)),
    Case("character_9", 10.0, 5.0, target=(0.1, 0.05, 0.0), wobble=1.5),
    Case("vase_10", 50.0, 25.0, turned=True),
)


@dataclass(frozen=True, eq=False)
class Recovery:
    """How well a case's camera was found.

    Attributes:
        case: The case.
        fit: What was found.
        angle: Degrees between the rotations.
        direction: Degrees between the directions that the shape is seen from.
        size: Relative error of how large the shape is seen: focal length / distance.
        focal: Relative error of the focal length.
        shift: Pixels between the places where the shape's middle is seen.
        seconds: On the clock.
    """

    case: Case
    fit: CameraFit
    angle: float
    direction: float
    size: float
    focal: float
    shift: float
    seconds: float


def recover(case: Case, seed: int = 0) -> Recovery:
    """Draw a case, forget its camera and find it."""
    made = make_shape(case.shape)
    mesh = make_mesh(made.vertices, made.faces, made.name)
    hidden = Camera.orbit(mesh.used_vertices, case.azimuth, case.elevation, case.distance, case.size, case.target)
    ink = unsteady(draw(mesh, camera=hidden).ink(), case.wobble, np.random.default_rng(seed))
    begin = time.perf_counter()
    fit = fit_camera(mesh, ink, drawn_outline(ink))
    seconds = time.perf_counter() - begin
    true, found = Pose.of(hidden), Pose.of(fit.camera)
    ways = [np.asarray(camera.eye) / np.linalg.norm(camera.eye) for camera in (hidden, fit.camera)]
    return Recovery(
        case,
        fit,
        math.degrees(true.angle_to(found)),
        math.degrees(math.acos(min(1.0, float(ways[0] @ ways[1])))),
        found.size / true.size - 1.0,
        fit.camera.focal_pixels / hidden.focal_pixels - 1.0,
        math.hypot(found.u - true.u, found.v - true.v),
        seconds,
    )


def unsteady(ink: Image, wobble: float, rng: np.random.Generator) -> Image:
    """A drawing whose lines wander by about `wobble` pixels, slowly and less slowly."""
    if wobble == 0.0:
        return ink
    height, width = ink.shape
    field: Floats = np.zeros((height, width, 2))
    for nodes, share in ((5, 0.7), (24, 0.7)):
        coarse = rng.normal(0.0, share * wobble, (nodes, nodes, 2)).astype(np.float32)
        field += cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    places = np.stack([columns, rows], axis=2).astype(np.float32) + field.astype(np.float32)
    return np.asarray(cv2.remap(ink.astype(np.float32), places[..., 0], places[..., 1], cv2.INTER_LINEAR))


def row_of(recovery: Recovery) -> list[str]:
    """A case's row of the table."""
    case, fit = recovery.case, recovery.fit
    angle = f"{recovery.angle:.2f}°" if not case.turned else "any"
    errors = [f"{100 * recovery.size:+.2f} %", f"{100 * recovery.focal:+.2f} %", f"{recovery.shift:.2f} px"]
    seen_from = f"{case.azimuth:g}°, {case.elevation:g}°, {case.distance:g}"
    fitted = [f"{fit.outline_distance:.2f} px", f"{fit.overlap:.3f}", f"{recovery.seconds:.0f}"]
    return [case.shape, seen_from, f"{case.wobble:g} px", angle, *errors, *fitted]


HEADER = ["shape", "seen from", "wobble", "angle", "size", "focal length", "shift", "outline", "overlap", "seconds"]

if __name__ == "__main__":
    names = sys.argv[1:]
    for row in (HEADER, ["---"] * len(HEADER)):
        print(f"| {' | '.join(row)} |")  # noqa: T201
    for case in CASES:
        if not names or case.shape in names:
            print(f"| {' | '.join(row_of(recover(case)))} |", flush=True)  # noqa: T201
