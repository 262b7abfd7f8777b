"""The classic lines at the default thresholds of the `rtsc` program; occluding contours always.

Thresholds are in units of the view's feature size: that of all vertices, unless its surface was made with rtsc's.
"""

from collections.abc import Mapping

from ncmodel.drawing.draw import draw_view, strokes_of
from ncmodel.drawing.plan import Plan
from ncmodel.drawing.thresholding import fade
from ncmodel.export.page import legible_width
from ncmodel.export.png import strokes_ink
from ncmodel.scene.view import View
from ncmodel.types import Image, LineFamily, Threshold, Thresholds

ALWAYS = (LineFamily.CONTOURS, LineFamily.BOUNDARIES)
"""In every drawing: occluding contours, and the rims of open surfaces, which are their outline just as well."""

SC = (LineFamily.SUGGESTIVE,)
RV = (LineFamily.RIDGES, LineFamily.VALLEYS)
AR = (LineFamily.APPARENT,)


def plan(families: tuple[LineFamily, ...] = (), thresholds: Thresholds | None = None) -> Plan:
    """Contours, boundaries and these families, at rtsc's default thresholds unless given."""
    return Plan((*ALWAYS, *families), thresholds or Thresholds())


METHODS: Mapping[str, Plan] = {
    "contours": plan(),
    "SC-rtsc": plan(SC),
    "RV-rtsc": plan(RV),
    "AR-rtsc": plan(AR),
    "all-rtsc": plan(SC + RV + AR),
}
"""The paper's comparisons 1 to 5, by their names there."""


def layer(view: View, family: LineFamily, threshold: float = 0.0) -> Image:
    """(H, W) ink of one family's lines at one threshold, in rtsc's units, as `draw_view` draws them.

    For many thresholds on one view: what is visible is decided once.
    """
    camera, strokes = view.camera, strokes_of(view, fade(view.visible(family), Threshold(threshold)))
    return strokes_ink(strokes, camera, legible_width(camera.width, camera.height))


def draw(view: View, plan: Plan) -> Image:
    """(H, W) ink of the drawing that a plan gives of a view; what is evaluated is what `draw` writes."""
    drawing = draw_view(view, plan)
    return drawing.ink(legible_width(drawing.width, drawing.height))
