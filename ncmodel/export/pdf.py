"""Drawings as PDF documents of one page, families as layers."""

import re
import zlib

from ncmodel.export.colours import Colour, colour
from ncmodel.export.curves import fitted, parts_of
from ncmodel.export.page import Label, Picture
from ncmodel.export.tapers import decimal, path_data
from ncmodel.types import Floats

POINTS_PER_PIXEL = 0.75
"""PDF's unit is 1/72 inch; a pixel is CSS's 1/96 inch."""
LETTER = 0.5
"""Width of Helvetica's small letters, of their size."""


def pdf(picture: Picture) -> bytes:
    """A PDF document of one page (PDF 1.5; families are layers that a viewer can switch)."""
    unit = parts_of(picture.curve) if picture.curve else 1
    scale = POINTS_PER_PIXEL / unit
    families: list[str] = []
    # From pixels with the origin on top to points with the origin at the bottom.
    content = [f"{scale} 0 0 {-scale} 0 {picture.height * POINTS_PER_PIXEL:g} cm 1 J 1 j /Blend gs"]
    paper = colour(picture.background)
    if paper is not None:
        content.append(f"{_rgb(paper)} rg 0 0 {unit * picture.width:.7g} {unit * picture.height:.7g} re f")
    for family, strokes in picture.groups():
        width = picture.width_of(family)
        dashes = picture.dashes_of(family)
        content.append(f"/OC /F{len(families)} BDC {decimal(unit * width)} w")
        if dashes is not None:
            content.append(f"[{decimal(unit * dashes[0])} {decimal(unit * dashes[1])}] 0 d")
        families.append(family)
        before: set[str] = set()
        for points, shade in picture.paths(family, strokes):
            cap = 1 if shade == picture.colour_of(family) and dashes is None else 0
            look = [f"{cap} J ", f"{_rgb(shade)} RG "]
            # A file of curves is to be small: it says what has changed.
            said = "".join(operator for operator in look if not picture.curve or operator not in before)
            content.append(f"{said}{_path(points, picture.curve)} S")
            before = set(look)
        if dashes is not None:
            content.append("[] 0 d")
        content.append("EMC")
    content += [_text(label, unit, picture.inks[1]) for label in picture.labels]
    return _pdf_file(picture, "\n".join(content), families)


def _path(points: Floats, curve: float) -> str:
    """The points of a path, or curves along them."""
    if curve:
        return fitted(points, curve).pdf()
    return path_data(points, "{:.7g} {:.7g} m", " {:.7g} {:.7g} l")


def _text(label: Label, unit: int, shade: Colour) -> str:
    """A word in Helvetica, in the middle of its place by the mean width of small letters."""
    x, y, size = (unit * value for value in (*label.place, label.size))
    left = x - LETTER * size * len(label.text) / 2
    shown = label.text.encode("latin-1", "replace").hex()
    matrix = f"1 0 0 -1 {decimal(left)} {decimal(y)}"
    return f"BT /Label {decimal(size)} Tf {_rgb(shade)} rg {matrix} Tm <{shown}> Tj ET"


def _rgb(shade: Colour) -> str:
    """The operands of a PDF colour."""
    return "{:.4g} {:.4g} {:.4g}".format(*(c / 255 for c in shade))


def _pdf_file(picture: Picture, content: str, families: list[str]) -> bytes:
    """The objects of a PDF document around the content of its page."""
    width, height = picture.width * POINTS_PER_PIXEL, picture.height * POINTS_PER_PIXEL
    first_layer = 6
    layers = [f"{first_layer + n} 0 R" for n in range(len(families))]
    named = " ".join(f"/F{n} {layer}" for n, layer in enumerate(layers))
    packed = zlib.compress(content.encode("ascii"), 6)
    shown = f"[{' '.join(layers)}]"
    objects = [
        f"<</Type /Catalog /Pages 2 0 R /OCProperties <</OCGs {shown} /D <</Order {shown}>>>>>>",
        "<</Type /Pages /Kids [3 0 R] /Count 1>>",
        f"<</Type /Page /Parent 2 0 R /MediaBox [0 0 {width:g} {height:g}] /Contents 4 0 R"
        f" /Group <</S /Transparency /CS /DeviceRGB>>"
        f" /Resources <<{_fonts(picture)}/ExtGState <</Blend <</BM /{picture.blending.capitalize()}>>>>"
        f" /Properties <<{named}>>>>>>",
        f"<</Length {len(packed)} /Filter /FlateDecode>>\nstream\n",
        f"<</Title <{_utf16(picture.title)}>{_record(picture)}>>",
        *(f"<</Type /OCG /Name ({family})>>" for family in families),
    ]
    out, offsets = bytearray(b"%PDF-1.5\n%\xe2\xe3\xcf\xd3\n"), []
    for number, body in enumerate(objects, 1):
        offsets.append(len(out))
        stream = packed + b"\nendstream" if number == 4 else b""
        out += f"{number} 0 obj\n{body}".encode("ascii") + stream + b"\nendobj\n"
    start = len(out)
    table = "".join(f"{offset:010d} 00000 n \n" for offset in offsets)
    out += f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n{table}".encode("ascii")
    out += f"trailer\n<</Size {len(objects) + 1} /Root 1 0 R /Info 5 0 R>>\nstartxref\n{start}\n%%EOF\n".encode("ascii")
    return bytes(out)


def _fonts(picture: Picture) -> str:
    """The font of labels, if there are any."""
    if not picture.labels:
        return ""
    return "/Font <</Label <</Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding>>>> "


def _record(picture: Picture) -> str:
    """How the picture was made, under a key of our own among what is told of the document."""
    if not picture.record:
        return ""
    escaped = re.sub(r"([\\()])", r"\\\1", picture.record)
    return f" /NeuralContours ({escaped})"


def _utf16(text: str) -> str:
    """The digits of a text of any letters."""
    return (b"\xfe\xff" + text.encode("utf-16-be", "replace")).hex()
