"""From files to a camera file: a mesh and a drawing of it in, the camera, what it fits and a picture of both out."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from eval.measures.scans import read_lines
from eval.people.camera_fit import CameraFit, NoPoseError, fit_camera
from eval.people.outline import DrawnOutline, OpenOutlineError, drawn_outline, outermost
from ncmodel.camera import Camera
from ncmodel.errors import InputError
from ncmodel.images import Pixels, from_ink
from ncmodel.types import Image, Mesh

_OF_MESH, _DRAWN = (220, 40, 30), (30, 90, 220)
"""Red and blue of the two outlines in the picture of both."""

_CLOSED = "lines with a closed outline, gaps of up to 2 % of the picture's diagonal"


@dataclass(frozen=True, eq=False)
class FittedDrawing:
    """A drawing and the camera found for it.

    Attributes:
        ink: (H, W) the drawing.
        outline: Its outline.
        fit: The camera.
    """

    ink: Image
    outline: DrawnOutline
    fit: CameraFit

    @property
    def camera(self) -> Camera:
        """The camera, of the drawing's size."""
        return self.fit.camera

    def picture(self) -> Pixels:
        """(H, W, 3) the drawing in pale grey, its outline in blue, the mesh's through the camera in red over it."""
        pixels = np.repeat(from_ink(0.35 * self.ink)[..., None], 3, axis=2)
        cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
        for region, colour in ((self.outline.region, _DRAWN), (self.fit.seen.region, _OF_MESH)):
            rim = outermost(region)
            rim = cv2.dilate(rim.astype(np.uint8), cross) > 0 if colour is _DRAWN else rim
            pixels[rim] = colour
        return pixels

    def notes(self) -> tuple[str, ...]:
        """What the reader should know about how the camera was found."""
        notes = []
        if self.outline.closed > 0.0:
            notes.append(f"gaps of up to {self.outline.closed:.0f} pixels in the drawing's outline were closed")
        if self.fit.rivals:
            told = "told apart by the lines inside"
            notes.append(f"{self.fit.rivals} other views have nearly the same outline; {told}")
        if not self.fit.seen.whole:
            notes.append("the mesh reaches over the frame in what was found")
        return tuple(notes)

    def to_record(self) -> dict[str, Any]:
        """What was found, for JSON."""
        return {
            "outline_distance": round(self.fit.outline_distance, 3),
            "overlap": round(self.fit.overlap, 4),
            "starts": self.fit.starts,
            "rivals": self.fit.rivals,
            "notes": list(self.notes()),
        }


def fit_drawing(
    mesh: Mesh, drawing: Path, focal_pixels: float | None = None, ink: Image | None = None
) -> FittedDrawing:
    """Find the camera of a drawing.

    Args:
        mesh: What it shows, in object space.
        drawing: A picture: lines on paper.
        focal_pixels: The focal length if it is known.
        ink: (H, W) what is in the file, if it has been read and is no picture: strokes.

    Raises:
        InputError: The picture can't be read or isn't lines on paper, its outline isn't closed, or no pose fits it.
    """
    ink = read_lines(drawing) if ink is None else ink
    try:
        outline = drawn_outline(ink)
    except OpenOutlineError as error:
        raise InputError(drawing, str(error), _CLOSED) from error
    try:
        return FittedDrawing(ink, outline, fit_camera(mesh, ink, outline, focal_pixels))
    except NoPoseError as error:
        raise InputError(drawing, str(error), f"a drawing of {mesh.name} with nothing beside it") from error
