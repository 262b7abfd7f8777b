"""From strokes as they are found to strokes as an illustrator draws them.

What is found is all that the surface says, line by line: lines of several kinds along one edge, dashes where one of
them is cut, zigzags between slivers, bits on rough places. A person draws each line once, in one stroke, and leaves out
what carries nothing.
"""

from collections.abc import Sequence

from ncmodel.drawing.crumbs import without_crumbs
from ncmodel.drawing.importance import on_outline
from ncmodel.drawing.joining import join
from ncmodel.drawing.overlapping_strokes import drop_accompanying
from ncmodel.drawing.zigzags import straightened
from ncmodel.export.page import page_scale
from ncmodel.scene.view import View
from ncmodel.tracing import timed
from ncmodel.types import Mask, Stroke

ASIDE = 3.0
"""Lines nearer to each other than this run along each other: between lines of the usual width no white would be left.
All pixels are those of a picture whose shorter side is 768."""
GAP = 12.0
"""Lines that continue each other are joined over at most this."""


def finish(strokes: Sequence[Stroke], view: View, crumb: float = 0.0) -> tuple[Stroke, ...]:
    """The strokes of all families of a view, each line once and in one.

    Args:
        strokes: As they are found.
        view: Of what.
        crumb: As a plan has it.
    """
    camera = view.camera
    scale = page_scale(camera.width, camera.height)

    def outline(some: Sequence[Stroke]) -> Mask:
        return on_outline(some, view.beyond, scale)

    with timed(view.trace, "finish"):
        once = drop_accompanying(straightened(strokes, scale), ASIDE * scale, outline)
        joined = join(once, GAP * scale, view)
        if not crumb:
            return joined
        return without_crumbs(joined, crumb * min(camera.width, camera.height), ASIDE * scale, outline)
