"""From a shape to its drawing: the one entry function, and the one way from a plan to strokes.

Only what a request needs is computed: contours need no curvature, a family that isn't asked for costs nothing, and
lines are thresholded before their visibility is decided.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from ncmodel.camera import DEFAULT_AZIMUTH, DEFAULT_ELEVATION, DEFAULT_SIZE, PERSPECTIVE, PROJECTIONS, Camera
from ncmodel.drawing import arguments
from ncmodel.drawing.drawing import Drawing
from ncmodel.drawing.finishing import finish, finish_hidden
from ncmodel.drawing.importance import most_important, without_short
from ncmodel.drawing.plan import Plan
from ncmodel.drawing.strokes import strokes
from ncmodel.drawing.thresholding import fade, survivors
from ncmodel.errors import ArgumentError, UsageError
from ncmodel.export.page import page_scale
from ncmodel.lines.ridges import resolved_in_view
from ncmodel.lines.visibility import MESH_EDGES
from ncmodel.scene.creases import split_at_creases
from ncmodel.scene.prepared import hints, surface_of
from ncmodel.scene.surface import CREASE_ANGLE, Surface
from ncmodel.scene.view import View
from ncmodel.tracing import timed
from ncmodel.types import (
    EVERYTHING,
    FILTERED_FAMILIES,
    LineFamily,
    LineSet,
    Mesh,
    Segments,
    Stroke,
    Threshold,
    Thresholds,
)

SHORTEST_STROKE = 2.5
"""Strokes on the smooth surface shorter than this, in pixels at 768, are dots and not drawn."""


@dataclass(frozen=True)
class Fineness:
    """How finely a drawing is worked out.

    Attributes:
        sample_pixels: Distance along the picture of the points at which visibility is decided.
        tolerance: Pixels that strokes may stray from the lines on the mesh.
    """

    sample_pixels: float = 1.0
    tolerance: float = 0.25


PRESETS = {
    "instant": Fineness(4.0, 0.5),
    "draft": Fineness(4.0, 0.5),
    "balanced": Fineness(),
    "accurate": Fineness(0.5, 0.05),
}
BALANCED = PRESETS["balanced"]


class Chooser(Protocol):
    """What plans a drawing of a view: a trained model."""

    def choose(self, view: View, *, budget: str, families: Sequence[LineFamily]) -> Plan:
        """The plan, of contours, boundaries and those of `families` that it likes."""


def draw(
    shape: Mesh | Surface | str | Path | Any,
    camera: Camera | None = None,
    lines: arguments.Lines | None = None,
    thresholds: arguments.ThresholdValues | None = None,
    *,
    model: Chooser | None = None,
    variant: str | None = None,
    preset: str = "balanced",
    azimuth: float = DEFAULT_AZIMUTH,
    elevation: float = DEFAULT_ELEVATION,
    size: int | tuple[int, int] = DEFAULT_SIZE,
    projection: str = PERSPECTIVE,
    up: str = "y",
    crease_angle: float = CREASE_ANGLE,
    tolerance: float | None = None,
    detail: float = 1.0,
    min_length: float = 0.0,
    hidden: str = "none",
) -> Drawing:
    """Draw a shape's lines.

    Args:
        shape: A mesh file, or a mesh, which without a camera is normalised as files are: its seams are sewn and its
            faces turned outwards. Or a surface, which is drawn as it is and whose computed quantities are reused. Or
            what `as_mesh` takes as a file: (vertices, faces), a mesh of trimesh, PyVista, Open3D or meshio.
        camera: Where from; unless given, one at `azimuth` and `elevation` that has the shape in its frame.
        lines: Families to draw, such as ["contours", "suggestive"] or "contours,suggestive"; those whose threshold is
            None are left out. Without a model, `DEFAULT_FAMILIES` and those that get a threshold unless given; a model
            decides by itself unless given what it may choose from.
        thresholds: rtsc's defaults unless given, for those that {"suggestive": 0.02} or "suggestive=0.02" doesn't name,
            too; a model finds its own.
        model: Chooses thresholds and families, and adds the lines of its image branch.
        variant: Which of the model's branches take part: "full", "geometry" or "image"; all that it has by default.
        preset: "instant", "draft", "balanced" or "accurate": how densely visibility is sampled, how closely strokes
            follow the lines, and how thoroughly a model searches. "published" is as "balanced", but an imported model
            searches by the published schedule.
        azimuth: Degrees round the shape from its front, without a camera.
        elevation: Degrees above the ground, without a camera.
        size: (width, height) in pixels, or both in one, without a camera.
        projection: "perspective", or "orthographic": along parallel lines; without a camera.
        up: The upward axis, "y" or "z", of a mesh file, or of what is taken as one; a `Mesh` is y-up.
        crease_angle: Degrees between faces above which their edge is a crease.
        tolerance: Pixels that strokes may stray from the lines on the mesh; the preset's unless given.
        detail: Share of the lines inside the outline that is drawn, the strongest and longest first: 0 is the outline
            alone, 1 everything.
        min_length: Shorter strokes are left out unless they are outline; pixels, at 768: it grows with the picture.
        hidden: "dashed" or "layer" draws the lines behind the surface, too, in a group of their own; "none" doesn't.

    Raises:
        MeshError: The file can't be read.
        UsageError: Some argument makes no sense, or thresholds are given together with a model or a variant without.
    """
    fineness = fineness_of(preset, tolerance)
    if thresholds is not None and model is not None:
        raise UsageError("thresholds: found some beside a model, which chooses its own; expected one or the other")
    if variant is not None and model is None:
        raise ArgumentError("variant", repr(variant), "a model beside it, whose branches it tells")
    asked = arguments.plan_of(lines, thresholds, detail, min_length, hidden)
    _check(camera, model, projection, azimuth=azimuth, elevation=elevation, crease_angle=crease_angle)
    surface = surface_of(shape, up, None if camera is None else camera.eye)
    if LineFamily.CREASES in asked.families and model is None:
        surface = split_at_creases(surface, crease_angle)
    placed = camera or Camera.orbit(
        surface.mesh.used_vertices, azimuth, elevation, size=arguments.size_of(size), projection=projection
    )
    view = View(surface, placed, crease_angle)
    among = None if lines is None else asked.families
    plan = asked if model is None else _chosen(model, view, variant, preset, among)
    plan = replace(plan, detail=asked.detail, min_length=asked.min_length, hidden=asked.hidden)
    drawing = draw_view(seen_by(plan, view), plan, fineness)
    return drawing if camera is not None else replace(drawing, notes=(*drawing.notes, *hints(surface, shape, up)))


def seen_by(plan: Plan, view: View) -> View:
    """The view that a plan is drawn of: a finished drawing with creases is of the surface parted there.

    Flats between creases don't curve, so that no lines of curvature are drawn on them.

    Args:
        plan: Whether it has creases.
        view: As it was planned for.
    """
    if not plan.finished or LineFamily.CREASES not in plan.families:
        return view
    surface = split_at_creases(view.surface, view.crease_angle)
    return view if surface is view.surface else View(surface, view.camera, view.crease_angle)


def draw_view(view: View, plan: Plan, fineness: Fineness = BALANCED) -> Drawing:
    """Draw what a plan says of a view.

    Args:
        view: The view, as it is.
        plan: Families, thresholds, and strokes of other origin.
        fineness: How finely.
    """
    plan = replace(plan, thresholds=_with_units(plan, view))
    drawn: list[Stroke] = []
    for family in plan.drawn:
        threshold = plan.thresholds.of(family)
        assert threshold is not None, "families that are left out aren't drawn"
        segments = visible_segments(view, family, threshold, fineness.sample_pixels, plan.crumb > 0.0)
        drawn += strokes_of(view, segments, fineness)
    drawn += plan.strokes
    if plan.rims and LineFamily.BOUNDARIES not in plan.drawn:
        drawn += _rims(view, fineness)
    if plan.finished:
        drawn = list(finish(drawn, view, plan.crumb))
    mesh = view.mesh
    chosen = _chosen_strokes(view, plan, tuple(drawn))
    if plan.hidden != "none":
        chosen += _chosen_strokes(view, plan, _hidden_strokes(view, plan, chosen, fineness))
    return Drawing(view.camera, chosen, mesh.name, plan, mesh.notes, view.trace)


def visible_segments(
    view: View,
    family: LineFamily,
    threshold: Threshold = EVERYTHING,
    sample_pixels: float = 1.0,
    resolved: bool = False,
) -> Segments:
    """The visible segments of a family that its threshold leaves, with their opacity.

    Args:
        view: The view.
        family: The family.
        threshold: Its threshold.
        sample_pixels: Distance along the picture of the points at which visibility is decided.
        resolved: Whether apparent ridges are left out where the faces are too large to tell them.
    """
    if family not in FILTERED_FAMILIES:
        return fade(view.visible(family, sample_pixels), threshold)
    return fade(view.unhidden(_strong(view, family, threshold, resolved), sample_pixels), threshold)


def hidden_segments(
    view: View,
    family: LineFamily,
    threshold: Threshold = EVERYTHING,
    sample_pixels: float = 1.0,
    resolved: bool = False,
) -> Segments:
    """What the surface hides of the segments of a family that its threshold leaves; arguments as `visible_segments`."""
    if family not in FILTERED_FAMILIES:
        return fade(view.hidden(family, sample_pixels), threshold)
    return fade(view.behind(_strong(view, family, threshold, resolved), sample_pixels), threshold)


def _strong(view: View, family: LineFamily, threshold: Threshold, resolved: bool) -> LineSet:
    """The lines, seen or hidden, that a threshold leaves: the weak ones are the most numerous, and need no rays."""
    lines = view.candidates(family)
    lines = lines.take(survivors(lines, threshold))
    if resolved and family is LineFamily.APPARENT:
        return resolved_in_view(lines, view.surface.faces, view.n_dot_v)
    return lines


def strokes_of(view: View, segments: Segments, fineness: Fineness = BALANCED) -> tuple[Stroke, ...]:
    """The strokes that visible segments of a view are drawn as: long, simplified, without dots.

    Args:
        view: The view.
        segments: Of one family.
        fineness: How closely they follow the segments.
    """
    camera = view.camera
    with timed(view.trace, "strokes"):
        return strokes(segments, camera, fineness.tolerance, shortest_stroke(segments.family, camera))


def shortest_stroke(family: LineFamily, camera: Camera) -> float:
    """Pixels below which strokes of a family are dots; edges of the mesh have none."""
    return 0.0 if family in MESH_EDGES else SHORTEST_STROKE * page_scale(camera.width, camera.height)


def _hidden_strokes(view: View, plan: Plan, drawn: tuple[Stroke, ...], fineness: Fineness) -> tuple[Stroke, ...]:
    """The lines behind the surface that the plan has, each once, and none where a visible one is drawn."""
    found: list[Stroke] = []
    for family in plan.drawn:
        threshold = plan.thresholds.of(family)
        assert threshold is not None, "families that are left out aren't drawn"
        segments = hidden_segments(view, family, threshold, fineness.sample_pixels, plan.crumb > 0.0)
        found += strokes_of(view, segments, fineness)
    return finish_hidden(found, drawn, view)


def _rims(view: View, fineness: Fineness) -> tuple[Stroke, ...]:
    """As much of the boundaries as is the shape's outline."""
    segments = visible_segments(view, LineFamily.BOUNDARIES, EVERYTHING, fineness.sample_pixels)
    scale = page_scale(view.camera.width, view.camera.height)
    return most_important(strokes_of(view, segments, fineness), 0.0, view.beyond, scale)


