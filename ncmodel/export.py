"""Drawings as SVG, PDF and PNG: the same strokes, widths and shades in all three.

Vector files hold one group a family, faint families first. A stroke that tapers is cut into pieces of one shade each;
everything else is one path. Shades are colours between ink and paper, not opacities, and blended so that the stronger
one shows where strokes cross or pieces overlap, as they do by `OVERLAP`: a PNG is composited so; opacities would add.
Programs that know no blending paint the later stroke over the earlier one. Paper is left unpainted unless a background
is asked for; PNG files are black on white then.
"""

import html
import itertools
import math
import re
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ncmodel.errors import UsageError
from ncmodel.kernels import kernel
from ncmodel.raster import draw_segments
from ncmodel.types import Floats, Image, Ints, LineFamily, Stroke

WIDTH = 2.5
"""Line width at 768 pixels, unless told otherwise."""
REFERENCE_SIDE = 768
"""The shorter side, in pixels, at which widths are stated; they grow with it."""
RELATIVE_WIDTH = {LineFamily.RIDGES.value: 0.8, LineFamily.VALLEYS.value: 0.8}
"""Widths of families relative to the others', as rtsc draws them: 2 pixels where others have 2.5."""
OPACITY_STEP = 1 / 32
"""Where opacity changes by this, a piece of a taper ends, unless it is shorter than wide."""
OVERLAP = 0.3
"""Pixels that pieces reach beyond their ends, lest their smooth edges leave light seams."""
FAINTEST = 0.5 / 255
"""Opacity below which nothing shows in 8 bits."""
POINTS_PER_PIXEL = 0.75
"""PDF's unit is 1/72 inch; a pixel is CSS's 1/96 inch."""

_GROUPS = ("image", "valleys", "ridges", "suggestive", "apparent", "creases", "boundaries", "contours")
_WHITE, _BLACK = (255, 255, 255), (0, 0, 0)
_NAMED = {"white": _WHITE, "black": _BLACK}
_LUMA = (0.299, 0.587, 0.114)


Colour = tuple[int, int, int]
"""Red, green and blue in 0..255."""


@dataclass(frozen=True, eq=False)
class Picture:
    """Strokes on a page, ready to be written.

    Attributes:
        width: Pixels.
        height: Pixels.
        strokes: What is drawn.
        line_width: Pixels, for a picture whose shorter side is `REFERENCE_SIDE`.
        background: "#rrggbb", "white", "black"; None leaves the paper as it is (white, in a PNG) and "transparent" does
            so in a PNG, too.
        title: What is shown.

    Raises:
        UsageError: The line width isn't a positive number, or the background is none of these.
    """

    width: int
    height: int
    strokes: Sequence[Stroke]
    line_width: float = WIDTH
    background: str | None = None
    title: str = "drawing"

    def __post_init__(self) -> None:
        if not 0.0 < self.line_width < np.inf:
            raise UsageError(f"--width: found {self.line_width}, expected a positive number of pixels")
        colour(self.background)

    def width_of(self, family: str) -> float:
        """The width of a family's lines, in this picture's pixels."""
        scale = min(self.width, self.height) / REFERENCE_SIDE
        return self.line_width * RELATIVE_WIDTH.get(family, 1.0) * scale

    @property
    def inks(self) -> tuple[Colour, Colour]:
        """The colours of paper and lines: black on light paper, white on dark paper."""
        paper = colour(self.background) or _WHITE
        return paper, _BLACK if np.dot(paper, _LUMA) >= 127.5 else _WHITE

    def shade(self, opacity: float) -> Colour:
        """The colour of a line of an opacity in [0, 1]."""
        paper, line = self.inks
        red, green, blue = (round(p + opacity * (q - p)) for p, q in zip(paper, line, strict=True))
        return red, green, blue

    @property
    def blending(self) -> str:
        """The blend mode, in CSS, in which the stronger of two shades shows."""
        return "darken" if self.inks[1] == _BLACK else "lighten"

    def groups(self) -> Iterator[tuple[str, list[Stroke]]]:
        """Families that have strokes, with their strokes, in the order in which they are painted."""
        present = {stroke.family for stroke in self.strokes}
        for family in [name for name in _GROUPS if name in present] + sorted(present.difference(_GROUPS)):
            yield family, [stroke for stroke in self.strokes if stroke.family == family]


def colour(name: str | None) -> Colour | None:
    """The colour of that name; None for None and "transparent".

    Raises:
        UsageError: `name` isn't a colour.
    """
    if name is None or name == "transparent":
        return None
    if name in _NAMED:
        return _NAMED[name]
    if isinstance(name, str) and re.fullmatch("#[0-9a-fA-F]{6}", name):
        value = int(name[1:], 16)
        return value >> 16, value >> 8 & 255, value & 255
    raise UsageError(f"--background: found {name!r}, expected #rrggbb, white, black or transparent")


def ink(picture: Picture) -> Image:
    """(H, W) ink in [0, 1]."""
    image = np.zeros((picture.height, picture.width), dtype=np.float32)
    for family, strokes in picture.groups():
        points = np.concatenate([np.stack([s.points[:-1], s.points[1:]], axis=1) for s in strokes])
        alpha = np.concatenate([np.stack([s.alpha[:-1], s.alpha[1:]], axis=1) for s in strokes])
        image = draw_segments(points, alpha, picture.width_of(family), image.shape, onto=image)
    return image


