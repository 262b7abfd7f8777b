"""What the model sees of a view: line maps, feature maps, and the depth and shaded maps that the networks read.

Nothing is computed before it's asked for: a drawing by the image branch alone needs no line, one by the geometry branch
no more families than are asked for.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.drawing.draw import shortest_stroke, strokes_of
from ncmodel.drawing.strokes import without_dots
from ncmodel.drawing.thresholding import fade
from ncmodel.export.page import line_width
from ncmodel.export.png import strokes_ink
from ncmodel.export.rasterize import draw_features
from ncmodel.images import read_grey
from ncmodel.nets.presets import CURVATURE_MAPS, MAPS, Percentile
from ncmodel.scene.view import View
from ncmodel.tracing import timed
from ncmodel.types import FILTERED_FAMILIES, Floats, Image, LineFamily


@dataclass(frozen=True, eq=False)
class LineMaps:
    """The maps of equations 1-5 for one view. Families that weren't asked for have empty maps.

    Attributes:
        lines: (4, H, W) ink of S, R, V, A: visible lines at threshold 0, unfaded, as wide as they are drawn.
        features: (4, H, W) what filters them, in units of `p90`: the feature that the line itself carries, so that
            I_G(t) is the drawing of the vector lines at t; 0 where there is no line.
        contours: (H, W) ink of I_C.
        boundaries: (H, W) ink of I_B.
        p90: (4,) 90th percentile of each family's feature over its positive values, of the view or of the mesh.
    """

    lines: Image
    features: Image
    contours: Image
    boundaries: Image
    p90: Floats


def line_maps(
    view: View, families: Sequence[LineFamily] = FILTERED_FAMILIES, percentile: Percentile = "view"
) -> LineMaps:
    """Draw the unfiltered lines of a view.

    Args:
        view: The view, at the resolution that the maps shall have.
        families: The filtered families to draw; occluding contours and boundaries always are.
        percentile: What features are measured in.
    """
    shape = (view.camera.height, view.camera.width)
    lines, features = (np.zeros((len(FILTERED_FAMILIES), *shape), dtype=np.float32) for _ in range(2))
    p90 = np.ones(len(FILTERED_FAMILIES))
    for index, family in enumerate(FILTERED_FAMILIES):
        if family in families:
            p90[index] = view.feature_percentile(family, percentile)
            lines[index], carried = unfiltered(view, family)
            features[index] = np.maximum(carried / p90[index], 0.0)
    contours, boundaries = (_draw(view, family) for family in (LineFamily.CONTOURS, LineFamily.BOUNDARIES))
    return LineMaps(lines, features, contours, boundaries, p90)


def network_maps(view: View, inputs: Sequence[str] = MAPS, percentile: Percentile = "view") -> Image:
    """(K, H, W) what networks read of a view, background 1.

    Args:
        view: The view.
        inputs: Names of the maps, of `MAPS` and `CURVATURE_MAPS`.
        percentile: What curvature maps are measured in.
    """
    if tuple(inputs) == MAPS:
        return np.concatenate([view.depth[None], view.shaded])
    return np.stack([_network_map(view, name, percentile) for name in inputs])


def item_maps(data: DataFolder, item: Item, inputs: Sequence[str] = MAPS, percentile: Percentile = "view") -> Image:
    """(K, H, W) what networks read of an item: its pictures, and curvature maps, which are computed from its mesh.

    Raises:
        InputError: A file is missing or damaged.
    """
    pictures = {name: read_grey(path) for name, path in zip(MAPS, data.map_paths(item), strict=True) if name in inputs}
    computed = [name for name in inputs if name not in pictures]
    if computed:
        pictures |= dict(zip(computed, network_maps(data.open_view(item), computed, percentile), strict=True))
    return np.stack([pictures[name] for name in inputs])


def _network_map(view: View, name: str, percentile: Percentile) -> Image:
    if name in CURVATURE_MAPS:
        family = LineFamily(name)
        return clipped_features(view, family, view.feature_percentile(family, percentile))
    return view.depth if name == "depth" else view.shaded[int(name.removeprefix("shaded_"))]


def clipped_features(view: View, family: LineFamily, unit: float) -> Image:
    """(H, W) what filters a family, on the seen surface, over `unit` and clipped to [0, 1]; background 1."""
    values = np.clip(view.feature_map(family) / unit, 0.0, 1.0)
    return np.where(view.buffers.hit, values, 1.0).astype(np.float32)


def _draw(view: View, family: LineFamily) -> Image:
    """(H, W) ink of the strokes of a family that no threshold filters."""
    strokes = strokes_of(view, fade(view.visible(family)))
    with timed(view.trace, "line_maps"):
        return strokes_ink(strokes, view.camera)


def unfiltered(view: View, family: LineFamily) -> tuple[Image, Image]:
    """(H, W) ink of a family's visible lines at threshold 0, and the feature that they carry.

    Segments are drawn instead of the strokes made of them, which carry no feature; but none that strokes leave out.
    """
    camera = view.camera
    lines = without_dots(view.visible(family), camera, shortest_stroke(family, camera))
    points = camera.project(lines.points)[..., :2]
    with timed(view.trace, "line_maps"):
        width, shape = line_width(family, camera.width, camera.height), (camera.height, camera.width)
        return draw_features(points, np.ones(points.shape[:2]), lines.feature, width, shape)
