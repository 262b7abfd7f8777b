"""Drawings as SVG, PDF and PNG: the same strokes, widths and opacities in all three.

Vector files hold one group a family, faint families first. A stroke that tapers is cut into pieces of equal opacity,
steps of `OPACITY_STEP` apart; everything else is one path. Paper is left unpainted unless a background is asked for;
PNG files are black on white then.
"""

import html
import itertools
import re
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ncmodel.errors import UsageError
from ncmodel.raster import draw_segments
from ncmodel.types import Floats, Image, Ints, LineFamily, Stroke

WIDTH = 2.5
"""Line width at 768 pixels, unless told otherwise."""
REFERENCE_SIDE = 768
"""The shorter side, in pixels, at which widths are stated; they grow with it."""
RELATIVE_WIDTH = {LineFamily.RIDGES.value: 0.8, LineFamily.VALLEYS.value: 0.8}
"""Widths of families relative to the others', as rtsc draws them: 2 pixels where others have 2.5."""
OPACITY_STEP = 1 / 16
"""Opacities in vector files are multiples of this."""
POINTS_PER_PIXEL = 0.75
"""PDF's unit is 1/72 inch; a pixel is CSS's 1/96 inch."""

_GROUPS = ("image", "valleys", "ridges", "suggestive", "apparent", "creases", "boundaries", "contours")
_NAMED = {"white": (255, 255, 255), "black": (0, 0, 0)}


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

    def groups(self) -> Iterator[tuple[str, list[Stroke]]]:
        """Families that have strokes, with their strokes, in the order in which they are painted."""
        present = {stroke.family for stroke in self.strokes}
        for family in [name for name in _GROUPS if name in present] + sorted(present.difference(_GROUPS)):
            yield family, [stroke for stroke in self.strokes if stroke.family == family]


def colour(name: str | None) -> tuple[int, int, int] | None:
    """Red, green and blue in 0..255; None for None and "transparent".

    Raises:
        UsageError: `name` isn't a colour.
    """
    if name is None or name == "transparent":
        return None
    if name in _NAMED:
        return _NAMED[name]
    if re.fullmatch("#[0-9a-fA-F]{6}", name):
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
    paper = colour(picture.background)
    if picture.background == "transparent":
        pixels = np.zeros((*cover.shape, 4), dtype=np.uint8)
        pixels[..., 3] = _bytes(cover)
    elif paper is None or len(set(paper)) == 1:
        pixels = _bytes((1.0 - cover) * (255 if paper is None else paper[0]) / 255)
    else:
        pixels = _bytes((1.0 - cover)[..., None] * (np.array(paper[::-1], dtype=np.float32) / 255))
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
        lines.append('<rect width="100%" height="100%" fill="#{:02x}{:02x}{:02x}"/>'.format(*paper))
    for family, strokes in picture.groups():
        lines.append(
            f'<g id="{family}" inkscape:groupmode="layer" inkscape:label="{family}" fill="none" stroke="#000"'
            f' stroke-width="{picture.width_of(family):.4g}" stroke-linecap="round" stroke-linejoin="round">'
        )
        for points, level, whole in _pieces(strokes):
            fade = "" if level == 1 else f' stroke-opacity="{level:.4g}"'
            cap = "" if whole else ' stroke-linecap="butt"'
            lines.append(f'<path d="{_path(points, "M{:g} {:g}", " {:g} {:g}")}"{fade}{cap}/>')
        lines.append("</g>")
    return "\n".join([*lines, "</svg>", ""])


def pdf(picture: Picture) -> bytes:
    """A PDF document of one page (PDF 1.5; families are layers that a viewer can switch)."""
    scale = POINTS_PER_PIXEL
    families: list[str] = []
    levels: set[float] = {1.0}
    # From pixels with the origin on top to points with the origin at the bottom.
    content = [f"{scale} 0 0 {-scale} 0 {picture.height * scale:g} cm 1 J 1 j 0 G"]
    paper = colour(picture.background)
    if paper is not None:
        content.append(
            "{:.4g} {:.4g} {:.4g} rg".format(*(c / 255 for c in paper)) + f" 0 0 {picture.width} {picture.height} re f"
        )
    for family, strokes in picture.groups():
        content.append(f"/OC /F{len(families)} BDC {picture.width_of(family):.4g} w")
        families.append(family)
        for points, level, whole in _pieces(strokes):
            levels.add(level)
            content.append(f"/A{level:g} gs {1 if whole else 0} J {_path(points, '{:g} {:g} m', ' {:g} {:g} l')} S")
        content.append("EMC")
    return _pdf_file(picture, "\n".join(content), families, sorted(levels))


