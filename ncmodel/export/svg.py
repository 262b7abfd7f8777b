"""Drawings as SVG documents: one group a family, and one of hidden lines, which Inkscape shows as layers."""

import html

from ncmodel.export.colours import Colour, colour
from ncmodel.export.curves import fitted, parts_of
from ncmodel.export.page import MILLIMETRES, Label, Picture
from ncmodel.export.tapers import decimal, path_data
from ncmodel.types import Floats


def svg(picture: Picture) -> str:
    """An SVG document; groups are layers in Inkscape, too."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        + _size(picture)
        + ">",
        f"<title>{html.escape(_printable(picture.title))}</title>",
    ]
    if picture.record:
        lines.append(f"<metadata>{html.escape(picture.record, quote=False)}</metadata>")
    unit = _unit(picture)
    paper, style = colour(picture.background), f"mix-blend-mode:{picture.blending};stroke-linecap:butt"
    if picture.curve and not picture.colours:
        # Paths that have a shade of their own: said once, as it is longer than many of them.
        lines.append(f"<style>path[stroke]{{{style}}}</style>")
    if paper is not None:
        lines.append(f'<rect width="100%" height="100%" fill="{_hex(paper)}"/>')
    how = "" if picture.curve else f' style="{style}"'
    for family, strokes in picture.groups():
        strongest = _hex(picture.colour_of(family))
        width, dashes = unit * picture.width_of(family), picture.dashes_of(family)
        ends = "round" if dashes is None else "butt"
        lengths = "" if dashes is None else " ".join(decimal(unit * length) for length in dashes)
        dashing = f' stroke-dasharray="{lengths}"' if lengths else ""
        lines.append(
            f'<g id="{family}" inkscape:groupmode="layer" inkscape:label="{family}" fill="none" stroke="{strongest}"'
            f' stroke-width="{decimal(width)}" stroke-linecap="{ends}" stroke-linejoin="round"{dashing}>'
        )
        for points, painted in picture.paths(family, strokes):
            shade = _hex(painted)
            fade = "" if shade == strongest else f' stroke="{shade}"{how}'
            lines.append(f'<path d="{_data(points, picture.curve)}"{fade}/>')
        lines.append("</g>")
    lines += [_text(label, unit, _hex(picture.inks[1])) for label in picture.labels]
    return "\n".join([*lines, "</svg>", ""])


def _unit(picture: Picture) -> int:
    """Coordinates in a pixel: curves have whole ones, which are shorter."""
    return parts_of(picture.curve) if picture.curve else 1


def _size(picture: Picture) -> str:
    """Width, height and the coordinates within."""
    sides, unit = (picture.width, picture.height), _unit(picture)
    shown = [f"{side * MILLIMETRES:.7g}mm" if picture.physical else f"{side:.7g}" for side in sides]
    return f'width="{shown[0]}" height="{shown[1]}" viewBox="0 0 {unit * sides[0]:.7g} {unit * sides[1]:.7g}"'


def _data(points: Floats, curve: float) -> str:
    """The points of a path, or curves along them."""
    if curve:
        return fitted(points, curve).svg()
    return path_data(points, "M{:.7g} {:.7g}", " {:.7g} {:.7g}")


def _text(label: Label, unit: int, shade: str) -> str:
    x, y, size = (decimal(unit * value) for value in (*label.place, label.size))
    return (
        f'<text x="{x}" y="{y}" font-family="sans-serif" font-size="{size}"'
        f' text-anchor="middle" fill="{shade}">{html.escape(_printable(label.text))}</text>'
    )


def _hex(shade: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*shade)


def _printable(text: str) -> str:
    """Text without the control characters that XML can't hold."""
    return "".join(c if c.isprintable() else " " for c in text)
