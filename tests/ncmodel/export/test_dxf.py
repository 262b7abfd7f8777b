"""Drawings as DXF, read again by ezdxf and drawn by its own add-on."""

import io
import re
from typing import Any, cast

import ezdxf
import numpy as np
import pytest

from ncmodel.export.dxf import dxf
from ncmodel.export.page import MILLIMETRES, Picture
from ncmodel.types import Stroke

SQUARE = np.array([[10.0, 20.0], [90.0, 20.0], [90.0, 58.0], [10.0, 20.0]])


def page(solid: bool = False) -> Picture:
    ring = Stroke("contours", SQUARE, np.ones(4))
    line = Stroke("creases", SQUARE[:2], np.full(2, 0.5))
    behind = Stroke("creases", SQUARE[1:3], np.ones(2), hidden=True)
    return Picture(200, 100, [ring, line, behind], line_width=19.2, solid=solid)


def read(data: bytes) -> Any:
    document = ezdxf.read(cast(Any, io.StringIO(data.decode())))  # type: ignore[attr-defined]
    assert not document.audit().has_issues
    return document


def test_layers_and_units() -> None:
    document = read(dxf(page()))
    assert document.units == 4
    lines = {line.dxf.layer: line for line in document.modelspace()}
    assert set(lines) == {"contours", "creases", "hidden"}
    corners = np.array(list(lines["contours"].get_points("xy")))
    np.testing.assert_allclose(corners, (SQUARE[:3] * (1, -1) + (0, 100)) * 25.4 / 96.0, atol=1e-4)
    assert lines["contours"].closed
    assert not lines["creases"].closed
    assert document.header["$LIMMAX"] == pytest.approx((200 * MILLIMETRES, 100 * MILLIMETRES))
    layers = document.layers
    # 2.5 pixels of this size are 0.66 mm; 0.7 is the nearest weight.
    assert [layers.get(name).dxf.lineweight for name in ("contours", "hidden")] == [70, 53]


def test_hidden_lines_are_dashed_on_a_layer_of_their_own() -> None:
    document, solid = read(dxf(page())), read(dxf(page(solid=True)))
    assert document.layers.get("hidden").dxf.linetype == "HIDDEN"
    tags = document.linetypes.get("HIDDEN").pattern_tags.tags
    dashes = [tag.value for tag in tags if tag.code == 49]
    assert dashes == pytest.approx([6 * MILLIMETRES, -4 * MILLIMETRES])
    assert document.layers.get("creases").dxf.linetype == "Continuous"
    assert solid.layers.get("hidden").dxf.linetype == "Continuous"


def test_same_bytes() -> None:
    assert dxf(page()) == dxf(page())


@pytest.mark.parametrize(("solid", "lines"), [(False, 2 + 4), (True, 2 + 1)])
def test_drawn_by_ezdxf(solid: bool, lines: int) -> None:
    from ezdxf.addons.drawing import layout
    from ezdxf.addons.drawing.frontend import Frontend
    from ezdxf.addons.drawing.properties import RenderContext
    from ezdxf.addons.drawing.svg import SVGBackend

    document, backend = read(dxf(page(solid))), SVGBackend()
    Frontend(RenderContext(document), backend).draw_layout(document.modelspace())
    text = backend.get_string(layout.Page(0, 0, layout.Units.mm))
    # A hidden line of 38 pixels shows four dashes of 6 with 4 between them.
    assert len(re.findall("[Mm] ", text)) == lines
