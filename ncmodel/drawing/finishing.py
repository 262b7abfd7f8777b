"""From strokes as they are found to strokes as an illustrator draws them.

What is found is all that the surface says, line by line: lines of several kinds along one edge, dashes where one of
them is cut, zigzags between slivers, bits on rough places. A person draws each line once, in one stroke, and leaves out
what carries nothing.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ncmodel.drawing.crumbs import without_crumbs
from ncmodel.drawing.importance import on_outline
from ncmodel.drawing.joining import join, meet
from ncmodel.drawing.overlapping_strokes import drop_accompanying, drop_beside
from ncmodel.drawing.packed import Packed
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
SHORTEST_HIDDEN = 12.0
"""Shorter bits of hidden lines are left out: they don't show as dashes."""


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
        joined = meet(join(once, GAP * scale, view), GAP * scale, view)
        if not crumb:
            return joined
        return without_crumbs(joined, crumb * min(camera.width, camera.height), ASIDE * scale, outline)


def finish_hidden(found: Sequence[Stroke], drawn: Sequence[Stroke], view: View) -> tuple[Stroke, ...]:
    """Hidden strokes of one shade each, none along a visible one or along another.

    Args:
        found: Those of all families.
        drawn: The visible strokes.
        view: Of what.
    """
    camera = view.camera
    scale = page_scale(camera.width, camera.height)
    with timed(view.trace, "finish_hidden"):
        strokes = drop_beside([replace(stroke, hidden=True) for stroke in found], drawn, ASIDE * scale)
        if not strokes:
            return ()
        packed = Packed.of(strokes)
        # Dashes that fade, too, would be crumbs.
        shade = (packed.ink / np.maximum(packed.length, 1e-12)).tolist()
        long = np.flatnonzero(packed.length >= SHORTEST_HIDDEN * scale).tolist()
        return tuple(replace(strokes[n], alpha=np.full_like(strokes[n].alpha, shade[n])) for n in long)