def png(picture: Picture) -> bytes:
    """A PNG file: grey on white, colours on a background, or black with transparency."""
    import cv2

    cover = ink(picture)
    paper, line = (np.array(c[::-1], dtype=np.float32) / 255 for c in picture.inks)
    if picture.background == "transparent":
        pixels = np.zeros((*cover.shape, 4), dtype=np.uint8)
        pixels[..., 3] = _bytes(cover)
    elif len(set(paper.tolist())) == 1:
        pixels = _bytes(paper[0] + cover * (line[0] - paper[0]))
    else:
        pixels = _bytes(paper + cover[..., None] * (line - paper))
    return bytes(cv2.imencode(".png", pixels, [cv2.IMWRITE_PNG_COMPRESSION, 4])[1])


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
        width = picture.width_of(family)
        lines.append(
            f'<g id="{family}" inkscape:groupmode="layer" inkscape:label="{family}" fill="none" stroke="{strongest}"'
            f' stroke-width="{_decimal(width)}" stroke-linecap="round" stroke-linejoin="round">'
        )
        for points, opacity in _pieces(strokes, width):
            shade = _hex(picture.shade(opacity))
            fade = "" if shade == strongest else f' stroke="{shade}" style="{style}"'
            lines.append(f'<path d="{_path(points, "M{:.7g} {:.7g}", " {:.7g} {:.7g}")}"{fade}/>')
        lines.append("</g>")
    return "\n".join([*lines, "</svg>", ""])


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
        content.append(f"/OC /F{len(families)} BDC {_decimal(width)} w")
        families.append(family)
        for points, opacity in _pieces(strokes, width):
            shade = picture.shade(opacity)
            cap = 1 if shade == picture.shade(1.0) else 0
            content.append(f"{cap} J {_rgb(shade)} RG {_path(points, '{:.7g} {:.7g} m', ' {:.7g} {:.7g} l')} S")
        content.append("EMC")
    return _pdf_file(picture, "\n".join(content), families)


def _pieces(strokes: Sequence[Stroke], shortest: float) -> Iterator[tuple[Floats, float]]:
    """Visible parts of strokes that have about one opacity: points (n, 2) and that opacity.

    Args:
        strokes: The strokes.
        shortest: Pixels; parts are no shorter, but for the last one of a stroke.
    """
    points = np.concatenate([stroke.points for stroke in strokes])
    alpha = np.concatenate([np.clip(stroke.alpha, 0.0, 1.0) for stroke in strokes])
    first = np.concatenate([[0], np.cumsum([len(stroke.points) for stroke in strokes])])
    cut_points, opacity, starts = _cut(points, alpha, first, OPACITY_STEP, shortest)
    for n, (begin, end) in enumerate(itertools.pairwise(starts.tolist())):
        if opacity[n] >= FAINTEST:
            yield cut_points[begin:end], float(opacity[n])


@kernel
def _cut(points: Floats, alpha: Floats, first: Ints, step: float, shortest: float) -> tuple[Floats, Floats, Ints]:
    """Polylines cut where their opacity, linear between points, has changed by `step` since the last cut.

    Returns:
        The pieces' points, and of each piece its mean opacity and where it starts (one more: where the last one ends).
    """
    made = [(points[0, 0], points[0, 1]) for _ in range(0)]
    opacity, starts = [0.0 for _ in range(0)], [0]
    for c in range(len(first) - 1):
        made.append((points[first[c], 0], points[first[c], 1]))
        low = high = alpha[first[c]]
        length, amount = 0.0, 0.0
        for i in range(first[c], first[c + 1] - 1):
            dx, dy, rise = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1], alpha[i + 1] - alpha[i]
            whole, at = math.hypot(dx, dy), 0.0
            while at < 1.0 and whole > 0.0:
                limit = low + step if rise > 0 else high - step
                changed = (limit - alpha[i]) / rise if rise != 0 else np.inf
                to = min(max(changed, at + (shortest - length) / whole), 1.0)
                here, there = alpha[i] + at * rise, alpha[i] + to * rise
                low, high = min(low, there), max(high, there)
                length += (to - at) * whole
                amount += (to - at) * whole * (here + there) / 2
                beyond = to if to == 1.0 else to + OVERLAP / whole
                made.append((points[i, 0] + beyond * dx, points[i, 1] + beyond * dy))
                if to < 1.0:
                    before = to - OVERLAP / whole
                    opacity.append(amount / length)
                    starts.append(len(made))
                    made.append((points[i, 0] + before * dx, points[i, 1] + before * dy))
                    low, high, length, amount = there, there, 0.0, 0.0
                at = to
        opacity.append(amount / length if length > 0 else low)
        starts.append(len(made))
    return np.array(made), np.array(opacity), np.array(starts)


def _path(points: Floats, move: str, line: str) -> str:
    """Coordinates in hundredths of a pixel: `move` and `line` are formats of the first and of every other point."""
    pairs = points.round(2).tolist()
    return move.format(*pairs[0]) + "".join([line.format(*pair) for pair in pairs[1:]])


def _decimal(value: float) -> str:
    """Four digits without an exponent, which PDF doesn't know."""
    return np.format_float_positional(value, precision=4, fractional=False, trim="-")


def _hex(shade: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*shade)


def _rgb(shade: Colour) -> str:
    """The operands of a PDF colour."""
    return "{:.4g} {:.4g} {:.4g}".format(*(c / 255 for c in shade))


def _bytes(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.asarray(np.round(values * 255), dtype=np.uint8)


def _printable(text: str) -> str:
    """Text without the control characters that XML can't hold."""
    return "".join(c if c.isprintable() else " " for c in text)


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
