"""Drawings as SVG documents: one group a family, and one of hidden lines, which Inkscape shows as layers."""

import html

from ncmodel.export.page import Colour, Picture, colour
from ncmodel.export.tapers import decimal, path_data, pieces


def svg(picture: Picture) -> str:
    """An SVG document; groups are layers in Inkscape, too."""
    size = f'width="{picture.width}" height="{picture.height}" viewBox="0 0 {picture.width} {picture.height}"'
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        + size
        + ">",
        f"<title>{html.escape(_printable(picture.title))}</title>",
    ]
    paper = colour(picture.background)
    if paper is not None:
        lines.append(f'<rect width="100%" height="100%" fill="{_hex(paper)}"/>')
    strongest, style = _hex(picture.shade(1.0)), f"mix-blend-mode:{picture.blending};stroke-linecap:butt"
    for family, strokes in picture.groups():
        width, dashes = picture.width_of(family), picture.dashes_of(family)
        ends = "round" if dashes is None else "butt"
        dashing = "" if dashes is None else f' stroke-dasharray="{decimal(dashes[0])} {decimal(dashes[1])}"'
        lines.append(
            f'<g id="{family}" inkscape:groupmode="layer" inkscape:label="{family}" fill="none" stroke="{strongest}"'
            f' stroke-width="{decimal(width)}" stroke-linecap="{ends}" stroke-linejoin="round"{dashing}>'
        )
        for points, opacity in pieces(strokes, width):
            shade = _hex(picture.shade(opacity))
            fade = "" if shade == strongest else f' stroke="{shade}" style="{style}"'
            lines.append(f'<path d="{path_data(points, "M{:.7g} {:.7g}", " {:.7g} {:.7g}")}"{fade}/>')
        lines.append("</g>")
    return "\n".join([*lines, "</svg>", ""])


def _hex(shade: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*shade)


def _printable(text: str) -> str:
    """Text without the control characters that XML can't hold."""
    return "".join(c if c.isprintable() else " " for c in text)