def _chosen_strokes(view: View, plan: Plan, drawn: tuple[Stroke, ...]) -> tuple[Stroke, ...]:
    """Those of the strokes that are long and important enough for the plan."""
    if plan.detail >= 1.0 and plan.min_length <= 0.0:
        return drawn
    scale = page_scale(view.camera.width, view.camera.height)
    with timed(view.trace, "importance"):
        long = without_short(drawn, plan.min_length, view.beyond, scale)
        return most_important(long, plan.detail, view.beyond, scale)


def _with_units(plan: Plan, view: View) -> Thresholds:
    """The plan's thresholds, those in 90th percentiles with the percentiles that the view has."""
    thresholds = plan.thresholds
    if thresholds.unit != "p90":
        return thresholds
    missing = [f for f in plan.drawn if f in FILTERED_FAMILIES and f not in thresholds.p90]
    return replace(thresholds, p90={**thresholds.p90, **{f: view.feature_percentile(f) for f in missing}})


def _check(camera: object, model: object, projection: str, crease_angle: float, **angles: float) -> None:
    if camera is not None:
        arguments.expect("camera", camera, Camera, "a Camera (Camera.load reads a file)")
    if model is not None and not hasattr(model, "choose"):
        raise UsageError(f"model: found {type(model).__name__}, expected what load_model returns")
    if projection not in PROJECTIONS:
        raise ArgumentError("projection", repr(projection), f"one of {', '.join(PROJECTIONS)}")
    for name, angle in {"crease angle": crease_angle, **angles}.items():
        arguments.number(name, angle, "degrees")
    if not 0.0 < crease_angle < 180.0:
        raise UsageError(f"crease angle: found {crease_angle}, expected degrees between 0 and 180")


