"""From a scan's file to a reference: which way, against what, and what came of it."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from eval.measures.thinning import binarise
from eval.people.elastic import bent
from eval.people.outline import DrawnOutline, OpenOutlineError, drawn_outline, filled
from eval.people.registration import (
    WAYS,
    NotRegisteredError,
    Registration,
    by_corners,
    by_rendering,
    turned,
)
from ncmodel.errors import ArgumentError, InputError
from ncmodel.images import read_grey
from ncmodel.types import Image

ELASTIC = "bent onto the outline (elastic): part of the drawing's real error is gone, don't measure accuracy on it"


@dataclass(frozen=True)
class Page:
    """How a drawing's picture lies on its page.

    Attributes:
        way: One of `WAYS`.
        size: (width, height) of the picture, pixels.
        turn: Degrees that the scan is turned clockwise first, by quarters.
        millimetres: How wide the picture is on the page, if it is known.
        place: Where the drawing begins, in pixels of a rendering from its upper left corner.
        elastic: Bend it onto the outline, too.
    """

    way: str
    size: tuple[int, int]
    turn: int = 0
    millimetres: float | None = None
    place: tuple[float, float] = (0.0, 0.0)
    elastic: bool = False

    def __post_init__(self) -> None:
        if self.way not in WAYS:
            raise ArgumentError("by", repr(self.way), f"one of {', '.join(WAYS)}")
        if self.millimetres is not None and not 0.0 < self.millimetres < 1e5:
            raise ArgumentError("millimetres", str(self.millimetres), "how wide the picture is on the page")


@dataclass(frozen=True, eq=False)
class Scanned:
    """A drawing taken from a scan.

    Attributes:
        ink: (H, W) it, 1 = line.
        registration: Where it was.
        notes: What the reader should know.
    """

    ink: Image
    registration: Registration
    notes: tuple[str, ...] = ()

    def to_record(self) -> dict[str, Any]:
        """What was found, for JSON."""
        found = self.registration
        return {
            "by": found.way,
            "homography": np.round(found.homography, 9).tolist(),
            "width": found.width,
            "height": found.height,
            "matches": found.matches,
            "mm_per_pixel": found.mm_per_pixel,
            "ink": round(float(binarise(self.ink).mean()), 5),
            "notes": list(self.notes),
        }


def take_drawing(path: Path, page: Page, rendering: Image | None = None) -> Scanned:
    """Take a drawing from a scan or photo of its page.

    Args:
        path: The scan.
        page: How the picture lies on the page.
        rendering: (h, w) what the drawing shows, as a picture of its size: to register by, or to bend onto.

    Raises:
        ArgumentError: What is asked for needs a rendering.
        InputError: The scan can't be read, or the picture isn't found in it.
    """
    needs = {"by": page.way == "rendering", "elastic": page.elastic}
    for parameter, needed in needs.items():
        if needed and rendering is None:
            lacking = f"{page.way} and no rendering" if parameter == "by" else "no rendering to bend onto"
            raise ArgumentError(parameter, lacking, "a rendering, or a mesh and its camera")
    scan = turned(read_grey(path), page.turn)
    try:
        if page.way == "rendering" and rendering is not None:
            registration = by_rendering(scan, rendering, page.place, page.millimetres)
        else:
            registration = by_corners(scan, page.way, page.size, page.millimetres)
    except NotRegisteredError as error:
        raise InputError(path, str(error), _EXPECTED[page.way]) from error
    found = Scanned(registration.drawing(scan), registration)
    return _bent(found, rendering, path) if page.elastic and rendering is not None else found


_EXPECTED = {
    "marks": "a page with four filled discs or squares, their middles the picture's corners",
    "frame": "a page with a printed rectangle around the picture, all of it in the scan",
    "page": "a sheet on something darker, all four edges in the scan",
    "rendering": "the rendering printed on the page, beside the drawing or pale below it",
}


def _bent(found: Scanned, rendering: Image | None, path: Path) -> Scanned:
    assert rendering is not None, "bending is asked for with a rendering"
    goal = filled(rendering < rendering.max() - 0.004)
    try:
        ink = bent(found.ink, drawn_outline(found.ink), DrawnOutline.of(goal))
    except OpenOutlineError as error:
        raise InputError(path, str(error), "a closed outline to bend") from error
    return replace(found, ink=ink, notes=(*found.notes, ELASTIC))
