"""Drawings of a view of which only the folder of maps is known, and their scores: pixels in, pixels out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import torch

from ncmodel.drawing.arguments import Lines, ThresholdValues, families_of, plan_of
from ncmodel.drawing.plan import Plan
from ncmodel.errors import UsageError
from ncmodel.export.files import PICTURES, check_output
from ncmodel.export.page import WIDTH as LINE_WIDTH
from ncmodel.export.page import Picture
from ncmodel.export.pdf import pdf
from ncmodel.export.png import ink as ink_of
from ncmodel.export.svg import svg
from ncmodel.files import write_bytes
from ncmodel.images import png_ink
from ncmodel.model.calibration import preference_of
from ncmodel.model.filters import line_drawing
from ncmodel.model.letterbox import Square
from ncmodel.model.picture_statistics import picture_scores
from ncmodel.model.predictor import Model, Variant
from ncmodel.model.preference import UNCALIBRATED, Preference
from ncmodel.model.ridge_detection import RidgeOptions, chained, find_ridges, polylines
from ncmodel.model.score import DrawingScore, PictureScore
from ncmodel.model.scoring import DrawingScores, Sheet, drawing_ink
from ncmodel.model.setting_choice import choose_among
from ncmodel.model.threshold_search import Budget
from ncmodel.nets.blocks import threads_for
from ncmodel.published.folder import PublishedView
from ncmodel.published.layers import filtered_lines, layers_of
from ncmodel.published.model import BASE, PublishedModel
from ncmodel.published.scoring import PublishedScore
from ncmodel.types import FILTERED_FAMILIES, Image, LineFamily, Stroke, Thresholds

TRACED = RidgeOptions(sigma=1.0, low=0.1, high=0.2, length=4.0, full=1.0)
"""How lines are found again in a drawing's pixels."""


@dataclass(frozen=True, eq=False)
class PictureDrawing:
    """A drawing that was put together pixel by pixel.

    Attributes:
        ink: (H, W) in [0, 1].
        plan: What it shows.
    """

    ink: Image
    plan: Plan

    @property
    def strokes(self) -> tuple[Stroke, ...]:
        """Its lines, traced along their middle."""
        return chained(find_ridges(self.ink, TRACED))

    def save(self, path: str | Path, width: float = LINE_WIDTH, background: str | None = None) -> None:
        """Write a .png file with these pixels, or an .svg or .pdf file with the lines traced in them.

        Args:
            path: Where to; the suffix says in which format.
            width: Of the traced lines, as `Drawing.save` takes it.
            background: Likewise.

        Raises:
            UsageError: The suffix is something else, or a .png file should have another background than white.
            InputError: There is no such folder.
        """
        check_output(path, PICTURES)
        suffix = Path(path).suffix.lower()
        if suffix == ".png":
            if background not in (None, "white"):
                raise UsageError(f"background: found {background!r}, expected white: pixels of maps are black on white")
            write_bytes(path, png_ink(self.ink))
            return
        page = Picture(self.ink.shape[1], self.ink.shape[0], self.strokes, width, background, Path(path).stem)
        write_bytes(path, svg(page).encode() if suffix == ".svg" else pdf(page))


def draw_maps(
    view: PublishedView,
    model: Model | None = None,
    lines: Lines | None = None,
    thresholds: ThresholdValues | None = None,
    variant: Variant | None = None,
    preset: str = "balanced",
) -> PictureDrawing:
    """Draw a view of which only the maps are known.

    Args:
        view: The maps.
        model: Chooses thresholds and families, and adds the lines of its image branch: as the published code does if it
            is a `PublishedModel`, else as the paper says.
        lines: Families to draw, or that a model may choose from. Contours and creases, which share a picture, are
            always drawn.
        thresholds: In rtsc's units; without a model.
        variant: Which of the model's branches take part; all by default.
        preset: How thoroughly a model searches.

    Raises:
        UsageError: Arguments make no sense together, the model lacks a network, or the maps have another size than the
            published networks see.
    """
    if thresholds is not None and model is not None:
        raise UsageError("thresholds: found some beside a model, which chooses its own; expected one or the other")
    if model is None:
        if variant is not None:
            raise UsageError("variant: found one without a model, expected a model whose branches it tells")
        return _filtered(view, plan_of(lines, thresholds))
    families = tuple(LineFamily) if lines is None else families_of(lines)
    if isinstance(model, PublishedModel):
        choice = model.choose_lines(view, variant, preset, families)
        return PictureDrawing(choice.ink, choice.plan)
    return _chosen(view, model, model.known_variant(variant), preset, families)