def fineness_of(preset: str, tolerance: float | None = None) -> Fineness:
    """How finely a preset draws, with another tolerance if one is given.

    Raises:
        UsageError: There is no such preset, or the tolerance isn't 0 or more.
    """
    known = {**PRESETS, "published": BALANCED}
    if preset not in known:
        raise UsageError(f"preset: found {preset!r}, expected one of {', '.join(PRESETS)}")
    if tolerance is None:
        return known[preset]
    arguments.number("tolerance", tolerance, "pixels >= 0")
    if tolerance < 0.0:
        raise UsageError(f"tolerance: found {tolerance}, expected pixels >= 0")
    return replace(known[preset], tolerance=tolerance)


def _chosen(model: Chooser, view: View, variant: str | None, preset: str, asked: tuple[LineFamily, ...] | None) -> Plan:
    """What a model draws, of the families asked for."""
    # Whoever else chooses needn't know variants.
    branches: dict[str, Any] = {} if variant is None else {"variant": variant}
    if asked is None:
        return model.choose(view, budget=preset, families=tuple(LineFamily), **branches)
    plan = model.choose(view, budget=preset, families=asked, **branches)
    chosen = tuple(family for family in plan.families if family in asked)
    # These are no part of what every model can weigh; they are drawn if somebody wants them.
    wanted = (f for f in (LineFamily.CREASES, LineFamily.INTERSECTIONS) if f in asked and f not in chosen)
    rims = plan.rims and LineFamily.BOUNDARIES in asked
    return replace(plan, families=(*chosen, *wanted), crumb=0.0, rims=rims)
