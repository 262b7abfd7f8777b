"""Scores of drawings that somebody made of a shape, whoever and however."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ncmodel.camera import Camera
from ncmodel.drawing.drawing import Drawing
from ncmodel.drawing.settings import Levels, draw_layers
from ncmodel.errors import InputError, UsageError
from ncmodel.images import read_grey
from ncmodel.mesh.load import load_mesh
from ncmodel.model.calibration import preference_of
from ncmodel.model.maps import network_maps
from ncmodel.model.picture_statistics import picture_scores
from ncmodel.model.predictor import Model, as_seen, load_model
from ncmodel.model.preference import UNCALIBRATED, Preference
from ncmodel.model.score import PictureScore
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.scene.orientation import turn_outwards
from ncmodel.scene.seams import sew_seams
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Image, Mesh

Sheet = Drawing | Image | str | Path
"""A drawing: one of ours, (H, W) ink with 1 = line, or a picture file with dark lines on light paper."""

MOST_INK = 1 / 3
"""Share of a picture that ink may cover: more is a shaded picture, or the wrong way round."""

PROPORTION = 0.01
"""By how much a drawing may be too wide or too high for the camera's frame: sizes are whole pixels."""


@dataclass(frozen=True)
class DrawingScores:
    """What a model says of some drawings of a view.

    Attributes:
        scores: Name -> score; higher is better.
        preference: What differences of scores mean for people.
        calibrated: Whether votes have shown that; else it is a guess.
    """

    scores: Mapping[str, float]
    preference: Preference
    calibrated: bool

    def probability(self, first: str, second: str) -> float:
        """The share of people who prefer the first drawing to the second."""
        return float(self.preference.share(self.scores[first] - self.scores[second]))

    def to_record(self) -> dict[str, object]:
        """JSON-ready values."""
        shares = {a: {b: self.probability(a, b) for b in self.scores if b != a} for a in self.scores}
        return {
            "scores": dict(self.scores),
            "probability": shares,
            "temperature": self.preference.temperature,
            "calibrated": self.calibrated,
        }


def score_drawing(
    shape: Mesh | Surface | str | Path,
    drawing: Sheet,
    camera: Camera | str | Path,
    model: Model | str | Path,
    up: str = "y",
    device: str = "cpu",
) -> float:
    """How good a drawing of a shape is, by what a model chooses by; higher is better.

    Args:
        shape: A mesh file, a mesh in object space, or a surface, which is taken as it is.
        drawing: A `Drawing`, (H, W) ink with 1 = line, or a picture file with dark lines on light paper. It shows the
            shape in the camera's frame, at any size.
        camera: What it is seen through, or its file.
        model: What `load_model` returns, or a checkpoint.
        up: The upward axis, "y" or "z", of a mesh file.
        device: Where a checkpoint's networks compute: "cpu", "cuda", or another of torch's devices.

    Raises:
        InputError: A file can't be read, or a drawing isn't lines on paper in the camera's frame.
        UsageError: The model ranks nothing, or this machine has no such device.
    """
    return score_drawings(shape, {"drawing": drawing}, camera, model, up, device).scores["drawing"]


def score_drawings(
    shape: Mesh | Surface | str | Path,
    drawings: Mapping[str, Sheet],
    camera: Camera | str | Path,
    model: Model | str | Path,
    up: str = "y",
    device: str = "cpu",
) -> DrawingScores:
    """Score several drawings of a view, and tell how many people would prefer one to another.

    Args:
        shape: As `score_drawing` takes it.
        drawings: Name -> drawing, likewise.
        camera: Likewise.
        model: Likewise.
        up: Likewise.
        device: Likewise.

    Raises:
        InputError: As `score_drawing` does.
        UsageError: Likewise.
    """
    judge = model if isinstance(model, Model) else load_model(model, device)
    checkpoint = judge.checkpoint
    if checkpoint.ranker is None and checkpoint.statistics is None:
        raise UsageError("this model ranks nothing; expected one with a ranking module or a ranker on numbers")
    seen_from = camera if isinstance(camera, Camera) else Camera.load(camera)
    inks = [drawing_ink(name, drawing, seen_from.width, seen_from.height) for name, drawing in drawings.items()]
    view = as_seen(View(_surface(shape, seen_from, up), seen_from))
    found = dict(zip(drawings, _scores(checkpoint, view, inks).tolist(), strict=True))
    known = preference_of(checkpoint)
    return DrawingScores(found, known or Preference(UNCALIBRATED), known is not None)


def _scores(checkpoint: Checkpoint, view: View, inks: Sequence[Image]) -> Floats:
    """(N,) scores of pictures by all that a model goes by when it chooses."""
    maps = network_maps(view, checkpoint.preset.inputs, checkpoint.preset.percentile)
    looked_at = None if checkpoint.ranker is None else PictureScore(checkpoint.ranker, maps).scores(inks)
    counting = checkpoint.statistics
    if counting is None:
        assert looked_at is not None
        return looked_at
    size = view.camera.width, view.camera.height
    fitting = [np.asarray(cv2.resize(ink, size, interpolation=cv2.INTER_AREA), dtype=np.float32) for ink in inks]
    counted = picture_scores(fitting, draw_layers(view, Levels()), maps, counting)
    return counted if looked_at is None else counted + counting.mix[2].item() * looked_at


def drawing_ink(name: str, drawing: Sheet, frame_width: int, frame_height: int) -> Image:
    """(H, W) ink of a drawing in a camera's frame, at any size.

    Raises:
        InputError: It can't be read, isn't lines on paper, or has other proportions than the frame.
    """
    if isinstance(drawing, Drawing):
        ink = drawing.ink()
    elif isinstance(drawing, str | Path):
        name, ink = str(drawing), np.asarray(1.0 - read_grey(drawing), dtype=np.float32)
    else:
        ink = np.asarray(drawing, dtype=np.float32)
    if ink.ndim != 2:
        raise InputError(name, f"an array of shape {ink.shape}", "(H, W) ink")
    height, width = ink.shape
    if abs(width * frame_height / (height * frame_width) - 1.0) > max(PROPORTION, 1.0 / min(width, height)):
        frame = f"the camera's frame, {frame_width} x {frame_height} or in its proportions"
        raise InputError(name, f"{width} x {height} pixels", frame)
    if ink.mean() > MOST_INK:
        raise InputError(name, f"{ink.mean():.0%} of it is ink", "dark lines on light paper, at most a third of it ink")
    return ink


def _surface(shape: Mesh | Surface | str | Path, camera: Camera, up: str) -> Surface:
    """The shape as `draw` sees it through this camera."""
    if isinstance(shape, Surface):
        return shape
    mesh = shape if isinstance(shape, Mesh) else load_mesh(shape, up)
    return turn_outwards(sew_seams(Surface(mesh)), camera.eye)
