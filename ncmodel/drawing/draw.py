"""From a shape to its drawing: the one entry function.

Only what a request needs is computed: contours need no curvature, a family that isn't asked for costs nothing, and
lines are thresholded before their visibility is decided.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ncmodel.camera import DEFAULT_AZIMUTH, DEFAULT_ELEVATION, DEFAULT_SIZE, Camera
from ncmodel.drawing import arguments
from ncmodel.drawing.drawing import DEFAULT_FAMILIES, Drawing, Plan
from ncmodel.drawing.thresholding import fade, survivors
from ncmodel.errors import UsageError
from ncmodel.export.page import REFERENCE_SIDE
from ncmodel.tracing import timed
from ncmodel.types import FILTERED_FAMILIES, LineFamily, Mesh, Segments, Stroke, Thresholds, Trace

if TYPE_CHECKING:
    from ncmodel.model.predictor import Model
    from ncmodel.scene.surface import Surface
    from ncmodel.scene.view import View

CREASE_ANGLE = 40.0
"""Degrees between faces above which their edge is drawn as a crease, unless told otherwise."""
SHORTEST_STROKE = 2.5
"""Strokes on the smooth surface shorter than this, in pixels at 768, are dots and not drawn."""


@dataclass(frozen=True)
class Detail:
    """How finely a drawing is worked out.

    Attributes:
        sample_pixels: Distance along the picture of the points at which visibility is decided.
        tolerance: Pixels that strokes may stray from the lines on the mesh.
    """

    sample_pixels: float = 1.0
    tolerance: float = 0.25


PRESETS = {"draft": Detail(4.0, 0.5), "balanced": Detail(), "accurate": Detail(0.5, 0.05)}


def draw(
    shape: "Mesh | Surface | str | Path",
    camera: Camera | None = None,
    lines: arguments.Lines | None = None,
    thresholds: Thresholds | Mapping[str, float | None] | None = None,
    *,
    model: "Model | None" = None,
    preset: str = "balanced",
    azimuth: float = DEFAULT_AZIMUTH,
    elevation: float = DEFAULT_ELEVATION,
    size: int | tuple[int, int] = DEFAULT_SIZE,
    up: str = "y",
    crease_angle: float = CREASE_ANGLE,
    tolerance: float | None = None,
) -> Drawing:
    """Draw a shape's lines.

    Args:
        shape: A mesh file, or a mesh, which without a camera is normalised as files are: its seams are sewn and its
            faces turned outwards. Or a surface, which is drawn as it is and whose computed quantities are reused.
        camera: Where from; unless given, one at `azimuth` and `elevation` that has the shape in its frame.
        lines: Families to draw, such as ["contours", "suggestive"] or "contours,suggestive"; those whose threshold is
            None are left out. Without a model, `DEFAULT_FAMILIES` unless given; a model decides by itself unless given
            what it may choose from.
        thresholds: rtsc's defaults unless given, for those that {"suggestive": 0.02} doesn't name, too; a model finds
            its own.
        model: Chooses thresholds and families, and adds the lines of its image branch.
        preset: "draft", "balanced" or "accurate": how densely visibility is sampled, how closely strokes follow the
            lines, and how thoroughly a model searches.
        azimuth: Degrees round the shape from its front, without a camera.
        elevation: Degrees above the ground, without a camera.
        size: (width, height) in pixels, or both in one, without a camera.
        up: The upward axis, "y" or "z", of a mesh file.
        crease_angle: Degrees between faces above which their edge is a crease.
        tolerance: Pixels that strokes may stray from the lines on the mesh; the preset's unless given.

    Raises:
        MeshError: The file can't be read.
        UsageError: Some argument makes no sense, or thresholds are given together with a model.
    """
    from ncmodel.drawing.polygonal_outlines import missing_outlines
    from ncmodel.drawing.strokes import strokes
    from ncmodel.lines.visibility import MESH_EDGES
    from ncmodel.scene.creases import parted
    from ncmodel.scene.view import View

    detail = _detail(preset, tolerance)
    asked = DEFAULT_FAMILIES if lines is None else arguments.families(lines)
    chosen = arguments.thresholds_of(thresholds)
    if chosen is not None and model is not None:
        raise UsageError("thresholds: found some beside a model, which chooses its own; expected one or the other")
    _check(camera, model, azimuth=azimuth, elevation=elevation, crease_angle=crease_angle)
    surface = whole = _surface(shape, up, None if camera is None else camera.eye)
    by_edges = LineFamily.CREASES in asked and model is None
    if by_edges:
        surface = parted(surface, crease_angle)
    camera = camera or Camera.orbit(surface.mesh.used_vertices, azimuth, elevation, size=arguments.size_of(size))
    view = View(surface, camera, crease_angle)
    if model is None:
        plan = Plan(asked, chosen or Thresholds())
    else:
        plan = _chosen(model, view, preset, None if lines is None else asked)
    drawn: list[Stroke] = []
    scale = min(camera.width, camera.height) / REFERENCE_SIDE
    for family in plan.drawn:
        segments = visible_segments(view, family, plan, detail.sample_pixels)
        with timed(surface.trace, "strokes"):
            shortest = 0.0 if family in MESH_EDGES else SHORTEST_STROKE * scale
            drawn += strokes(segments, camera, detail.tolerance, shortest)
    if by_edges and LineFamily.CONTOURS in plan.drawn:
        full = [stroke for stroke in drawn if stroke.family not in FILTERED_FAMILIES]
        with timed(surface.trace, "missing_outlines"):
            segments = missing_outlines(whole, camera, full, detail.sample_pixels)
            drawn += strokes(segments, camera, detail.tolerance, SHORTEST_STROKE * scale)
    mesh = surface.mesh
    return Drawing(camera, (*drawn, *plan.strokes), mesh.name, plan, mesh.notes, surface.trace)


def visible_segments(view: "View", family: LineFamily, plan: Plan, sample_pixels: float = 1.0) -> Segments:
    """The visible segments of a family that its threshold leaves, with their opacity.

    Args:
        view: The view.
        family: The family.
        plan: The thresholds.
        sample_pixels: Distance along the picture of the points at which visibility is decided.
    """
    threshold, unit = plan.thresholds.of(family) or 0.0, plan.thresholds.unit
    p90 = _percentile(view, family, plan) if family in FILTERED_FAMILIES and unit == "p90" else 1.0
    lines = view.candidates(family)
    # Weak lines are the most numerous; what the threshold takes away needs no rays.
    strong = lines.take(survivors(lines, threshold, unit, p90))
    return fade(view.unhidden(strong, sample_pixels), threshold, unit, p90)


def _check(camera: object, model: object, crease_angle: float, **angles: float) -> None:
    if camera is not None:
        arguments.expect("camera", camera, Camera, "a Camera (Camera.load reads a file)")
    if model is not None and not hasattr(model, "choose"):
        raise UsageError(f"model: found {type(model).__name__}, expected what load_model returns")
    for name, angle in {"crease angle": crease_angle, **angles}.items():
        arguments.number(name, angle, "degrees")
    if not 0.0 < crease_angle < 180.0:
        raise UsageError(f"crease angle: found {crease_angle}, expected degrees between 0 and 180")


def _detail(preset: str, tolerance: float | None) -> Detail:
    if preset not in PRESETS:
        raise UsageError(f"preset: found {preset!r}, expected one of {', '.join(PRESETS)}")
    if tolerance is None:
        return PRESETS[preset]
    arguments.number("tolerance", tolerance, "pixels >= 0")
    if tolerance < 0.0:
        raise UsageError(f"tolerance: found {tolerance}, expected pixels >= 0")
    return replace(PRESETS[preset], tolerance=tolerance)


def _chosen(model: "Model", view: "View", preset: str, asked: tuple[LineFamily, ...] | None) -> Plan:
    """What a model draws, of the families asked for."""
    allowed = asked if asked is not None else tuple(LineFamily)
    choice = model.choose(view, budget=preset, families=[f for f in FILTERED_FAMILIES if f in allowed])
    # Creases are no part of what a model can weigh; they are drawn if somebody wants them.
    wanted = (LineFamily.CREASES,) if asked is not None and LineFamily.CREASES in asked else ()
    families = tuple(family for family in choice.families if family in allowed) + wanted
    score, evaluations = (choice.optimum.score, choice.optimum.evaluations) if choice.optimum else (None, 0)
    return Plan(families, choice.thresholds, choice.p90, choice.strokes, score, evaluations)


def _percentile(view: "View", family: LineFamily, plan: Plan) -> float:
    from ncmodel.model.maps import feature_percentile

    return plan.p90[family] if family in plan.p90 else feature_percentile(view, family)


def _surface(shape: "Mesh | Surface | str | Path", up: str, eye: tuple[float, float, float] | None) -> "Surface":
    from ncmodel.scene.surface import Surface

    if isinstance(shape, Surface):
        return shape
    from ncmodel.mesh.load import load_mesh, make_mesh
    from ncmodel.scene.orientation import outward
    from ncmodel.scene.seams import sewn

    trace = Trace()
    if isinstance(shape, Mesh):
        placed = make_mesh(shape.vertices, shape.faces, shape.name, shape.notes)
        mesh = placed if eye is None else shape
    else:
        expected = "a file's path, a Surface or a Mesh, which make_mesh makes of arrays"
        arguments.expect("shape", shape, (str, Path), expected)
        with timed(trace, "load"):
            mesh = load_mesh(shape, up)
    return outward(sewn(Surface(mesh, trace)), eye)