def _pieces(strokes: Sequence[Stroke]) -> Iterator[tuple[Floats, float, bool]]:
    """Visible parts of strokes of equal opacity: points (n, 2), the opacity, whether it is all of its stroke."""
    points = np.concatenate([stroke.points for stroke in strokes])
    alpha = np.concatenate([np.clip(stroke.alpha, 0.0, 1.0) for stroke in strokes])
    first = np.concatenate([[0], np.cumsum([len(stroke.points) for stroke in strokes])])
    level = np.floor(alpha / OPACITY_STEP + 0.5).astype(np.int64)
    cut_points, piece_level, piece_first, piece_stroke = _cut(points, alpha, level, first, OPACITY_STEP)
    pieces_of = np.bincount(piece_stroke, minlength=len(strokes))
    for n, (begin, end) in enumerate(itertools.pairwise(piece_first.tolist())):
        if piece_level[n] > 0:
            yield cut_points[begin:end], float(piece_level[n] * OPACITY_STEP), bool(pieces_of[piece_stroke[n]] == 1)


@njit(cache=True, nogil=True)
def _cut(points: Floats, alpha: Floats, level: Ints, first: Ints, step: float) -> tuple[Floats, Ints, Ints, Ints]:
    """Polylines cut where their opacity, linear between points, passes from one level to the next.

    Returns:
        The pieces' points, and of each piece its level, where it starts (one more entry: where the last one ends) and
        its polyline.
    """
    cuts = 0
    for c in range(len(first) - 1):
        for i in range(first[c], first[c + 1] - 1):
            cuts += abs(level[i + 1] - level[i])
    cut_points = np.empty((len(points) + 2 * cuts, 2))
    count = len(first) - 1 + cuts
    piece_level, owner, piece_first = (
        np.empty(count, np.int64),
        np.empty(count, np.int64),
        np.zeros(count + 1, np.int64),
    )
    size, piece = 0, 0
    for c in range(len(first) - 1):
        for i in range(first[c], first[c + 1]):
            cut_points[size] = points[i]
            size += 1
            last = i == first[c + 1] - 1
            now, then = level[i], level[i] if last else level[i + 1]
            while now != then:
                up = 1 if then > now else -1
                at = ((now + 0.5 * up) * step - alpha[i]) / (alpha[i + 1] - alpha[i])
                for _ in range(2):
                    cut_points[size] = points[i] + at * (points[i + 1] - points[i])
                    size += 1
                piece_level[piece], owner[piece], piece_first[piece + 1] = now, c, size - 1
                piece += 1
                now += up
            if last:
                piece_level[piece], owner[piece], piece_first[piece + 1] = now, c, size
                piece += 1
    return cut_points, piece_level, piece_first, owner


def _path(points: Floats, move: str, line: str) -> str:
    """Coordinates in hundredths of a pixel: `move` and `line` are formats of the first and of every other point."""
    pairs = points.round(2).tolist()
    return move.format(*pairs[0]) + "".join([line.format(*pair) for pair in pairs[1:]])


def _bytes(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.asarray(np.round(values * 255), dtype=np.uint8)


def _printable(text: str) -> str:
    """Text without the control characters that XML can't hold."""
    return "".join(c if c.isprintable() else " " for c in text)


def _pdf_file(picture: Picture, content: str, families: list[str], levels: list[float]) -> bytes:
    """The objects of a PDF document around the content of its page."""
    width, height = picture.width * POINTS_PER_PIXEL, picture.height * POINTS_PER_PIXEL
    first_layer = 6
    layers = [f"{first_layer + n} 0 R" for n in range(len(families))]
    states = " ".join(f"/A{level:g} <</CA {level:g}>>" for level in levels)
    named = " ".join(f"/F{n} {layer}" for n, layer in enumerate(layers))
    title = b"\xfe\xff" + picture.title.encode("utf-16-be", "replace")
    packed = zlib.compress(content.encode("ascii"), 6)
    shown = f"[{' '.join(layers)}]"
    objects = [
        f"<</Type /Catalog /Pages 2 0 R /OCProperties <</OCGs {shown} /D <</Order {shown}>>>>>>",
        "<</Type /Pages /Kids [3 0 R] /Count 1>>",
        f"<</Type /Page /Parent 2 0 R /MediaBox [0 0 {width:g} {height:g}] /Contents 4 0 R"
        f" /Resources <</ExtGState <<{states}>> /Properties <<{named}>>>>>>",
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
