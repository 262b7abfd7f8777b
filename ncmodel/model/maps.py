"""What the model sees of a view: line maps, feature maps, and the depth and shaded maps that the networks read.

Nothing is computed before it's asked for: a drawing by the image branch alone needs no line, one by the geometry branch
no more families than are asked for.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ncmodel.export.rasterize import draw_features, draw_segments
from ncmodel.scene.view import View
from ncmodel.tracing import timed
from ncmodel.types import FILTERED_FAMILIES, Floats, Image, LineFamily

LINE_WIDTH = 2.5
"""Pixels, in a picture whose shorter side is 768."""

PERCENTILE = 90.0


@dataclass(frozen=True, eq=False)
class LineMaps:
    """The maps of equations 1-5 for one view. Families that weren't asked for have empty maps.

    Attributes:
        lines: (4, H, W) ink of S, R, V, A: visible lines at threshold 0, unfaded.
        features: (4, H, W) what filters them, in units of `p90`: the feature that the line itself carries, so that
            I_G(t) is the drawing of the vector lines at t; 0 where there is no line.
        contours: (H, W) ink of I_C.
        boundaries: (H, W) ink of I_B.
        p90: (4,) 90th percentile of each family's feature map over its positive values on the seen surface.
    """

    lines: Image
    features: Image
    contours: Image
    boundaries: Image
    p90: Floats


def line_maps(view: View, families: Sequence[LineFamily] = FILTERED_FAMILIES) -> LineMaps:
    """Draw the unfiltered lines of a view.

    Args:
        view: The view, at the resolution that the maps shall have.
        families: The filtered families to draw; occluding contours and boundaries always are.
    """
    shape = (view.camera.height, view.camera.width)
    lines, features = (np.zeros((len(FILTERED_FAMILIES), *shape), dtype=np.float32) for _ in range(2))
    p90 = np.ones(len(FILTERED_FAMILIES))
    for index, family in enumerate(FILTERED_FAMILIES):
        if family in families:
            p90[index] = feature_percentile(view, family)
            lines[index], carried = _draw_unfiltered(view, family)
            features[index] = np.maximum(carried / p90[index], 0.0)
    contours, boundaries = (_draw(view, family) for family in (LineFamily.CONTOURS, LineFamily.BOUNDARIES))
    return LineMaps(lines, features, contours, boundaries, p90)


def feature_percentile(view: View, family: LineFamily) -> float:
    """The unit of a filtered family's thresholds: the 90th percentile of the positive values of its feature map.

    1 where no seen pixel has a positive value: no threshold then matters.
    """
    values = view.feature_map(family)
    positive = values[values > 0]
    return float(np.percentile(positive, PERCENTILE)) if positive.size else 1.0


def network_maps(view: View) -> Image:
    """(7, H, W) depth and six shaded maps, background 1."""
    return np.concatenate([view.depth[None], view.shaded])


def line_width(view: View) -> float:
    """Width of lines in a view's own pixels."""
    return LINE_WIDTH * min(view.camera.width, view.camera.height) / 768


def _draw(view: View, family: LineFamily) -> Image:
    """(H, W) ink of a family's visible lines."""
    visible = view.visible(family)
    points = view.camera.project(visible.points)[..., :2]
    with timed(view.trace, "line_maps"):
        shape = (view.camera.height, view.camera.width)
        return draw_segments(points, np.ones(points.shape[:2]), line_width(view), shape)


def _draw_unfiltered(view: View, family: LineFamily) -> tuple[Image, Image]:
    """(H, W) ink of a family's visible lines, and the feature that they carry."""
    visible = view.visible(family)
    points = view.camera.project(visible.points)[..., :2]
    with timed(view.trace, "line_maps"):
        shape = (view.camera.height, view.camera.width)
        return draw_features(points, np.ones(points.shape[:2]), visible.feature, line_width(view), shape)
