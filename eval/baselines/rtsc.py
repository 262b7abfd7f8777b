"""The classic lines at the default thresholds of the `rtsc` program; occluding contours always.

Thresholds are in units of the view's feature size: that of all vertices, unless its surface was made with rtsc's.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ncmodel.drawing.thresholding import fade
from ncmodel.export.rasterize import draw_segments
from ncmodel.scene.view import View
from ncmodel.types import Image, LineFamily, Thresholds

WIDTH = 2.5 / 768
"""Line width, as a share of the picture's shorter side; at least a pixel, else small pictures show nothing."""

ALWAYS = (LineFamily.CONTOURS, LineFamily.BOUNDARIES)
"""In every drawing: occluding contours, and the rims of open surfaces, which are their outline just as well."""

SC = (LineFamily.SUGGESTIVE,)
RV = (LineFamily.RIDGES, LineFamily.VALLEYS)
AR = (LineFamily.APPARENT,)


@dataclass(frozen=True)
class RtscSettings:
    """Which lines are drawn, and from which strength on.

    Attributes:
        families: The families besides contours and boundaries.
        thresholds: In rtsc's dimensionless units; the defaults are rtsc's.
    """

    families: tuple[LineFamily, ...] = ()
    thresholds: Thresholds = field(default_factory=Thresholds)

    @property
    def chosen(self) -> dict[str, float | None]:
        """The threshold of each family that is drawn besides contours and boundaries."""
        return {family.value: self.thresholds.of(family) for family in self.families}


METHODS: Mapping[str, RtscSettings] = {
    "contours": RtscSettings(),
    "SC-rtsc": RtscSettings(SC),
    "RV-rtsc": RtscSettings(RV),
    "AR-rtsc": RtscSettings(AR),
    "all-rtsc": RtscSettings(SC + RV + AR),
}
"""The paper's comparisons 1 to 5, by their names there."""


def draw(view: View, settings: RtscSettings) -> Image:
    """(H, W) ink of the visible lines."""
    layers = [layer(view, family) for family in ALWAYS]
    for family in settings.families:
        threshold = settings.thresholds.of(family)
        if threshold is not None:
            layers.append(layer(view, family, threshold))
    return np.asarray(np.maximum.reduce(layers))


def layer(view: View, family: LineFamily, threshold: float = 0.0) -> Image:
    """(H, W) ink of one family's visible lines at one threshold, in rtsc's units."""
    segments = fade(view.visible(family), threshold)
    points = view.camera.project(segments.points)[..., :2]
    shape = (view.camera.height, view.camera.width)
    return draw_segments(points, segments.alpha, max(1.0, WIDTH * min(shape)), shape)
