"""Drawings as PDF documents of one page, families as layers."""

import zlib

from ncmodel.export.page import Colour, Picture, colour
from ncmodel.export.tapers import decimal, path_data, pieces

POINTS_PER_PIXEL = 0.75
"""PDF's unit is 1/72 inch; a pixel is CSS's 1/96 inch."""


def pdf(picture: Picture) -> bytes:
    """A PDF document of one page (PDF 1.5; families are layers that a viewer can switch)."""
    scale = POINTS_PER_PIXEL
    families: list[str] = []
    # From pixels with the origin on top to points with the origin at the bottom.
    content = [f"{scale} 0 0 {-scale} 0 {picture.height * scale:g} cm 1 J 1 j /Blend gs"]
    paper = colour(picture.background)
    if paper is not None:
        content.append(f"{_rgb(paper)} rg 0 0 {picture.width} {picture.height} re f")
    for family, strokes in picture.groups():
        width = picture.width_of(family)
        dashes = picture.dashes_of(family)
        content.append(f"/OC /F{len(families)} BDC {decimal(width)} w")
        if dashes is not None:
            content.append(f"[{decimal(dashes[0])} {decimal(dashes[1])}] 0 d")
        families.append(family)
        for points, opacity in pieces(strokes, width):
            shade = picture.shade(opacity)
            cap = 1 if shade == picture.shade(1.0) and dashes is None else 0
            content.append(f"{cap} J {_rgb(shade)} RG {path_data(points, '{:.7g} {:.7g} m', ' {:.7g} {:.7g} l')} S")
        if dashes is not None:
            content.append("[] 0 d")
        content.append("EMC")
    return _pdf_file(picture, "\n".join(content), families)


def _rgb(shade: Colour) -> str:
    """The operands of a PDF colour."""
    return "{:.4g} {:.4g} {:.4g}".format(*(c / 255 for c in shade))


def _pdf_file(picture: Picture, content: str, families: list[str]) -> bytes:
    """The objects of a PDF document around the content of its page."""
    width, height = picture.width * POINTS_PER_PIXEL, picture.height * POINTS_PER_PIXEL
    first_layer = 6
    layers = [f"{first_layer + n} 0 R" for n in range(len(families))]
    named = " ".join(f"/F{n} {layer}" for n, layer in enumerate(layers))
    title = b"\xfe\xff" + picture.title.encode("utf-16-be", "replace")
    packed = zlib.compress(content.encode("ascii"), 6)
    shown = f"[{' '.join(layers)}]"
    objects = [
        f"<</Type /Catalog /Pages 2 0 R /OCProperties <</OCGs {shown} /D <</Order {shown}>>>>>>",
        "<</Type /Pages /Kids [3 0 R] /Count 1>>",
        f"<</Type /Page /Parent 2 0 R /MediaBox [0 0 {width:g} {height:g}] /Contents 4 0 R"
        f" /Group <</S /Transparency /CS /DeviceRGB>>"
        f" /Resources <</ExtGState <</Blend <</BM /{picture.blending.capitalize()}>>>> /Properties <<{named}>>>>>>",
        f"<</Length {len(packed)} /Filter /FlateDecode>>\nstream\n",
        f"<</Title <{title.hex()}>>>",
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
