"""Surfaces made of rows of vertices, as modellers make them: turned, drawn along a path, bent sheets, bevelled blocks.

Rows lie close at edges, so that edges are crisp or rounded by one to three rows of faces.
"""

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from dataset_tools.modelling.fields import UPRIGHT, frame_along
from dataset_tools.modelling.sculpting import Surface
from ncmodel.types import Floats, Ints


def merged(surfaces: Sequence[Surface]) -> Surface:
    """Several surfaces as one, shells that may pass through each other."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in surfaces)])
    faces = [triangles + start for (_, triangles), start in zip(surfaces, starts[:-1], strict=True)]
    return np.concatenate([vertices for vertices, _ in surfaces]), np.concatenate(faces)


def moved(
    surface: Surface, offset: ArrayLike = (0, 0, 0), axes: Floats = UPRIGHT, scale: ArrayLike = (1, 1, 1)
) -> Surface:
    """A surface stretched along its own axes, turned so that they become the rows of `axes`, and moved."""
    vertices, faces = surface
    stretch = np.broadcast_to(np.asarray(scale, dtype=float), (3,))
    turned_over = bool(stretch.prod() * np.linalg.det(axes) < 0)
    placed = (vertices * stretch) @ axes + np.asarray(offset, dtype=float)
    return placed, np.ascontiguousarray(faces[:, ::-1]) if turned_over else faces


def mirrored(surface: Surface, axis: int) -> Surface:
    """A surface and its mirror image across the plane where a coordinate is 0, as two shells."""
    return merged([surface, moved(surface, scale=np.where(np.arange(3) == axis, -1.0, 1.0))])


def grid(rows: int, columns: int, around: bool) -> Ints:
    """Triangles of rows of vertices; `around` joins each row's end to its beginning."""
    r = np.arange(rows - 1)[:, None] * columns
    c = np.arange(columns if around else columns - 1)[None, :]
    a, b = r + c, r + (c + 1) % columns
    quads = np.stack([a, b, b + columns, a + columns], axis=-1).reshape(-1, 4)
    # Diagonals alternate, so that none of the two directions is favoured.
    odd = ((r // columns + c) % 2 == 1).ravel()
    first = np.where(odd[:, None], quads[:, [0, 1, 2]], quads[:, [0, 1, 3]])
    second = np.where(odd[:, None], quads[:, [0, 2, 3]], quads[:, [1, 2, 3]])
    return np.concatenate([first, second]).astype(np.int64)


def loft(sections: ArrayLike, caps: bool = True) -> Surface:
    """Closed sections, (m, n, 3), joined from one to the next, and closed at both ends by fans of two rings.

    Sections run anticlockwise as seen against the direction in which they follow each other.
    """
    rows = np.asarray(sections, dtype=float)
    count, sides = rows.shape[:2]
    if not caps:
        return rows.reshape(-1, 3), grid(count, sides, around=True)
    ends = rows[0].mean(axis=0), rows[-1].mean(axis=0)
    inner = [end + 0.5 * (row - end) for end, row in zip(ends, (rows[0], rows[-1]), strict=True)]
    rows = np.concatenate([inner[0][None], rows, inner[1][None]])
    body = grid(count + 2, sides, around=True)
    here = np.arange(sides)
    there, last, poles = np.roll(here, -1), (count + 1) * sides, (count + 2) * sides
    bottom = np.stack([np.full(sides, poles), there, here], axis=1)
    top = np.stack([np.full(sides, poles + 1), last + here, last + there], axis=1)
    return np.concatenate([rows.reshape(-1, 3), np.stack(ends)]), np.concatenate([body, bottom, top])


def lathe(profile: ArrayLike, sides: int, flutes: Floats | None = None) -> Surface:
    """A profile of radius and height, (m, 2), turned about the y axis, from outside bottom up (and down inside).

    Args:
        profile: Its corners stay crisp.
        sides: Vertices around.
        flutes: (m, sides) factors of the radius, for fluting, facets and patterns.
    """
    outline = np.asarray(profile, dtype=float)
    angle = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    radius = np.maximum(outline[:, :1], 1e-4) * (1.0 if flutes is None else flutes)
    height = np.broadcast_to(outline[:, 1:], (len(outline), sides))
    return loft(np.stack([radius * np.sin(angle), height, radius * np.cos(angle)], axis=-1))


def rounded_profile(corners: ArrayLike, radius: float | Sequence[float], rows: int = 3) -> Floats:
    """A polyline with its inner corners rounded by arcs of a few rows (one row: a bevel)."""
    points = np.asarray(corners, dtype=float)
    radii = np.broadcast_to(np.asarray(radius, dtype=float), len(points))
    out = [points[:1]]
    for before, here, after, r in zip(points[:-2], points[1:-1], points[2:], radii[1:-1], strict=True):
        a, b = before - here, after - here
        reach = min(r, 0.45 * float(np.linalg.norm(a)), 0.45 * float(np.linalg.norm(b)))
        start, end = here + reach * a / np.linalg.norm(a), here + reach * b / np.linalg.norm(b)
        t = np.linspace(0, 1, rows + 1)[:, None]
        out.append((1 - t) ** 2 * start + 2 * t * (1 - t) * here + t**2 * end if reach > 0 else here[None])
    return np.concatenate([*out, points[-1:]])


def refined(profile: Floats, step: float) -> Floats:
    """A polyline with points added, so that none is farther than `step` from the next."""
    out = [profile[:1]]
    for a, b in itertools.pairwise(profile):
        pieces = max(1, int(np.ceil(np.linalg.norm(b - a) / step)))
        out.append(a + (b - a) * np.linspace(0, 1, pieces + 1)[1:, None])
    return np.concatenate(out)


def tube(path: ArrayLike, radii: ArrayLike, sides: int = 16, section: Floats | None = None) -> Surface:
    """A section drawn along a path, carried without twisting.

    Args:
        path: (m, 3).
        radii: (m,) or one: scale of the section there.
        sides: Of a round one.
        section: (n, 2) of another one, anticlockwise.
    """
    points = np.asarray(path, dtype=float)
    size = np.broadcast_to(np.asarray(radii, dtype=float), len(points))
    if section is None:
        angle = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
        section = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    tangent = np.gradient(points, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
    across = frame_along(tangent[0])[0]
    rows = []
    for place, along, r in zip(points, tangent, size, strict=True):
        across = across - (across @ along) * along
        across = across / np.linalg.norm(across)
        rows.append(place + r * (section[:, :1] * across + section[:, 1:] * np.cross(along, across)))
    return loft(rows)


def extrusion(outline: ArrayLike, depth: float, bevel: float = 0.0, rows: int = 2, divisions: int = 4) -> Surface:
    """A star-shaped outline in x and y, anticlockwise, drawn along z from 0 to `depth`, its rims bevelled."""
    flat = np.asarray(outline, dtype=float)
    middle = flat.mean(axis=0)
    size = np.linalg.norm(flat - middle, axis=1).mean()
    turn = np.linspace(0.0, np.pi / 2, rows + 1)
    rim = np.stack([1 - bevel / size * (1 - np.sin(turn)), bevel * (1 - np.cos(turn))], axis=1)
    inner = np.linspace(bevel, depth - bevel, divisions + 1)[1:-1]
    scale = np.concatenate([rim[:, 0], np.ones(len(inner)), rim[::-1, 0]])
    level = np.concatenate([rim[:, 1], inner, depth - rim[::-1, 1]])
    rings = middle + scale[:, None, None] * (flat - middle)
    return loft(np.concatenate([rings, np.broadcast_to(level[:, None, None], (*rings.shape[:2], 1))], axis=-1))


def block(half: ArrayLike, rounding: float, rows: int = 2, divisions: int = 4) -> Surface:
    """A box about the origin whose edges are rounded by `rows` rows of faces, its sides in `divisions` squares."""
    sides = np.asarray(half, dtype=float)
    rounding = min(rounding, 0.95 * float(sides.min()))
    corner = np.tan(np.linspace(-np.pi / 4, 0.0, rows + 1))[:-1]
    surfaces = []
    for axis in range(3):
        others = [(axis + 1) % 3, (axis + 2) % 3]
        lines, bends = [], []
        for other in others:
            flat = np.linspace(-1, 1, divisions + 1) * (sides[other] - rounding)
            edge = np.full(rows, sides[other] - rounding)
            lines.append(np.concatenate([-edge, flat, edge]))
            bends.append(np.concatenate([corner, np.zeros(divisions + 1), -corner[::-1]]))
        point, bend = np.zeros((len(lines[0]), len(lines[1]), 3)), np.ones((len(lines[0]), len(lines[1]), 3))
        point[..., others[0]], point[..., others[1]] = lines[0][:, None], lines[1][None, :]
        bend[..., others[0]], bend[..., others[1]] = bends[0][:, None], bends[1][None, :]
        point[..., axis] = sides[axis] - rounding
        bend = bend / np.linalg.norm(bend, axis=-1, keepdims=True)
        rows_, columns = point.shape[:2]
        face = (point + rounding * bend).reshape(-1, 3), grid(rows_, columns, around=False)[:, ::-1]
        surfaces += [face, moved(face, scale=np.where(np.arange(3) == axis, -1.0, 1.0))]
    return welded(merged(surfaces), 1e-9 * float(sides.max()))


def sheet(points: ArrayLike, thickness: float) -> Surface:
    """A bent sheet, (rows, columns, 3) points of its middle, closed; 0 thickness leaves it open."""
    middle = np.asarray(points, dtype=float)
    rows, columns = middle.shape[:2]
    if thickness <= 0:
        return middle.reshape(-1, 3), grid(rows, columns, around=False)
    down, right = np.gradient(middle, axis=(0, 1))
    normal = np.cross(right, down)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    # There and back: one row across the sheet is a closed section.
    there, back = middle + thickness / 2 * normal, (middle - thickness / 2 * normal)[:, ::-1]
    return outwards(loft(np.concatenate([there, back], axis=1)))


def welded(surface: Surface, tolerance: float) -> Surface:
    """A surface whose vertices at the same place are one."""
    vertices, faces = surface
    _, first, index = np.unique(np.round(vertices / tolerance), axis=0, return_index=True, return_inverse=True)
    triangles = index.ravel()[faces]
    a, b, c = triangles.T
    return vertices[first], triangles[(a != b) & (b != c) & (c != a)]


def outwards(surface: Surface) -> Surface:
    """A closed surface, turned inside out if its volume is negative."""
    vertices, faces = surface
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    inside_out = float(np.einsum("ij,ij->", a, np.cross(b, c))) < 0
    return vertices, np.ascontiguousarray(faces[:, ::-1]) if inside_out else faces
