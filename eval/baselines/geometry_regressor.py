"""The appendix's Geometry-Regressor: lines at thresholds that a network predicts, in place of those that score best."""

import numpy as np
import torch

from ncmodel.drawing.draw import draw_view
from ncmodel.drawing.drawing import Drawing
from ncmodel.drawing.plan import MODEL_CRUMB, Plan
from ncmodel.model.letterbox import Square
from ncmodel.model.maps import LineMaps, line_maps, network_maps
from ncmodel.model.predictor import as_seen
from ncmodel.nets.blocks import threads_for
from ncmodel.nets.devices import device_of, numbers
from ncmodel.nets.presets import BACKGROUND, Preset
from ncmodel.nets.regressor import GeometryRegressor, MeshGraph
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, Floats, LineFamily, Thresholds

ALWAYS = (LineFamily.CONTOURS, LineFamily.BOUNDARIES)
"""What I_G has whatever t is."""


def draw(view: View, regressor: GeometryRegressor, preset: Preset) -> Drawing:
    """I_G(t) of the predicted t, its lines joined and cleared of crumbs as a model's are."""
    return draw_view(view, plan(view, regressor, preset))


def plan(view: View, regressor: GeometryRegressor, preset: Preset) -> Plan:
    """What the network decides to draw of a view.

    Args:
        view: The view.
        regressor: The network.
        preset: That it was trained with.
    """
    seen = as_seen(view)
    lines = line_maps(seen, percentile=preset.percentile)
    thresholds = predicted(seen, lines, regressor, preset)
    p90 = {family: float(lines.p90[index]) for index, family in enumerate(FILTERED_FAMILIES)}
    # Of a family without lines there is nothing to draw.
    t = {f.value: float(thresholds[n]) for n, f in enumerate(FILTERED_FAMILIES) if lines.lines[n].any()}
    unset = Thresholds(None, None, None, None, unit="p90", p90=p90)
    families = (*ALWAYS, *(family for family in FILTERED_FAMILIES if family.value in t))
    return Plan(families, unset.with_values(**t), finished=True, crumb=MODEL_CRUMB, rims=True)


def predicted(seen: View, lines: LineMaps, regressor: GeometryRegressor, preset: Preset) -> Floats:
    """(4,) the thresholds of a view as networks see it, in units of the 90th percentiles."""
    device = device_of(regressor)
    maps = network_maps(seen, preset.inputs, preset.percentile)
    placed = Square(maps.shape[1], maps.shape[2], regressor.size).fit(maps, BACKGROUND)
    graph = MeshGraph.of(seen.mesh.vertices, seen.surface.normals, seen.mesh.faces).on(device)
    largest = lines.features.reshape(len(FILTERED_FAMILIES), -1).max(axis=1).astype(np.float32)
    with torch.inference_mode(), numbers(device, rough=False), threads_for(preset.ranking.width):
        t = regressor(graph, *(torch.from_numpy(part)[None].to(device) for part in (placed, largest)))
    return np.asarray(t[0].double().cpu().numpy())