def score_maps(view: PublishedView, drawings: Mapping[str, Sheet], model: Model) -> DrawingScores:
    """Score drawings of a view of which only the maps are known.

    Args:
        view: The maps.
        drawings: Name -> drawing, as `score_drawings` takes them.
        model: The model.

    Raises:
        InputError: A drawing isn't lines on paper in the maps' proportions.
        UsageError: The model ranks nothing, or the maps have another size than the published networks see.
    """
    checkpoint, counting = model.checkpoint, model.checkpoint.statistics
    if checkpoint.ranker is None and counting is None:
        raise UsageError("this model ranks nothing; expected one with a ranking module or a ranker on numbers")
    inks = [drawing_ink(name, drawing, *view.size) for name, drawing in drawings.items()]
    maps = view.network_maps(checkpoint.preset.inputs)
    found = np.zeros(len(inks))
    if isinstance(model, PublishedModel) and checkpoint.ranker is not None:
        score = PublishedScore(checkpoint.ranker, view)
        found = np.array([score.of_picture(_sized(ink, view.size)) for ink in inks])
    elif checkpoint.ranker is not None:
        found = PictureScore(checkpoint.ranker, maps).scores(inks)
    if counting is not None:
        fitting = [_sized(ink, view.size) for ink in inks]
        found = counting.mix[2].item() * found + picture_scores(fitting, layers_of(view), maps, counting)
    known = preference_of(checkpoint)
    scores = dict(zip(drawings, found.tolist(), strict=True))
    return DrawingScores(scores, known or Preference(UNCALIBRATED), known is not None)


def _sized(ink: Image, size: tuple[int, int]) -> Image:
    if ink.shape == size[::-1]:
        return ink
    return np.asarray(cv2.resize(ink, size, interpolation=cv2.INTER_AREA), dtype=np.float32)


def _filtered(view: PublishedView, plan: Plan) -> PictureDrawing:
    """The lines that given thresholds leave, by the published filter."""
    values = [plan.thresholds.value(f) if f in plan.drawn else None for f in FILTERED_FAMILIES]
    drawn = np.array([value is not None for value in values])
    lines = filtered_lines(view, [value or 0.0 for value in values])[drawn]
    always = [view.base, *([view.boundaries] if LineFamily.BOUNDARIES in plan.families else [])]
    return PictureDrawing(np.maximum.reduce([*always, *lines]), plan)


def _chosen(
    view: PublishedView, model: Model, variant: Variant, preset: str, families: Sequence[LineFamily]
) -> PictureDrawing:
    """What a model chooses by the paper's equations."""
    checkpoint, budget, (width, height) = model.checkpoint, model.known_budget(preset), view.size
    maps = view.network_maps(checkpoint.preset.inputs)
    image: Image | None = None
    if variant != "geometry":
        probability = model.probability(maps, rough=budget.looks > 0)
        found = polylines(find_ridges(probability), Square(height, width, len(probability)))
        image = ink_of(Picture(width, height, found))
    if variant == "image":
        assert image is not None
        return PictureDrawing(image, Plan((), Thresholds(None, None, None, None)))
    if checkpoint.statistics is not None:
        return _with_setting(view, model, image, budget, families)
    assert checkpoint.ranker is not None, "its variants wouldn't have this one"
    allowed = np.array([family in families for family in FILTERED_FAMILIES], dtype=np.float32)
    lines = view.line_maps()
    lines = replace(lines, lines=lines.lines * allowed[:, None, None])
    optimum = model.search(partial(DrawingScore, maps=maps, lines=lines, image=image, mirrored=budget.mirrored), budget)
    parts = [lines.contours, *([lines.boundaries] if optimum.boundaries else []), *([] if image is None else [image])]
    always = np.maximum.reduce(parts)
    pixels = torch.from_numpy(lines.lines).flatten(1), torch.from_numpy(lines.features).flatten(1)
    ink = line_drawing(*pixels, torch.from_numpy(always).flatten(), torch.tensor([optimum.thresholds]))
    chosen = {f: t for f, t, there in zip(FILTERED_FAMILIES, optimum.thresholds, optimum.present, strict=True) if there}
    values = {family.value: t for family, t in chosen.items()}
    p90 = dict(zip(FILTERED_FAMILIES, view.p90.tolist(), strict=True))
    plan = Plan(
        families=(*BASE.families, *([LineFamily.BOUNDARIES] if optimum.boundaries else []), *chosen),
        thresholds=Thresholds(None, None, None, None, unit="p90", p90=p90).with_values(**values),
        score=optimum.score,
        evaluations=optimum.evaluations,
        converged=optimum.converged,
    )
    return PictureDrawing(np.asarray(ink.reshape(always.shape).numpy()), plan)


def _with_setting(
    view: PublishedView, model: Model, image: Image | None, budget: Budget, families: Sequence[LineFamily]
) -> PictureDrawing:
    """What a model that counts ink chooses."""
    checkpoint, drawings = model.checkpoint, layers_of(view)
    assert checkpoint.statistics is not None
    maps, allowed = view.network_maps(checkpoint.preset.inputs), (*families, LineFamily.BOUNDARIES)
    with threads_for(checkpoint.preset.ranking.width):
        choice = choose_among(
            drawings, maps, checkpoint.statistics, checkpoint.ranker, budget.shortlist, allowed, image, budget.mirrored
        )
    ink = drawings.drawing(drawings.levels.settings.index(choice.setting))
    plan = replace(choice.setting.plan(), score=choice.score, evaluations=choice.evaluations)
    return PictureDrawing(ink if image is None else np.maximum(ink, image), plan)
