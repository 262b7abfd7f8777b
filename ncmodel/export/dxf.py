"""Drawings as DXF files, for programs of computer-aided design: one layer a family, and one of hidden lines."""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ncmodel.export.colours import PURE
from ncmodel.export.page import MILLIMETRES, Label, Picture
from ncmodel.types import Floats, Stroke

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.layouts.layout import Modelspace

CAPITAL = 0.7
"""Height of capital letters, by which DXF sizes texts, of the size of letters."""
HIDDEN_LINETYPE = "HIDDEN"
_INSUNITS_MILLIMETRES = 4
_PATTERN_THROUGH_VERTICES = 128
"""Flag of a polyline whose dashes don't start anew at each of its points."""


def dxf(picture: Picture) -> bytes:
    """A DXF file (AutoCAD 2010) in millimetres, y up, the picture's lower left corner at the origin.

    Strokes are polylines in their layer's colour, which shows black on white and white on black; they don't fade.
    """
    from ezdxf.filemanagement import new

    with _without_dates():
        document = new("R2010", units=_INSUNITS_MILLIMETRES)
        space = document.modelspace()
        for group, strokes in picture.groups():
            _add_layer(document, group, picture)
            for stroke in strokes:
                points, closed = _corners(stroke, picture.height)
                look = {"layer": group, "flags": _PATTERN_THROUGH_VERTICES}
                space.add_lwpolyline(points.tolist(), close=closed, dxfattribs=look)
        for label in picture.labels:
            _add_text(space, label, picture.height)
        space.reset_limits((0.0, 0.0), (picture.width * MILLIMETRES, picture.height * MILLIMETRES))
        text = io.StringIO()
        document.write(text)
    return text.getvalue().encode("utf-8")


def _add_layer(document: "Drawing", group: str, picture: Picture) -> None:
    from ezdxf.lldxf.const import VALID_DXF_LINEWEIGHTS

    wanted = 100.0 * picture.width_of(group) * MILLIMETRES
    weight = min(VALID_DXF_LINEWEIGHTS, key=lambda hundredths: abs(hundredths - wanted))
    layer = document.layers.add(group, lineweight=weight)
    if picture.colours and group in PURE:
        layer.rgb = PURE[group]
    dashes = picture.dashes_of(group)
    if dashes is not None:
        dash, space = (length * MILLIMETRES for length in dashes)
        document.linetypes.add(HIDDEN_LINETYPE, [dash + space, dash, -space], description="Hidden __ __ __ __")
        layer.dxf.linetype = HIDDEN_LINETYPE


def _add_text(space: "Modelspace", label: Label, height: float) -> None:
    from ezdxf.enums import TextEntityAlignment

    x, y = label.place
    text = space.add_text(label.text, height=CAPITAL * label.size * MILLIMETRES)
    text.set_placement((x * MILLIMETRES, (height - y) * MILLIMETRES), align=TextEntityAlignment.CENTER)


def _corners(stroke: Stroke, height: float) -> tuple[Floats, bool]:
    """(n, 2) points in millimetres, and whether they are a closed line, whose first point isn't repeated."""
    points = stroke.points * (MILLIMETRES, -MILLIMETRES) + (0.0, height * MILLIMETRES)
    closed = len(points) > 3 and bool((points[0] == points[-1]).all())
    points = points[:-1] if closed else points
    return points.round(4), closed


@contextmanager
def _without_dates() -> Iterator[None]:
    """Within, documents carry no date and no number drawn by lot: the same drawing gives the same bytes."""
    import ezdxf

    options = ezdxf.options  # type: ignore[attr-defined]  # it is documented
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before
